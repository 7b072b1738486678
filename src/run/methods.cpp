// One switch a question.
// SPDX-License-Identifier: BSD-3-Clause
#include "methods.hpp"

#include <algorithm>
#include <numeric>
#include <utility>

#include "spall/motion/penalty_step.hpp"
#include "spall/motion/potential_step.hpp"

namespace spall {

void check_phase_step(const World& world, const Phase& phase, const std::string& place) {
  if (phase.method == Method::potential) {
    const auto& mass = world.bodies.mass;
    const double lightest =
        std::accumulate(mass.begin(), mass.begin() + world.bodies.owned, infinity,
                        [](double a, double b) { return std::min(a, b); });
    check_step(world.potential, phase.step, world.comm.min(lightest), closing_speed(world), place);
  }
  if (phase.method == Method::penalty)
    check_penalty_step(world.comm, world.bodies, world.penalty, world.law, phase.step,
                       largest_relative_speed(world), place);
}

StepsTaken take_steps(World& world, const Phase& phase, const SolverSettings& solver, int most,
                      bool one_by_one) {
  if (phase.method == Method::nonsmooth)
    return {1, nonsmooth_step(world, phase.step, solver, most)};
  constexpr int most_at_once = 100;  // signals, progress and restarts wait no longer
  const int steps = one_by_one ? 1 : std::min(most, most_at_once);
  const bool penalty = phase.method == Method::penalty;
  const SmoothReport done =
      penalty ? penalty_steps(world, phase.step, steps) : potential_steps(world, phase.step, steps);
  return {done.steps,
          {.solver = {.converged = true},
           .contacts = penalty ? count_touching(world.bodies, world.touch) : 0,
           .gravity_work = done.gravity_work}};
}

double elastic_energy(World& world, Method method) {
  switch (method) {
    case Method::nonsmooth:
      return 0;
    case Method::potential:
      return potential_energy(world);
    case Method::penalty:
      return contact_energy(world);
  }
  return 0;
}

ContactMemory contact_memory(const World& world, Method method) {
  return method == Method::penalty ? remember(world.bodies, world.touch)
                                   : remember(world.bodies, world.neighbours.pairs, false);
}

ContactMemory& carried_memory(World& world, Method method) {
  return method == Method::penalty ? world.touch.carried : world.neighbours.carried;
}

void forget_near_pairs(World& world, std::optional<Bonds> bonds) {
  world.near = NearPairs{};
  world.near.bonds = std::move(bonds);
}

void forget_pairs(World& world, std::optional<Bonds> bonds) {
  world.neighbours = Neighbours{};
  forget_near_pairs(world, std::move(bonds));
  world.touch = TouchPairs{};
}

}  // namespace spall
