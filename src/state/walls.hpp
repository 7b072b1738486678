// Walls: half-spaces, and cylinders seen from inside.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>

#include "spall/types.hpp"

namespace spall {

/// The material of a wall that has none of its own: that of the body that meets it.
inline constexpr int same_material = -1;

/// A half-space that never moves: its surface passes through `point`, `normal` points to the free
/// side.
struct Plane {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
  int material = same_material;  ///< index into the materials
  std::string name = {};
};

/// The space outside an endless cylinder, which never moves.
struct Cylinder {
  Vec3 point = Vec3::Zero();  ///< on the axis
  Vec3 axis = Vec3::UnitZ();
  double radius = 0;             ///< m
  int material = same_material;  ///< index into the materials
  std::string name = {};
};

/// Walls by number: planes, then cylinders.
struct Walls {
  std::span<const Plane> planes;
  std::span<const Cylinder> cylinders;

  std::size_t size() const { return planes.size() + cylinders.size(); }
  int material(std::size_t wall) const {
    return wall < planes.size() ? planes[wall].material : cylinders[wall - planes.size()].material;
  }
  const std::string& name(std::size_t wall) const {
    return wall < planes.size() ? planes[wall].name : cylinders[wall - planes.size()].name;
  }
  /// m, on the plane, or on the cylinder's axis.
  const Vec3& point(std::size_t wall) const {
    return wall < planes.size() ? planes[wall].point : cylinders[wall - planes.size()].point;
  }
};

/// A wall as a point sees it.
struct Face {
  Vec3 normal;    ///< to the free side
  double height;  ///< m, of the point above the wall
};

/// A cylinder presses like the plane that touches it: spheres are small beside it.
Face face_of(const Walls& walls, std::size_t wall, const Vec3& x);

}  // namespace spall
