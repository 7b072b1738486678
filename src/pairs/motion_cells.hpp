// What bodies' motion differs by, place by place: how much nearer they have come, how fast they may
// meet.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

#include "domain/ghosts.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Cells several times as wide as pairs are long. Bodies of cells that touch move nearly alike; all
/// others have far to go before they meet. So debris may fly apart, or past what stands still, at
/// any speed without a search, as long as neighbours stay neighbours.
class MotionCells {
 public:
  MotionCells() = default;
  /// Owned bodies at `places` (m). Ranks learn of others' cells that touch theirs. Collective.
  MotionCells(const Comm& comm, std::span<const Vec3> places, double edge);

  /// m: two bodies that were `range` apart, at least, and have been displaced since (m, one an
  /// owned body) are nearer than that by no more. Collective.
  double approach(const Comm& comm, double range, std::span<const Vec3> displacement) const;

  /// m/s, at most: the speed at which two bodies, here with these velocities (m/s), meet if they
  /// fly straight on. Ranks tell each other what their cells do, coarser than they know it where
  /// all have more than `most_told`. Collective.
  double closing_speed(const Comm& comm, std::span<const Vec3> places,
                       std::span<const Vec3> velocity, int most_told = 1 << 15) const;

  /// That holds vectors of bodies.
  struct Ball {
    Vec3 centre = Vec3::Zero();
    double radius = 0;
  };

 private:
  static constexpr int doubles_a_ball = 4;
  static_assert(sizeof(Ball) == doubles_a_ball * sizeof(double));
  std::vector<Ball> own_balls(std::span<const Vec3> vectors) const;  ///< of each cell

  double edge_ = 0;
  Index count_ = 0;                             // of this rank's cells
  std::vector<Index> cell_of_;                  // one an owned body
  Ghosts ghosts_;                               // other ranks' cells, after this rank's
  std::vector<std::array<Index, 2>> touching_;  // one of this rank's and one not before it
};

}  // namespace spall
