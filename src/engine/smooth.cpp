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

SolverReport Engine::close_kick(World& world, double) {
  spall::close_kick(world);
  world.kick.load = 0;
  return {.converged = true};
}

void end_smooth_steps(World& world, int steps) {
  world.kick.evaluated = false;
  world.kick.load = 0;
  const bool held = world.gravity.method != GravityMethod::none;
  world.kick.steps_left = held ? world.kick.steps_left - steps : 0;
}

namespace {

/// 1/(kg m^2)
Mat3 inverse_inertia(const World& world, Index b) {
  const double r = world.bodies.radius[b], scale = 1 / (world.bodies.mass[b] * r * r);
  return scale * inverse_inertia_factor(world.shapes, world.bodies, b);
}

}  // namespace

HalfKick::HalfKick(const World& before)
    : velocity_(before.bodies.velocity.begin(),
                before.bodies.velocity.begin() + before.bodies.owned),
      dissipated_(before.ledger.dissipated),
      own_work_(before.ledger.own_work),
      prescribed_work_(before.ledger.prescribed_work) {
  const Bodies& bodies = before.bodies;
  if (!bodies.has(Field::angular_velocity)) return;
  spin_momentum_.reserve(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b)
    spin_momentum_.push_back(spin_momentum(before.shapes, bodies, b));
  if (before.shapes.empty()) return;
  inverse_inertia_.reserve(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b) inverse_inertia_.push_back(inverse_inertia(before, b));
}

double HalfKick::energy(const World& after, double t) const {
  const Bodies& bodies = after.bodies;
  const Vec3 field = after.steady_gravity();
  // m/2 (v + dv/2)^2 - m/2 v^2, of the whole change dv; of momenta with 1/m in place of m.
  const auto half = [](const Vec3& before, const Vec3& now, const auto& factor) {
    const Vec3 change = now - before;
    return change.dot(factor * before) / 2 + change.dot(factor * change) / 8;
  };
  const Ledger& ledger = after.ledger;
  double given = (ledger.dissipated - dissipated_ - ledger.own_work + own_work_ -
                  ledger.prescribed_work + prescribed_work_) /
                 2;
  for (std::size_t b = 0; b < velocity_.size(); ++b) {
    const double mass = bodies.mass[b];
    if (!std::isfinite(mass)) continue;
    given += half(velocity_[b], bodies.velocity[b], mass) - mass * t / 2 * field.dot(velocity_[b]);
    if (spin_momentum_.empty()) continue;
    const Index row = static_cast<Index>(b);
    given += half(spin_momentum_[b], spin_momentum(after.shapes, bodies, row),
                  inverse_inertia_.empty() ? inverse_inertia(after, row) : inverse_inertia_[b]);
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
