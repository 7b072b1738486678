// How much nearer to each other bodies have come since their pairs were found, and how far ahead to
// look for the next ones; the same for every force between near pairs.
// SPDX-License-Identifier: BSD-3-Clause
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
  /// Of the boxes of all ranks. Collective.
  Box united(const Comm& comm) const;
  Vec3 centre() const { return vector_of((low + high) / 2); }
  double diagonal() const { return vector_of(high - low).norm(); }
};

Box velocities_of(const Bodies& bodies);

/// Bodies have flown at these velocities for `h` (s): no two came nearer by more than the diagonal.
/// Collective.
void book_motion(const Comm& comm, const Box& velocities, double h, NearPairs& near);

/// m, that two bodies have come nearer at most since the pairs were found, with the place (a Vec3)
/// where a body is now: twice the radius of the displacements about the centre of their box. A
/// common motion counts for nothing, but to what stands still. Collective.
template <class Place>
double displacement(const Comm& comm, const NearPairs& near, bool against_walls, Place&& place) {
  const auto moved = [&](std::size_t b) -> Vec3 {
    return place(static_cast<Index>(b)) - near.found_at[b];
  };
  Box box;
  for (std::size_t b = 0; b < near.found_at.size(); ++b) box.add(moved(b));
  const Vec3 centre = box.united(comm).centre();
  double furthest = 0;
  for (std::size_t b = 0; b < near.found_at.size(); ++b) {
    furthest = std::max(furthest, 4 * (moved(b) - centre).squaredNorm());
    if (against_walls) furthest = std::max(furthest, moved(b).squaredNorm());
  }
  return std::sqrt(comm.max(furthest));
}

/// What a skin may be, in units of `length`.
struct SkinRange {
  double length;  ///< m
  double first, least, step, most;
  double search;  ///< a search costs as much as a sweep over so many pairs a body
};

/// m: the skin for which a step costs least if the bodies move on as since the last search. A sweep
/// costs as much as there are pairs, range^3; a search is shared by the steps until the skin is
/// used up. Counted, not timed, so that a run gives the same bits again. Collective.
double best_skin(const Comm& comm, const Bodies& bodies, const NearPairs& near,
                 const SkinRange& range);

}  // namespace spall
