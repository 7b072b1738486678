// Bounds from boxes of velocities; the cost of a step as a function of the skin.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/flight.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "spall/error.hpp"

namespace spall {

Box Box::united(const Comm& comm) const {
  std::array<double, 6> ends{-low[0], -low[1], -low[2], high[0], high[1], high[2]};
  comm.max(ends);
  Box all;
  all.low = RowHalf{-ends[0], -ends[1], -ends[2], 0};
  all.high = RowHalf{ends[3], ends[4], ends[5], 0};
  return all;
}

Box velocities_of(const Bodies& bodies) {
  Box box;
  for (Index b = 0; b < bodies.owned; ++b) box.add(bodies.velocity[b]);
  return box;
}

Box velocities_with_walls(const World& world) {
  Box box = velocities_of(world.bodies);
  if (world.walls().size() > 0) box.add(Vec3(Vec3::Zero()));
  return box;
}

double approach_from(const World& world, std::span<const Vec3> from) {
  const auto moved = [&](std::size_t b) -> Vec3 { return world.bodies.position[b] - from[b]; };
  Box box;
  for (std::size_t b = 0; b < from.size(); ++b) box.add(moved(b));
  const Vec3 centre = box.united(world.comm).centre();
  double furthest = 0;
  for (std::size_t b = 0; b < from.size(); ++b) {
    furthest = std::max(furthest, 4 * (moved(b) - centre).squaredNorm());
    if (world.walls().size() > 0) furthest = std::max(furthest, moved(b).squaredNorm());
  }
  return std::sqrt(world.comm.max(furthest));
}

void book_motion(const Comm& comm, const Box& velocities, double h, NearPairs& near) {
  near.moved += h * velocities.united(comm).diagonal();
  require(std::isfinite(near.moved), "velocities are no longer finite: the step is too long");
}

double best_skin(const Comm& comm, const Bodies& bodies, const NearPairs& near,
                 const SkinRange& range) {
  if (near.skin == 0) return range.first * range.length;
  const double count = comm.sum(static_cast<double>(bodies.owned));
  const double motion = near.moved / (near.steps + 1);  // a step
  const double density = near.pairs / count / std::pow(near.reach + near.skin, 3);
  const auto cost = [&](double skin) {
    return density * std::pow(near.reach + skin, 3) + range.search * motion / skin;
  };
  double best = range.least * range.length;
  for (double skin = best; skin <= range.most * range.length; skin += range.step * range.length)
    if (cost(skin) < cost(best)) best = skin;
  return best;
}

}  // namespace spall
