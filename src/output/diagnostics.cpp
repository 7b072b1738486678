// One pass over the owned bodies and one reduction.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/diagnostics.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace spall {

Diagnostics diagnose(const World& world) {
  const Bodies& bodies = world.bodies;
  Diagnostics d;
  double translation = 0, rotation = 0, squares = 0, pull = 0;
  Vec3 moment = Vec3::Zero();
  for (Index b = 0; b < bodies.owned; ++b) {
    const double m = bodies.mass[b];
    if (!std::isfinite(m)) continue;
    const Vec3 &x = bodies.position[b], &v = bodies.velocity[b];
    d.mass += m;
    moment += m * x;
    squares += m * x.squaredNorm();
    d.momentum += m * v;
    d.angular_momentum += m * x.cross(v);
    d.momentum_scale += m * v.norm();
    d.angular_momentum_scale += m * x.norm() * v.norm();
    translation += m * v.squaredNorm() / 2;
    if (world.has_gravity()) pull += m * bodies.acceleration[b].squaredNorm() / 2;
    if (!bodies.has(Field::angular_velocity)) continue;
    if (!world.shapes.empty()) {
      const Vec3 spin = spin_momentum(world.shapes, bodies, b);
      d.angular_momentum += spin;
      rotation += spin.dot(bodies.angular_velocity[b]) / 2;
      continue;
    }
    const double inertia = moment_of_inertia(m, bodies.radius[b]);
    d.angular_momentum += inertia * bodies.angular_velocity[b];
    rotation += inertia * bodies.angular_velocity[b].squaredNorm() / 2;
  }
  Reaction received;
  for (const auto* all : {&world.reactions.of_walls, &world.reactions.of_groups})
    for (const Reaction& one : *all) {
      received.impulse += one.impulse;
      received.moment += one.moment;
    }
  std::array<double, 28> sums{d.mass,
                              moment[0],
                              moment[1],
                              moment[2],
                              d.momentum[0],
                              d.momentum[1],
                              d.momentum[2],
                              d.angular_momentum[0],
                              d.angular_momentum[1],
                              d.angular_momentum[2],
                              d.momentum_scale,
                              d.angular_momentum_scale,
                              translation,
                              rotation,
                              world.ledger.dissipated,
                              world.ledger.corrections,
                              squares,
                              world.ledger.own_work,
                              world.ledger.fallen,
                              world.ledger.prescribed_work,
                              received.impulse[0],
                              received.impulse[1],
                              received.impulse[2],
                              received.moment[0],
                              received.moment[1],
                              received.moment[2],
                              world.ledger.gained,
                              pull};
  world.comm.sum(sums);
  d.mass = sums[0];
  d.centre = d.mass > 0 ? Vec3(Vec3(sums[1], sums[2], sums[3]) / d.mass) : Vec3::Zero();
  if (d.mass > 0)
    d.gyration_radius = std::sqrt(std::max(0.0, sums[16] / d.mass - d.centre.squaredNorm()));
  d.momentum = {sums[4], sums[5], sums[6]};
  d.angular_momentum = {sums[7], sums[8], sums[9]};
  d.momentum_scale = sums[10];
  d.angular_momentum_scale = sums[11];
  d.kinetic = sums[12] + sums[13];
  d.rms_speed = d.mass > 0 ? std::sqrt(2 * sums[12] / d.mass) : 0;
  d.dissipated = sums[14];
  d.corrections = sums[15];
  d.own_work = sums[17];
  d.fallen = sums[18];
  d.prescribed_work = sums[19];
  d.gained = sums[26];
  const double h = std::max(world.kick.interval, world.kick.closed);
  d.fall = sums[27] * h * h;
  d.given_momentum = -Vec3(sums[20], sums[21], sums[22]);
  d.given_angular_momentum = -Vec3(sums[23], sums[24], sums[25]);
  return d;
}

namespace {

bool is_finite(const Bodies& bodies, Index b) {
  return bodies.position[b].allFinite() && bodies.velocity[b].allFinite() &&
         (!bodies.has(Field::angular_velocity) || bodies.angular_velocity[b].allFinite());
}

}  // namespace

Index first_lost(const Bodies& bodies) {
  Index b = 0;
  while (b < bodies.owned && is_finite(bodies, b)) ++b;
  return b;
}

double first_lost_id(const Comm& comm, const Bodies& bodies) {
  double id = infinity;
  for (Index b = first_lost(bodies); b < bodies.owned; ++b)
    if (!is_finite(bodies, b)) id = std::min(id, static_cast<double>(bodies.id[b]));
  return comm.min(id);
}

}  // namespace spall
