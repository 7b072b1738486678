// One step of rigid spheres with impacts, friction, cohesion and gravity.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/motion/world.hpp"
#include "spall/solver/problem.hpp"

namespace spall {

/// What a step was; sums are over this rank's part until reduced by whoever prints them.
struct StepReport {
  SolverReport solver;
  std::int64_t contacts = 0;  ///< counted on the rank of row i
  double bonds = 0;         ///< m, sum of (range - gap) over cohesive pairs at the start: times the
                            ///< cohesion, the energy to break them all
  double gravity_work = 0;  ///< J, of the kick at the start of the step
  double overlap = 0;       ///< largest overlap over the smaller radius, on this rank
  int correction_products = 0;
};

/// Advances the world by `h` (s). Gravity's field may be held for at most `most_steps` steps, this
/// one included. Collective.
StepReport nonsmooth_step(World& world, double h, const SolverSettings& solver, int most_steps);

}  // namespace spall
