// Kicks act at the positions of their instant: a held force on moved bodies would exert a torque.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/kick.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/reduce.hpp"
#include "gravity/field.hpp"
#include "gravity/near_clumps.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// A body falls no further than this part of its radius between two kicks: a pile at rest is loaded
/// steadily enough, and bodies that start from rest do not outrun the bound on the field.
constexpr double longest_fall = 1e-3;

void kick_bodies(World& world) {
  Bodies& bodies = world.bodies;
  const double load = world.kick.load;
  for (Index b = 0; b < bodies.owned; ++b) bodies.velocity[b] += load * bodies.acceleration[b];
  if (!world.has_near_clumps()) return;
  for (Index b = 0; b < bodies.owned; ++b)
    bodies.angular_velocity[b] += load * bodies.angular_acceleration[b];
}

}  // namespace

void evaluate_field(World& world) {
  GravityKick& kick = world.kick;
  if (kick.evaluated) return;
  kick.evaluated = true;
  if (!world.has_gravity()) return;
  StageTimer timer(world.stages, "gravity");
  Bodies& bodies = world.bodies;
  require(bodies.has(Field::acceleration) &&
              (!world.has_near_clumps() || bodies.has(Field::angular_acceleration)),
          "gravity needs a field that the bodies were made without");
  const auto owned = static_cast<std::size_t>(bodies.owned);
  const auto mass = std::span(bodies.mass).first(owned);
  const auto velocity = std::span(bodies.velocity).first(kick.may_hold ? owned : 0);
  GravityField field = evaluate_gravity(world.comm, world.gravity, mass,
                                        std::span(bodies.position).first(owned), velocity);
  if (world.has_near_clumps())
    std::ranges::copy(attract_near_clumps(world, field), bodies.angular_acceleration.begin());
  const ForceChange own = kick.may_hold ? force_change(mass, field) : ForceChange{};
  std::array<double, 3> most{0, 0, own.fastest};  // acceleration, and over a radius
  double potential = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!std::isfinite(bodies.mass[b])) continue;
    bodies.acceleration[b] = field.acceleration[b] + world.uniform_gravity;
    double size = bodies.acceleration[b].norm();
    // A clump's surface is driven by more than its centre.
    if (world.has_near_clumps()) size += bodies.radius[b] * bodies.angular_acceleration[b].norm();
    most[0] = std::max(most[0], size);
    most[1] = std::max(most[1], size / bodies.radius[b]);
    potential +=
        bodies.mass[b] * (field.potential[b] / 2 - world.uniform_gravity.dot(bodies.position[b]));
  }
  std::array<double, 3> sums{potential, own.squares, own.bodies};
  reduce(world.comm, sums, most);
  kick.largest = most[0];
  kick.potential = sums[0];
  kick.fall = world.uniform_gravity.isZero(0) ? std::sqrt(longest_fall / most[1]) : 0;
  kick.hold = kick.may_hold
                  ? std::min(kick.fall, holding_time(world.gravity, {sums[1], sums[2], most[2]}))
                  : 0;
  ++kick.evaluations;
}

void give_kick(World& world, double h, int most_steps) {
  GravityKick& kick = world.kick;
  kick.evaluated = false;
  kick.steps_left = 1;
  kick.load = h;
  if (!world.has_gravity()) return;
  kick.steps_left =
      static_cast<int>(std::clamp(kick.hold / h, 1.0, static_cast<double>(most_steps)));
  kick.may_hold = kick.fall >= 2 * h;
  kick.closed = kick.interval;
  kick.interval = kick.steps_left * h;
  kick.load = (kick.closed + kick.interval) / 2;
  kick_bodies(world);
}

void close_kick(World& world) {
  GravityKick& kick = world.kick;
  kick.closed = kick.interval;
  kick.interval = 0;
  kick.load = kick.closed / 2;
  if (kick.load == 0) return;
  evaluate_field(world);
  kick_bodies(world);
}

double kick_by_own_forces(World& world, double h) {
  if (world.own_forces.empty()) return 0;
  Bodies& bodies = world.bodies;
  std::vector<Vec3> force(bodies.owned, Vec3::Zero());
  for (const OwnForce& add_force : world.own_forces) add_force(bodies, force);
  std::array<double, 2> most{-1, 0};  // id of a body whose force is no number; m/s
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!force[b].allFinite()) most[0] = static_cast<double>(bodies.id[b]);
    most[1] = std::max(most[1], h / bodies.mass[b] * force[b].norm());
  }
  world.comm.max(most);
  require(most[0] < 0, "the program's own force on body {:.0f} is not finite", most[0]);
  for (Index b = 0; b < bodies.owned; ++b) {
    if (force[b].isZero(0) || !std::isfinite(bodies.mass[b])) continue;
    const Vec3 change = h / bodies.mass[b] * force[b];
    world.ledger.own_work += bodies.mass[b] * change.dot(bodies.velocity[b] + change / 2);
    bodies.velocity[b] += change;
  }
  return most[1];
}

double work_of_kick(const World& world) {
  if (!world.has_gravity() || world.kick.load == 0) return 0;
  const Bodies& bodies = world.bodies;
  double work = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!std::isfinite(bodies.mass[b])) continue;
    const Vec3 kick = world.kick.load * bodies.acceleration[b];
    work += bodies.mass[b] * kick.dot(bodies.velocity[b] - kick / 2);
    if (!world.has_near_clumps()) continue;
    const Vec3 turn = world.kick.load * bodies.angular_acceleration[b];
    work +=
        momentum_of_spin(world.shapes, bodies, b, turn).dot(bodies.angular_velocity[b] - turn / 2);
  }
  return work;
}

}  // namespace spall
