// How much nearer to each other bodies that are not listed as a pair have come, and so whether
// pairs must be found anew.
//
// Such a pair was at least its reach and the skin apart when pairs were found: the sum of what each
// of its bodies has of both. So it is nearer by no more than the displacements of its bodies
// differ, and by no more than that length less their distance now. A tree of boxes around the
// places and around the displacements of bodies, along the curve on which pairs were found, bounds
// both for many pairs at once; it is compared with itself, down to the bodies themselves where
// boxes do not settle it. So what flies apart, or past each other far away, counts for nothing.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "spall/base/comm.hpp"
#include "spall/domain/halo.hpp"
#include "spall/force/lanes.hpp"
#include "spall/force/near_pairs.hpp"

namespace spall {

/// Eight bodies that follow each other on the curve.
struct Leaf {
  Lanes place[3], moved[3];  ///< m, now and since the pairs were found
  Lanes ahead[3];            ///< m, what is added to both until one looks again
  Lanes half;                ///< m: a pair is listed if it was nearer than the sum of its two
};

/// m, that two bodies that are no pair come nearer at most until then, not less than `least`; if it
/// is more than `skin`, it may be less than the most. Collective: ranks send each other the leaves
/// that come near the box around all bodies of a rank, and displace themselves against them.
double furthest_approach(const Comm& comm, const Period& period, const std::vector<Leaf>& leaves,
                         double least, double skin);

/// Makes the bound of `near` what is true of the places (a Vec3) where bodies are now and at these
/// velocities for a while: half of the time since the pairs were found. So one looks a few times
/// until they are used up. `half` is that of a leaf. Against walls the furthest counts that a body
/// has come. Collective.
template <class Place, class Half>
void look_ahead(const Comm& comm, const Period& period, const std::vector<Vec3>& velocity,
                bool against_walls, Place&& place, Half&& half, NearPairs& near) {
  constexpr int parts = 2;
  const double time = near.outlook.time, ahead = time / std::min(parts, near.steps + 1);
  const std::size_t count = near.curve.size();
  std::vector<Leaf> leaves((count + lane_count - 1) / lane_count);
  double furthest = 0;
  for (std::size_t k = 0; k < leaves.size() * lane_count; ++k) {
    // The last body fills up the last leaf.
    const Index b = near.curve[std::min(k, count - 1)];
    const Vec3 now = place(b), moved = now - near.found_at[b];
    Leaf& leaf = leaves[k / lane_count];
    const std::size_t lane = k % lane_count;
    for (int axis = 0; axis < 3; ++axis) {
      leaf.place[axis][lane] = now[axis];
      leaf.moved[axis][lane] = moved[axis];
      leaf.ahead[axis][lane] = ahead * velocity[b][axis];
    }
    leaf.half[lane] = half(b);
    if (against_walls)
      furthest = std::max({furthest, moved.norm(), (moved + ahead * velocity[b]).norm()});
  }
  near.moved =
      furthest_approach(comm, period, leaves, std::max(furthest, near.skin / 2), near.skin);
  near.outlook = {.time = time, .moved = near.moved, .ahead = ahead};
}

}  // namespace spall
