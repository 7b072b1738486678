// How fast bodies come nearer to each other, and how far ahead to look for pairs; the same for
// every force between near pairs. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/base/comm.hpp"
#include "spall/force/near_pairs.hpp"
#include "spall/force/pair_sweep.hpp"

namespace spall {

inline RowHalf half_row(const Vec3& v, double w) {
  return RowHalf{v[0], v[1], v[2], w};
}
inline Vec3 vector_of(const RowHalf& half) {
  return {half[0], half[1], half[2]};
}

/// The box that holds some vectors.
struct Box {
  RowHalf low = RowHalf{} + infinity, high = RowHalf{} - infinity;
  void add(const RowHalf& v) {
    low = v < low ? v : low;
    high = v > high ? v : high;
  }
  void add(const Vec3& v) { add(half_row(v, 0)); }
};

/// Of bodies in a step: their velocities (m/s) and the largest change of one.
struct Motion {
  Box velocities;
  double kick = infinity;
  /// Of all ranks. Collective.
  Motion united(const Comm& comm) const;
  double largest_difference() const { return vector_of(velocities.high - velocities.low).norm(); }
};

/// Nothing is known of what changed them.
Motion motion_of(const Bodies& bodies);

/// Bodies have flown like this for `h` (s) after a kick. Collective.
void book_motion(const Comm& comm, const Motion& motion, double h, NearPairs& near);

/// What a skin may be, in units of `length`.
struct SkinRange {
  double length;  ///< m
  double first, least, step, most;
  double search;  ///< a search, and looks ahead until it, cost as a sweep over so many pairs a body
};

/// m: the skin for which a step costs least if the bodies move on as since the last search. A sweep
/// costs as much as there are pairs, range^3; a search is shared by the steps until the skin is
/// used up. Counted, not timed, so that a run gives the same bits again. Collective.
double best_skin(const Comm& comm, const Bodies& bodies, const NearPairs& near,
                 const SkinRange& range);

}  // namespace spall
