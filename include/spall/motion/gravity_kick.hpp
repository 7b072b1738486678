// Gravity's part of a step: evaluate the field where the bodies are, give the kick.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/motion/world.hpp"

namespace spall {

/// Evaluates the field, unless that is already done at this instant. Collective.
void evaluate_field(World& world);

/// Gives the kick of the present field: half of the interval since the last kick, half of the
/// interval until the next (leapfrog: velocities belong to the middle between kicks). The next
/// interval spans as many steps `h` as the field may be held, at most `most_steps`; just one in a
/// uniform field, where resting bodies must be loaded steadily. Collective.
void give_kick(World& world, double h, int most_steps);

}  // namespace spall
