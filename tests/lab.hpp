// A world with an engine of each kind: tests and benches use the one that they are about.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "penalty/step.hpp"
#include "potential/step.hpp"
#include "rigid/step.hpp"
#include "solid/step.hpp"

namespace spall {

struct Lab : World {
  Rigid rigid;
  Potential potential{PairPotential{}};
  Penalty penalty{PenaltySettings{}};
  Elastoplastic solid{{}};

  Lab() = default;
  Lab(World&& world) : World(std::move(world)) {}  // NOLINT: a world becomes one
};

inline StepReport nonsmooth_step(Lab& lab, double h, const SolverSettings& solver, int most_steps) {
  lab.rigid.solver = solver;
  return nonsmooth_step(lab, lab.rigid, {.h = h, .most_steps = most_steps});
}
inline StepReport potential_steps(Lab& lab, double h, int most_steps) {
  return potential_steps(lab, lab.potential, {.h = h, .most_steps = most_steps});
}
inline double potential_energy(Lab& lab) {
  return potential_energy(lab, lab.potential);
}
inline StepReport penalty_steps(Lab& lab, double h, int most_steps) {
  return penalty_steps(lab, lab.penalty, {.h = h, .most_steps = most_steps});
}
inline StepReport solid_steps(Lab& lab, double h, int most_steps) {
  return solid_steps(lab, lab.solid, {.h = h, .most_steps = most_steps});
}
inline double contact_energy(Lab& lab) {
  return contact_energy(lab, lab.penalty);
}

}  // namespace spall
