// Gravity by a tree of multipoles that keeps momentum: cells attract each other in pairs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "spall/force/gravity.hpp"

namespace spall {

/// How a tree is to be used: two cells attract each other by multipoles up to `order` (3 … 5) if
/// the sum of their radii is less than `opening` times their distance; leaves that are closer
/// attract each other body by body.
struct TreeSettings {
  int order = 4;
  double opening = 0.9;
  double accuracy = 1e-3;
  int leaf_size = 32;
};

/// The cheapest settings whose rms relative force error was measured to be below `accuracy`.
TreeSettings tree_settings(double accuracy);

/// The field of all bodies at the owned bodies. Without velocities on any rank the rate is left
/// out. Collective.
GravityField evaluate_gravity_tree(const Comm& comm, double constant, const TreeSettings& settings,
                                   std::span<const double> mass, std::span<const Vec3> position,
                                   std::span<const Vec3> velocity);

}  // namespace spall
