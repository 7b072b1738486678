// Kicks act at the positions of their instant: a held force on moved bodies would exert a torque.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/motion/gravity_kick.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace spall {
namespace {

/// A body falls no further than this part of its radius between two kicks: a pile at rest is loaded
/// steadily enough, and bodies that start from rest do not outrun the bound on the field.
constexpr double longest_fall = 1e-3;

}  // namespace

void evaluate_field(World& world) {
  GravityKick& kick = world.kick;
  if (kick.evaluated) return;
  kick.evaluated = true;
  if (!world.has_gravity()) return;
  StageTimer timer(world.times, "gravity");
  Bodies& bodies = world.bodies;
  const auto owned = static_cast<std::size_t>(bodies.owned);
  kick.field = evaluate_gravity(world.comm, world.gravity, std::span(bodies.mass).first(owned),
                                std::span(bodies.position).first(owned),
                                std::span(bodies.velocity).first(owned));
  double largest = 0, fastest_fall = 0, potential = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    kick.field.acceleration[b] += world.uniform_gravity;
    if (!std::isfinite(bodies.mass[b])) continue;
    const double size = kick.field.acceleration[b].norm();
    largest = std::max(largest, size);
    fastest_fall = std::max(fastest_fall, size / bodies.radius[b]);
    potential += bodies.mass[b] *
                 (kick.field.potential[b] / 2 - world.uniform_gravity.dot(bodies.position[b]));
  }
  kick.largest = world.comm.max(largest);
  kick.longest = std::sqrt(longest_fall / world.comm.max(fastest_fall));
  kick.potential = world.comm.sum(potential);
  ++kick.evaluations;
}

void give_kick(World& world, double h, int most_steps) {
  GravityKick& kick = world.kick;
  Bodies& bodies = world.bodies;
  kick.evaluated = false;
  kick.steps_left = 1;
  kick.load = h;
  if (!world.has_gravity()) return;
  StageTimer timer(world.times, "gravity");
  if (world.uniform_gravity.isZero(0)) {
    const auto mass = std::span(bodies.mass).first(static_cast<std::size_t>(bodies.owned));
    const double hold =
        std::min(kick.longest, holding_time(world.comm, world.gravity, mass, kick.field));
    kick.steps_left = static_cast<int>(std::clamp(hold / h, 1.0, static_cast<double>(most_steps)));
  }
  kick.closed = kick.interval;
  kick.interval = kick.steps_left * h;
  kick.load = (kick.closed + kick.interval) / 2;
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!std::isfinite(bodies.mass[b])) continue;
    bodies.kick[b] = kick.load * kick.field.acceleration[b];
    bodies.velocity[b] += bodies.kick[b];
  }
}

}  // namespace spall
