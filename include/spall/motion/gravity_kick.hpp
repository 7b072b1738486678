// Gravity's part of a step: evaluate the field, close the last kick, open the next.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/motion/world.hpp"

namespace spall {

/// Evaluates the field where the bodies are and gives the second half of the pending kick:
/// velocities and positions then belong to the same instant, and `kick.potential` too. Does nothing
/// when already done. Collective.
void synchronise(World& world);

/// Gives the first half of the next kick. It spans as many steps `h` as the field may be held, at
/// most `most_steps`; just one in a uniform field, where resting bodies must be loaded steadily.
/// Collective.
void open_kick(World& world, double h, int most_steps);

}  // namespace spall
