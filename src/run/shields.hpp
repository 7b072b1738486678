// The walls that a case asks a verdict of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/shield_wall.hpp"
#include "engine/engine.hpp"
#include "output/restart.hpp"
#include "output/results.hpp"

namespace spall {

/// Does nothing where the case has no [[shields]].
class Shields {
 public:
  /// Throws Error where a wall cannot be judged. Collective.
  Shields(const Comm& comm, const Case& scene);
  /// A line a wall: how it is judged.
  std::string describe() const;
  /// Looks at what flies at the walls; velocities and positions must belong to the same instant.
  /// Collective.
  void watch(const World& world, const Engine& engine);
  /// Judges the walls as they are; velocities and positions must belong to the same instant.
  /// Returns a line a wall to show. Collective.
  std::vector<std::string> read_out(const World& world, const Engine& engine, double time);
  /// Adds a section a wall, [shield_NAME], with the verdict as it is now and the margins so far,
  /// and returns a line a wall to show. The same holds. Collective.
  std::vector<std::string> conclude(const World& world, const Engine& engine, double time,
                                    ResultTable& table);

  void save(Scalars& scalars) const;
  void load(const Scalars& scalars);

 private:
  struct Judged {
    ShieldWall wall;
    WallVerdict last, most_spall;        ///< of all looks, where spall left a wall without a hole
    Coming largest;                      ///< of all times that were looked at
    std::vector<double> times, margins;  ///< s; of the thickness
  };
  std::vector<Judged> walls_;
};

/// Whether a wall has held so far whose margin still fell, by more than a twentieth between the
/// last two times at which it was judged.
bool is_still_failing(const WallVerdict& last, const std::vector<double>& margins);

/// What a verdict is, in words. `largest`: of what came until now.
std::string sentence_of(const ShieldWall& wall, const WallVerdict& verdict, const Coming& largest);

}  // namespace spall
