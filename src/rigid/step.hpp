// One step of rigid spheres with impacts, friction, cohesion and gravity.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "rigid/contacts.hpp"
#include "rigid/engine.hpp"

namespace spall {

/// J on this rank: what cohesion would take to part the contacts, negative.
double energy_of_bonds(const World& world, const Contacts& contacts);

/// Gives the half of a kick that the last step left out, and what contacts do against it: after it
/// velocities belong to the instant of the positions. `h`: s, of the last step. Collective.
SolverReport close_nonsmooth_kick(World& world, Rigid& rigid, double h);

/// Advances the world by one step. Collective.
StepReport nonsmooth_step(World& world, Rigid& rigid, const StepRequest& request);

}  // namespace spall
