// Forces and torques on walls and on held groups, as means between the rows of the series.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "output/restart.hpp"
#include "output/series.hpp"
#include "scene/case.hpp"

namespace spall {

/// Of every wall, and of every group that is fixed or moves as prescribed. A torque is about the
/// wall's point, or about the point of the group's rotation, else its volume's center, where they
/// were at the start.
class ReactionRows {
 public:
  explicit ReactionRows(const Case& scene);

  /// "floor_force_x", ..., "floor_torque_z".
  std::vector<Column> columns() const;
  /// What this rank's part has received by now; over all ranks they add up.
  std::vector<double> received(const World& world) const;
  /// The values of a row at `time` (s), by what all ranks had received then: means since the row
  /// before, 0 in the first.
  std::vector<double> row(double time, const std::vector<double>& received);

  void save(Scalars& scalars) const;
  void load(const Scalars& scalars);

 private:
  struct Obstacle {
    std::string name;
    Vec3 point;  // m, of torques
    bool is_wall;
    std::size_t number;
  };
  template <class F>
  void for_each_scalar(F&& f);

  std::vector<Obstacle> obstacles_;
  double time_ = -1;              // s, of the row before; negative: none
  std::vector<double> received_;  // then
};

}  // namespace spall
