// Small worlds of clumps for tests: a handful of bodies in, the same bodies out on every rank.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

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

}  // namespace spall
