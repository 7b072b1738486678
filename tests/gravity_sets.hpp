// Sets of bodies for the tests of gravity.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

struct Points {
  std::vector<double> mass;
  std::vector<Vec3> position, velocity;
  std::size_t size() const { return mass.size(); }
};

/// A ball of bodies, the same on every rank; masses over six decades, as radii 100 : 1 give.
inline Points random_ball(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Points points;
  while (points.size() < count) {
    const Vec3 place(uniform(random), uniform(random), uniform(random));
    if (place.norm() > 1) continue;
    points.position.push_back(80 * place);
    points.velocity.push_back(0.1 * Vec3(uniform(random), uniform(random), uniform(random)));
    points.mass.push_back(1e5 * std::pow(10.0, 3 * uniform(random)));
  }
  return points;
}

/// The rows of `all` that `comm.rank` owns: unequal shares, and none on rank 1 of three or more.
inline Points share(const Comm& comm, const Points& all) {
  Points mine;
  for (std::size_t b = 0; b < all.size(); ++b) {
    int owner = static_cast<int>((b * b / 7) % comm.size);
    if (comm.size >= 3 && owner == 1) owner = 0;
    if (owner != comm.rank) continue;
    mine.mass.push_back(all.mass[b]);
    mine.position.push_back(all.position[b]);
    mine.velocity.push_back(all.velocity[b]);
  }
  return mine;
}

/// |sum F| / sum |F| and the same of torques. Collective.
inline std::array<double, 2> net_force_and_torque(const Comm& comm, const Points& mine,
                                                  const std::vector<Vec3>& acceleration) {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  double forces = 0, torques = 0;
  for (std::size_t b = 0; b < mine.size(); ++b) {
    const Vec3 f = mine.mass[b] * acceleration[b];
    force += f;
    torque += mine.position[b].cross(f);
    forces += f.norm();
    torques += mine.position[b].norm() * f.norm();
  }
  return {comm.sum(force).norm() / comm.sum(forces), comm.sum(torque).norm() / comm.sum(torques)};
}

/// Equal bodies in a cube.
inline Points random_cube(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Points points{std::vector<double>(count, 1e5), std::vector<Vec3>(count),
                std::vector<Vec3>(count, Vec3::Zero())};
  for (Vec3& x : points.position) x = 80 * Vec3(uniform(random), uniform(random), uniform(random));
  return points;
}

/// Plummer's sphere: a core, and a halo whose density falls with the fifth power of the distance.
inline Points plummer_sphere(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Points points = random_cube(count, seed);
  for (Vec3& x : points.position)
    x *= 80 / x.norm() / std::sqrt(std::pow(uniform(random), -2.0 / 3) - 1);
  return points;
}

/// Two touching balls, radii 10 : 1 and of one density, in a thin cloud that reaches a hundred
/// radii.
inline Points pile_and_ejecta(std::size_t count, unsigned seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  Points points = random_ball(count, seed);
  for (std::size_t b = 0; b < count; ++b) {
    Vec3& x = points.position[b];
    points.mass[b] = 1e6;
    if (b % 10 == 0) {
      x = x.normalized() * 80 * std::pow(10, 2 * uniform(random));
      points.velocity[b] = x / 100;
      points.mass[b] = 1e4;
    } else if (b % 2 == 0) {
      x = x / 10 + Vec3(88, 0, 0);
      points.mass[b] = 1e3;
    }
  }
  return points;
}

}  // namespace spall
