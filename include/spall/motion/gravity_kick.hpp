// Gravity's part of a step: evaluate the field where the bodies are, give the kick.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/motion/world.hpp"

namespace spall {

/// Evaluates the field (the bodies' acceleration), unless that is already done at this instant.
/// Collective.
void evaluate_field(World& world);

/// Gives the kick of the present field: half of the interval since the last kick, half of the
/// interval until the next (leapfrog: velocities belong to the middle between kicks). The next
/// interval spans as many steps `h` as the field may be held, at most `most_steps`; just one in a
/// uniform field, where resting bodies must be loaded steadily. Collective.
void give_kick(World& world, double h, int most_steps);

/// What steps of smooth forces (penalty contact, pair potentials) were; sums are over this rank's
/// part until reduced by whoever prints them.
struct SmoothReport {
  int steps = 0;            ///< made
  double gravity_work = 0;  ///< J, of the kick at the start
};

/// Gives the kick that is due and says how many steps of `h` may follow: up to `most_steps`, the
/// last of which ends at the next kick at the latest. Collective.
SmoothReport begin_smooth_steps(World& world, double h, int most_steps);
/// They were made: bodies have moved.
void end_smooth_steps(World& world, int steps);

}  // namespace spall
