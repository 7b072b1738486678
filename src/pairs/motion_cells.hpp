// What bodies' motion differs by, place by place: how much nearer they have come, how fast they may
// meet.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

/// Cells several times as wide as pairs are long. Bodies of cells that touch move nearly alike; all
/// others have far to go before they meet. So debris may fly apart, or past what stands still, at
/// any speed without a search, as long as neighbours stay neighbours.
class MotionCells {
 public:
  MotionCells() = default;
  /// Owned bodies at `places` (m). Every rank learns of all cells. Collective.
  MotionCells(const Comm& comm, std::span<const Vec3> places, double edge);

  /// m: two bodies that were `range` apart, at least, and have been displaced since (m, one an
  /// owned body) are nearer than that by no more. Collective.
  double approach(const Comm& comm, double range, std::span<const Vec3> displacement) const;

  /// m/s, at most: the speed at which two bodies, here with these velocities (m/s), meet if they
  /// fly straight on. Collective.
  double closing_speed(const Comm& comm, std::span<const Vec3> places,
                       std::span<const Vec3> velocity) const;

 private:
  /// That holds the vectors of all bodies of a cell.
  struct Ball {
    Vec3 centre = Vec3::Zero();
    double radius = 0;
  };
  /// Of all cells of all ranks. Collective.
  std::vector<Ball> balls(const Comm& comm, std::span<const Vec3> vectors) const;

  double edge_ = 0;
  std::vector<Index> cell_of_;                  // of this rank's, one an owned body
  Index first_ = 0, count_ = 0;                 // this rank's among all
  std::vector<std::array<Index, 2>> touching_;  // one of this rank's and one not before it
};

}  // namespace spall
