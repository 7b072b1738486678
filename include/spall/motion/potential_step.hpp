// Steps of bodies bound by pair potentials: leapfrog as drift, kick, drift.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "spall/motion/gravity_kick.hpp"

namespace spall {

/// Advances the world by up to `most_steps` steps of `h` (s), the last of which ends at the next
/// kick of gravity at the latest; positions and velocities belong to its end. Collective.
SmoothReport potential_steps(World& world, double h, int most_steps);

/// J over all ranks, of the pairs as they are. Collective.
double potential_energy(World& world);

/// Calls `f(i, j, bound)` with the rows of all pairs nearer than `distance` (m), at most the range
/// of the last search; bound: the pair attracts, as all do where bonds do not break. A pair with a
/// ghost is on both ranks. Ghosts are those of world.near. Collective.
void for_each_near_pair(World& world, double distance,
                        const std::function<void(Index, Index, bool)>& f);

/// m/s, at most: the speed at which two bodies meet if they fly straight on. Collective.
double closing_speed(const World& world);

}  // namespace spall
