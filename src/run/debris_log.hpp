// The debris of a run against time, and what they are in the end.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/debris_cloud.hpp"
#include "engine/engine.hpp"
#include "output/restart.hpp"
#include "output/results.hpp"
#include "scene/scene.hpp"

namespace spall {

/// Does nothing where the case has no [debris]. Each plate has sections of its own.
class DebrisLog {
 public:
  explicit DebrisLog(const Case& scene);
  double every() const { return every_; }  ///< s; 0: never

  /// What is in the groups is known: a hole is where a plate has half of what its bodies weigh.
  void weigh(std::span<const GroupContent> groups);

  /// Measures each cloud; velocities and positions synchronous. Returns a line a plate to show.
  /// Collective.
  std::vector<std::string> read_out(const World& world, double time);
  /// Adds [debris], what they are now, [fragments] where they are `bonded`, so that links tell who
  /// hangs together, [wall] where the case asks for one, and [cloud], all read-outs. Returns what
  /// speaks against them, to show. Collective.
  std::vector<std::string> conclude(const World& world, const Engine& engine, bool bonded,
                                    double time, ResultTable& table);

  void save(Scalars& scalars) const;
  void load(const Scalars& scalars);

 private:
  struct Plate {
    DebrisPlate laid;
    Target target;
    std::vector<Cloud> rows = {};
  };
  void conclude(const Plate& plate, const World& world, const LinkedBodies* linked,
                ResultTable& table) const;

  std::string key_of(const DebrisPlate& plate) const;

  std::vector<Plate> plates_;
  std::string projectile_;  ///< its group's name
  std::optional<double> wall_;
  double every_ = 0;
};

}  // namespace spall
