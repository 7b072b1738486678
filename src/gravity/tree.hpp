// Gravity by a tree of multipoles that keeps momentum: cells attract each other in pairs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <span>

#include "base/traffic.hpp"
#include "gravity/field.hpp"

namespace spall {

/// How a tree is to be used. Two cells attract each other by multipoles if the terms left out are
/// estimated below `accuracy` times the acceleration of either, and the sum of their radii is less
/// than `opening` times their distance; leaves that are closer attract each other body by body.
struct TreeSettings {
  int order = 6;           ///< of the multipoles: 4, 6 or 8
  double opening = 0.9;    ///< below 1, or the series does not converge
  double accuracy = 1e-4;  ///< of one pair of cells
  int leaf_size = 32;      ///< bodies

  /// Of a light leaf, over the distance on which the field changes: see `grow_octree`.
  double reach() const { return std::pow(accuracy, 1.0 / order); }
};

/// The cheapest settings whose rms relative force error was measured to be below `accuracy`.
TreeSettings tree_settings(double accuracy);

/// What one evaluation of the tree sends from one of many ranks.
struct TreeShare {
  std::int64_t bodies = 0;  ///< of its part of the curve
  Traffic traffic;
};

/// What an evaluation would send from each of the ranks `sample` if body b were owned by rank
/// `owner[b]` of `ranks`. All bodies are here; their velocities are given where rates are asked
/// for.
std::vector<TreeShare> foretell_gravity_tree(const Comm& alone, const TreeSettings& settings,
                                             std::span<const double> mass,
                                             std::span<const Vec3> position,
                                             std::span<const Vec3> velocity,
                                             std::span<const int> owner, int ranks,
                                             std::span<const int> sample);

/// The field of all bodies at the owned bodies. Without velocities on any rank the rate is left
/// out. Collective.
GravityField evaluate_gravity_tree(const Comm& comm, double constant, const TreeSettings& settings,
                                   std::span<const double> mass, std::span<const Vec3> position,
                                   std::span<const Vec3> velocity);

}  // namespace spall
