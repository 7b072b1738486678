// Small worlds of clumps for tests: a handful of bodies in, the same bodies out on every rank.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <random>
#include <vector>

#include "engine/free_turn.hpp"
#include "state/body_shape.hpp"
#include "worlds.hpp"

namespace spall {

inline const Plane floor_plane{.point = Vec3::Zero(), .normal = Vec3::UnitZ()};

/// A body with a shape, which may be the sphere.
struct ShapedBody {
  std::int32_t shape = 1;
  double radius = 1;  ///< m
  double mass = 1;    ///< kg
  Vec3 position = Vec3::Zero(), velocity = Vec3::Zero(), spin = Vec3::Zero();
  Quaternion orientation = Quaternion::Identity();
};

inline BodyShapes with_sphere(std::vector<BodyShape> others) {
  BodyShapes shapes(1);
  shapes[0].name = "sphere";
  shapes.insert(shapes.end(), others.begin(), others.end());
  return shapes;
}

inline Lab make_world(const Comm& comm, const BodyShapes& shapes,
                      const std::vector<ShapedBody>& clumps, const ContactLaw& law) {
  std::vector<Sphere> spheres;
  for (const ShapedBody& c : clumps)
    spheres.push_back({c.radius, c.mass, c.position, c.velocity, c.spin});
  Lab world = make_world(comm, spheres, law);
  world.shapes = shapes;
  Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) {
    bodies.shape[b] = clumps[bodies.id[b]].shape;
    bodies.orientation[b] = clumps[bodies.id[b]].orientation;
  }
  return world;
}

inline Vec3 random_vector(std::mt19937_64& random) {
  std::uniform_real_distribution<double> one(-1, 1);
  const double x = one(random), y = one(random), z = one(random);
  return {x, y, z};
}

inline Quaternion random_turn(std::mt19937_64& random) {
  const Vec3 axis = random_vector(random);
  return turned_by(3 * axis, Quaternion::Identity());
}

inline BodyShape dumbbell() {
  const std::array<ShapeSphere, 2> two{{{Vec3(1.2, 0, 0), 1}, {Vec3(-0.5, 0, 0), 0.8}}};
  return make_shape("dumbbell", two);
}

inline BodyShape boulder() {
  return make_shape("boulder", fill_ellipsoid(Vec3(2, std::sqrt(2.0), 1), 7));
}

/// Clumps and spheres at random, their outer spheres apart by `gap` times their radii.
inline std::vector<ShapedBody> cloud_of_clumps(int count, double edge, double nearest,
                                               double speed) {
  std::mt19937_64 random(7);
  std::vector<ShapedBody> clumps;
  while (std::ssize(clumps) < count) {
    ShapedBody clump{.shape = static_cast<std::int32_t>(clumps.size() % 3),
                     .radius = clumps.size() % 4 == 0 ? 1.3 : 1,
                     .mass = clumps.size() % 4 == 0 ? 2.0 : 1.0,
                     .position = edge / 2 * random_vector(random)};
    if (std::ranges::any_of(clumps, [&](const ShapedBody& other) {
          return (other.position - clump.position).norm() < nearest;
        }))
      continue;
    clump.velocity = speed * random_vector(random);
    clump.spin = speed * random_vector(random);
    clump.orientation = random_turn(random);
    clumps.push_back(clump);
  }
  return clumps;
}

}  // namespace spall
