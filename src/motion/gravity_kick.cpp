// Kicks act at the positions of their instant: a held force on moved bodies would exert a torque.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/motion/gravity_kick.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace spall {
namespace {

void half_kick(Bodies& bodies, const GravityField& field, double interval) {
  for (Index b = 0; b < bodies.owned; ++b)
    if (std::isfinite(bodies.mass[b])) bodies.velocity[b] += interval / 2 * field.acceleration[b];
}

}  // namespace

void synchronise(World& world) {
  GravityKick& kick = world.kick;
  if (kick.synchronised) return;
  kick.synchronised = true;
  kick.steps_left = 0;
  if (!world.has_gravity()) return;
  StageTimer timer(world.times, "gravity");
  Bodies& bodies = world.bodies;
  const auto owned = static_cast<std::size_t>(bodies.owned);
  kick.field = evaluate_gravity(world.comm, world.gravity, std::span(bodies.mass).first(owned),
                                std::span(bodies.position).first(owned),
                                std::span(bodies.velocity).first(owned));
  double largest = 0, potential = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    kick.field.acceleration[b] += world.uniform_gravity;
    if (!std::isfinite(bodies.mass[b])) continue;
    largest = std::max(largest, kick.field.acceleration[b].norm());
    potential += bodies.mass[b] *
                 (kick.field.potential[b] / 2 - world.uniform_gravity.dot(bodies.position[b]));
  }
  kick.largest = world.comm.max(largest);
  kick.potential = world.comm.sum(potential);
  ++kick.evaluations;
  half_kick(bodies, kick.field, kick.interval);
}

void open_kick(World& world, double h, int most_steps) {
  GravityKick& kick = world.kick;
  kick.synchronised = false;
  kick.steps_left = 1;
  kick.load = h;
  if (!world.has_gravity()) return;
  StageTimer timer(world.times, "gravity");
  const auto owned = static_cast<std::size_t>(world.bodies.owned);
  if (world.uniform_gravity.isZero(0)) {
    const double hold = holding_time(world.comm, world.gravity,
                                     std::span(world.bodies.mass).first(owned), kick.field);
    kick.steps_left = static_cast<int>(std::clamp(hold / h, 1.0, static_cast<double>(most_steps)));
  }
  const double closed = kick.interval;
  kick.interval = kick.steps_left * h;
  kick.load = (closed + kick.interval) / 2;
  half_kick(world.bodies, kick.field, kick.interval);
}

}  // namespace spall
