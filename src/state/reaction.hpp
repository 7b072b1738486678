// What walls and held bodies receive from the bodies that press on them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/types.hpp"

namespace spall {

/// Received since the start.
struct Reaction {
  Vec3 impulse = Vec3::Zero();  ///< N s
  Vec3 moment = Vec3::Zero();   ///< N m s, about the origin

  /// An impulse (N s) at `x` (m), and a turn (N m s) beside it.
  void add(const Vec3& x, const Vec3& push, const Vec3& turn = Vec3::Zero()) {
    impulse += push;
    moment += x.cross(push) + turn;
  }
};

/// Of every wall by its number, then of every group; sums over this rank's part. They grow where
/// they are asked for.
struct Reactions {
  std::vector<Reaction> of_walls, of_groups;

  static Reaction& at(std::vector<Reaction>& all, std::size_t number) {
    if (number >= all.size()) all.resize(number + 1);
    return all[number];
  }
};

}  // namespace spall
