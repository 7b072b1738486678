// Gravity's kicks stand between runs of smooth steps; a uniform field alone needs none of them.
// SPDX-License-Identifier: BSD-3-Clause
#include "engine/smooth.hpp"

#include <algorithm>
#include <cmath>

namespace spall {

StepReport begin_smooth_steps(World& world, double h, int most_steps) {
  StepReport report{.steps = most_steps, .solver = {.converged = true}};
  if (world.gravity.method == GravityMethod::none) {
    close_kick(world);
    report.gravity_work = work_of_kick(world);
    return report;
  }
  if (world.kick.steps_left == 0) {
    evaluate_field(world);
    give_kick(world, h, most_steps);
    report.gravity_work = work_of_kick(world);
  }
  report.steps = std::min(most_steps, world.kick.steps_left);
  return report;
}

void end_smooth_steps(World& world, int steps) {
  world.kick.evaluated = false;
  world.kick.load = 0;
  world.kick.steps_left = world.has_gravity() ? world.kick.steps_left - steps : 0;
}

}  // namespace spall
