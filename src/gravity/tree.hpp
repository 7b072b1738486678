// Gravity by a tree of multipoles that keeps momentum: cells attract each other in pairs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <span>

#include "gravity/field.hpp"

namespace spall {

/// How a tree is to be used. Two cells attract each other by multipoles if the terms left out are
/// estimated below `accuracy` times the acceleration of either, and the sum of their radii is less
/// than `opening` times their distance; leaves that are closer attract each other body by body.
struct TreeSettings {
  int order = 5;           ///< of the multipoles: 4 … 6
  double opening = 0.9;    ///< below 1, or the series does not converge
  double accuracy = 1e-4;  ///< of one pair of cells
  int leaf_size = 32;      ///< bodies

  /// Of a light leaf, over the distance on which the field changes: see `grow_octree`.
  double reach() const { return std::pow(accuracy, 1.0 / order); }
};

/// The cheapest settings whose rms relative force error was measured to be below `accuracy`.
TreeSettings tree_settings(double accuracy);

/// The field of all bodies at the owned bodies. Without velocities on any rank the rate is left
/// out. Collective.
GravityField evaluate_gravity_tree(const Comm& comm, double constant, const TreeSettings& settings,
                                   std::span<const double> mass, std::span<const Vec3> position,
                                   std::span<const Vec3> velocity);

}  // namespace spall
