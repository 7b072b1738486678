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
  const bool held = world.gravity.method != GravityMethod::none;
  world.kick.steps_left = held ? world.kick.steps_left - steps : 0;
}

HalfKick::HalfKick(const World& before)
    : velocity_(before.bodies.velocity.begin(),
                before.bodies.velocity.begin() + before.bodies.owned),
      dissipated_(before.ledger.dissipated),
      own_work_(before.ledger.own_work) {
  if (before.bodies.has(Field::angular_velocity))
    spin_.assign(before.bodies.angular_velocity.begin(),
                 before.bodies.angular_velocity.begin() + before.bodies.owned);
}

double HalfKick::energy(const World& after, double t) const {
  const Bodies& bodies = after.bodies;
  const Vec3 field = after.steady_gravity();
  // m/2 (v + dv/2)^2 - m/2 v^2, of the whole change dv.
  const auto half = [](const Vec3& before, const Vec3& now) {
    const Vec3 change = now - before;
    return change.dot(before) / 2 + change.squaredNorm() / 8;
  };
  double given = (after.ledger.dissipated - dissipated_ - after.ledger.own_work + own_work_) / 2;
  for (std::size_t b = 0; b < velocity_.size(); ++b) {
    const double mass = bodies.mass[b];
    if (!std::isfinite(mass)) continue;
    given += mass * (half(velocity_[b], bodies.velocity[b]) - t / 2 * field.dot(velocity_[b]));
    if (!spin_.empty())
      given +=
          moment_of_inertia(mass, bodies.radius[b]) * half(spin_[b], bodies.angular_velocity[b]);
  }
  return given;
}

void wrap_bodies(World& world) {
  if (!world.period.any()) return;
  Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) {
    const Vec3 inside = world.period.wrapped(bodies.position[b]);
    if (std::isfinite(bodies.mass[b]))
      world.ledger.fallen +=
          bodies.mass[b] * world.uniform_gravity.dot(bodies.position[b] - inside);
    bodies.position[b] = inside;
  }
}

}  // namespace spall
