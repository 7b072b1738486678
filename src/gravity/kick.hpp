// Gravity's part of a step: evaluate the field where the bodies are, give the kick.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "state/world.hpp"

namespace spall {

/// Evaluates the field (the bodies' acceleration), unless that is already done at this instant.
/// Collective.
void evaluate_field(World& world);

/// Gives the kick of the present field. It covers half of the interval since the last kick and half
/// of the one until the next, as in leapfrog: velocities belong to the middle between kicks. The
/// next interval spans as many steps `h` (s) as the field may be held, at most `most_steps`. In a
/// uniform field it is one step, since resting bodies must be loaded steadily. Collective.
void give_kick(World& world, double h, int most_steps);

/// Gives the half of the last kick's interval that is still due: velocities belong to this instant.
/// Collective.
void close_kick(World& world);

/// The kick over `h` (s) by the forces of the program that uses Spall, at present positions; its
/// work is booked. Returns m/s, the most that it gave a body of any rank. Collective.
double kick_by_own_forces(World& world, double h);

/// J on this rank, of the kick that was just given.
double work_of_kick(const World& world);

}  // namespace spall
