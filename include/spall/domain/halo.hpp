// Finds which bodies are needed as ghosts where, and fetches them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "spall/base/comm.hpp"
#include "spall/domain/ghosts.hpp"
#include "spall/scene/bodies.hpp"

namespace spall {

/// Directions in which space repeats itself: bodies lie in [low, low + size). Images are ghosts.
struct Period {
  Vec3 low = Vec3::Zero();   ///< m
  Vec3 size = Vec3::Zero();  ///< m; 0: this direction does not repeat

  bool any() const { return !size.isZero(0); }
  /// The image of `x` that lies inside.
  Vec3 wrapped(Vec3 x) const {
    for (int k = 0; k < 3; ++k)
      if (size[k] > 0) x[k] -= size[k] * std::floor((x[k] - low[k]) / size[k]);
    return x;
  }
};

/// Appends as ghosts all bodies of other ranks whose sphere, grown by its own reach, may meet a
/// sphere of this rank, grown by its reach (m, one an owned body; any sizes: a nucleus larger than
/// a subdomain becomes a ghost wherever it reaches). Returns the plan that keeps them current, and
/// grows `reach` by the ghosts' rows. Collective. Where space repeats itself images of bodies, this
/// rank's own too, are ghosts at their places; `shifts` (m, one a ghost) must be added to them
/// again after each update.
Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach, const Period& period,
                 std::vector<Vec3>& shifts);
inline Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach) {
  std::vector<Vec3> none;
  return make_halo(comm, bodies, reach, {}, none);
}

/// Brings position, velocities and acceleration of all ghosts up to date. Collective.
void refresh_ghosts(const Ghosts& ghosts, Bodies& bodies);

}  // namespace spall
