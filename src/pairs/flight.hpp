// The box of all velocities bounds how soon pairs must be found anew; how far ahead to look then.
// The same for every force between near pairs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "pairs/near_pairs.hpp"
#include "spall/comm.hpp"
#include "spall/lanes.hpp"
#include "state/world.hpp"

namespace spall {

inline RowHalf half_row(const Vec3& v, double w) {
  return RowHalf{v[0], v[1], v[2], w};
}
inline Vec3 vector_of(const RowHalf& half) {
  return {half[0], half[1], half[2]};
}

/// The box that holds some vectors.
struct RowBox {
  RowHalf low = RowHalf{} + infinity, high = RowHalf{} - infinity;
  void add(const RowHalf& v) {
    low = smaller(v, low);
    high = larger(v, high);
  }
  void add(const Vec3& v) { add(half_row(v, 0)); }
  /// All within `r` of `v`.
  void add(const Vec3& v, double r) {
    add(half_row(v, 0) - r);
    add(half_row(v, 0) + r);
  }
  void add(const RowBox& other) {
    low = smaller(other.low, low);
    high = larger(other.high, high);
  }
  /// Of the boxes of all ranks. Collective.
  RowBox united(const Comm& comm) const;
  Vec3 centre() const { return vector_of((low + high) / 2); }
  double diagonal() const { return vector_of(high - low).norm(); }
};

/// Of all bodies, the spheres of clumps included, and of what stands still where there are walls.
RowBox velocities_with_walls(const World& world);

/// m, that two of the owned `bodies` have come nearer at most since they were at `from`: twice the
/// radius of the displacements about the centre of their box. A common motion counts for nothing,
/// but to the world's walls. Not place by place as `MotionCells`: where space repeats itself, and
/// with giants, bodies meet from afar. Collective.
double approach_from(const World& world, const Bodies& bodies, std::span<const Vec3> from);

/// m, that two bodies have come nearer at most since the last search: place by place where none
/// meet from afar, else as `approach_from`. Collective.
double approach_since_search(const World& world, const NearPairs& near);

/// Bodies have flown at these velocities for `h` (s): no two came nearer by more than the diagonal.
/// Collective.
void book_motion(const Comm& comm, const RowBox& velocities, double h, NearPairs& near);

/// How many pairs are listed, as a function of the gap up to which they are: so many bodies lie in
/// a sphere as large as two bodies that meet, grown by that gap.
struct Crowd {
  double diameter, square, cube;  ///< m, m^2, m^3: means of r_i + r_j and its powers

  /// m^3, of the mean of (r_i + r_j + gap)^3.
  double volume(double gap) const { return cube + gap * (3 * square + gap * (3 * diameter + gap)); }
};

/// Of the bodies of all ranks that are not larger than `largest` (m). Collective.
Crowd crowd_of(const Comm& comm, const Bodies& bodies, double largest);

/// What a skin may be, in units of `length`.
struct SkinRange {
  double length;  ///< m
  double first, least, step, most;
  double search;  ///< a search costs as much as a sweep over so many pairs a body
  /// Inner lists that follow each other between two searches, and what one costs, of a sweep over
  /// as many pairs as are listed. Sweeps go over those that are listed for their share of the skin.
  double lists = 1, list = 0;
};

/// For bodies in a lattice of this spacing (m).
constexpr SkinRange skins_of_lattice(double spacing) {
  return {.length = spacing, .first = 0.3, .least = 0.1, .step = 0.05, .most = 1.5, .search = 250};
}

/// m: the skin for which a step costs least if the bodies move on as since the last search. A sweep
/// costs as much as there are pairs in its list; a search, and inner lists where there are any, are
/// shared by the steps until the skin is used up.
/// Bodies act on each other up to `gap` (m) between the surfaces of the crowd. Counted, not timed,
/// so that a run gives the same bits again. Collective.
double best_skin(const Comm& comm, const Bodies& bodies, const NearPairs& near, const Crowd& crowd,
                 double gap, const SkinRange& range);

}  // namespace spall
