// Worlds of spheres in penalty contact, and what tests measure of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>

#include "penalty/adhesions.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {

inline const Material soft_rock{
    .name = "rock", .density = 1600, .youngs_modulus = 1e8, .poisson_ratio = 0.25};

inline Lab penalty_world(const Comm& comm, const std::vector<Sphere>& spheres,
                         const PenaltySettings& settings, const ContactLaw& contact) {
  Lab world = make_world(comm, spheres, contact);
  for (Index b = 0; b < world.bodies.owned; ++b) world.bodies.heat[b] = 0;
  world.materials = {soft_rock};
  world.penalty.settings = settings;
  return world;
}

struct Sums {
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
  double kinetic = 0;
};
inline Sums sums_of(const std::vector<Sphere>& spheres) {
  Sums sums;
  for (const Sphere& s : spheres) {
    if (!std::isfinite(s.mass)) continue;
    const double inertia = moment_of_inertia(s.mass, s.radius);
    sums.momentum += s.mass * s.velocity;
    sums.angular += s.mass * s.position.cross(s.velocity) + inertia * s.spin;
    sums.kinetic += s.mass * s.velocity.squaredNorm() / 2 + inertia * s.spin.squaredNorm() / 2;
  }
  return sums;
}

/// Spheres at random in a cube, pressed into each other here and there, with random motion.
inline std::vector<Sphere> crowd(int count, double spread_of_radii, double speed) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const double half = 1.2 * std::cbrt(count);
  std::vector<Sphere> spheres;
  while (static_cast<int>(spheres.size()) < count) {
    Sphere s;
    s.radius = 1 + spread_of_radii * uniform(random);
    s.mass = 1000 * std::pow(s.radius, 3);
    for (int k = 0; k < 3; ++k) {
      s.position[k] = half * uniform(random);
      s.velocity[k] = speed * uniform(random);
      s.spin[k] = speed * uniform(random);
    }
    bool free = true;
    for (const Sphere& other : spheres)
      free = free && (s.position - other.position).norm() > 0.95 * (s.radius + other.radius);
    if (free) spheres.push_back(s);
  }
  return spheres;
}

}  // namespace spall
