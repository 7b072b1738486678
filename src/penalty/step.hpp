// Steps of bodies that touch by springs and dashpots: leapfrog as drift, kick, drift.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "penalty/engine.hpp"

namespace spall {

/// Advances the world as `smooth_steps` does. Throws Error, on every rank, where bodies have become
/// too fast for the step. Collective.
StepReport penalty_steps(World& world, Penalty& engine, const StepRequest& request);

/// J over all ranks: elastic, of overlaps as they are, and of cohesion, which is negative. Springs
/// are not in it: what they hold counts as dissipated until they give it back. Pairs are found
/// where they are not known. Collective.
double contact_energy(World& world, Penalty& engine);

}  // namespace spall
