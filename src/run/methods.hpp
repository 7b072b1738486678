// What each method of phases does in its own way: steps, their check, energy, memory of contacts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "spall/motion/nonsmooth_step.hpp"

namespace spall {

/// An Error that begins with `place` where the phase's step is too long for its forces. Collective.
void check_phase_step(const World& world, const Phase& phase, const std::string& place);

struct StepsTaken {
  int steps;
  StepReport report;
};
/// Advances the world by one step where contacts are solved for; by as many as may pass until
/// gravity's next kick, but at most `most`, where forces are explicit, unless `one_by_one`.
/// Collective.
StepsTaken take_steps(World& world, const Phase& phase, const SolverSettings& solver, int most,
                      bool one_by_one);

/// J over all ranks: what pair potentials or penalty contact hold, as the pairs are; else 0.
/// Collective.
double elastic_energy(World& world, Method method);

/// Impulses or springs of the present contacts, by ids.
ContactMemory contact_memory(const World& world, Method method);
/// Where the next search for pairs takes them from.
ContactMemory& carried_memory(World& world, Method method);

/// The next step searches pairs anew, of which these are bound.
void forget_near_pairs(World& world, std::optional<Bonds> bonds);
void forget_pairs(World& world, std::optional<Bonds> bonds);

}  // namespace spall
