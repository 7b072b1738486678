// Steps of bodies bound by pair potentials: leapfrog as drift, kick, drift.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>

#include "potential/engine.hpp"

namespace spall {

/// Advances the world as `smooth_steps` does. Collective.
StepReport potential_steps(World& world, Potential& engine, const StepRequest& request);

/// J over all ranks, of the pairs as they are, which are found where they are not known.
/// Collective.
double potential_energy(World& world, Potential& engine);

/// Calls `f(i, j, x, bound)` with the rows of all pairs within the range of the law, x (m) from i
/// to j; bound: the pair attracts, as all do where bonds do not break. A pair with a ghost is on
/// both ranks. Collective.
void for_each_near_pair(const World& world, const Potential& engine,
                        const std::function<void(Index, Index, const Vec3&, bool)>& f);

/// m/s, at most: the speed at which two bodies meet within `lasts` (s), those of no moving group if
/// they fly straight on. Collective.
double closing_speed(const World& world, const ByPair<PairPotential>& laws, double lasts);

}  // namespace spall
