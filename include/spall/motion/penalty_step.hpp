// Steps of bodies that touch by springs and dashpots: leapfrog as drift, kick, drift.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/motion/world.hpp"

namespace spall {

/// What the steps were; sums are over this rank's part until reduced by whoever prints them.
struct PenaltyReport {
  int steps = 0;              ///< made
  double gravity_work = 0;    ///< J, of the kick at the start
  std::int64_t contacts = 0;  ///< that touched in the last step
};

/// Advances the world by up to `most_steps` steps of `h` (s), the last of which ends at the next
/// kick of gravity at the latest; positions and velocities belong to its end. Throws Error, on
/// every rank, where bodies have become too fast for the step. Collective.
PenaltyReport penalty_steps(World& world, double h, int most_steps);

/// J over all ranks: elastic, of overlaps as they are, and of cohesion, which is negative. Springs
/// are not in it: what they hold counts as dissipated until they give it back. Collective.
double contact_energy(World& world);

}  // namespace spall
