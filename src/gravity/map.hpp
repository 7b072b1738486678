// The gravity field of the bodies at the points of a grid: outside, between and inside them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "gravity/field.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Points `spacing` apart in all directions, x fastest; a size of 0 leaves one point along an axis.
struct Grid {
  Vec3 low = Vec3::Zero();  ///< m
  double spacing = 0;       ///< m
  std::array<std::int64_t, 3> counts = {1, 1, 1};

  /// As many points as fit into a box of these full widths about `center`, evenly about it.
  static Grid in_box(const Vec3& center, const Vec3& size, double spacing);
  std::int64_t total() const { return counts[0] * counts[1] * counts[2]; }
  Vec3 place(std::int64_t point) const;
};

/// Of this rank's equal part of the grid's points, in their order.
struct GravityMap {
  std::int64_t first = 0;
  std::vector<double> potential;   ///< J/kg, 0 far away
  std::vector<Vec3> acceleration;  ///< m/s^2
};

/// The field of the bodies as uniform spheres: beyond a body's surface that of its mass at its
/// centre, inside of it -G m (3 r^2 - d^2)/(2 r^3). A uniform field is left out. Collective.
GravityMap map_gravity(const Comm& comm, const GravitySettings& settings, const Bodies& bodies,
                       const Grid& grid);

}  // namespace spall
