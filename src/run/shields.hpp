// The walls that a case asks a verdict of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/shield_wall.hpp"
#include "engine/engine.hpp"
#include "output/results.hpp"

namespace spall {

/// Does nothing where the case has no [[shields]].
class Shields {
 public:
  /// Throws Error where a wall cannot be judged. Collective.
  Shields(const Comm& comm, const Case& scene);
  /// A line a wall: how it is judged.
  std::string describe() const;
  /// Adds a section a wall, [shield_NAME], and returns a line a wall to show. Velocities and
  /// positions must belong to the same instant. Collective.
  std::vector<std::string> conclude(const World& world, const Engine& engine, double time,
                                    ResultTable& table) const;

 private:
  std::vector<ShieldWall> walls_;
};

/// What a verdict is, in words.
std::string sentence_of(const ShieldWall& wall, const WallVerdict& verdict);

}  // namespace spall
