// Bounds from boxes of velocities; the cost of a step as a function of the skin.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/flight.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "pairs/lost_motion.hpp"

namespace spall {

RowBox RowBox::united(const Comm& comm) const {
  std::array<double, 6> ends{-low[0], -low[1], -low[2], high[0], high[1], high[2]};
  comm.max(ends);
  RowBox all;
  all.low = RowHalf{-ends[0], -ends[1], -ends[2], 0};
  all.high = RowHalf{ends[3], ends[4], ends[5], 0};
  return all;
}

namespace {

/// The box of all within `room(b)` of `place(b)`, of `count` bodies. In plain numbers: without
/// vectors of four, `RowBox::add` takes twenty times as long.
template <class Place, class Room>
RowBox box_of(Index count, const Place& place, const Room& room) {
  std::array<double, 3> low, high;
  low.fill(infinity);
  high.fill(-infinity);
  for (Index b = 0; b < count; ++b) {
    const Vec3 x = place(b);
    const double r = room(b);
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x[k] - r);
      high[k] = std::max(high[k], x[k] + r);
    }
  }
  return {half_row(Vec3(low.data()), 0), half_row(Vec3(high.data()), 0)};
}

}  // namespace

RowBox velocities_with_walls(const World& world) {
  const Bodies& bodies = world.bodies;
  RowBox box = box_of(
      bodies.owned, [&](Index b) { return bodies.velocity[b]; },
      [&](Index b) { return turning_speed(world.shapes, bodies, b); });
  if (world.walls().size() > 0) box.add(Vec3(Vec3::Zero()));
  return box;
}

double approach_from(const World& world, const Bodies& bodies, std::span<const Vec3> from) {
  const auto moved = [&](Index b) -> Vec3 { return bodies.position[b] - from[b]; };
  const Vec3 centre = box_of(static_cast<Index>(from.size()), moved, [](Index) { return 0.0; })
                          .united(world.comm)
                          .centre();
  double furthest = 0;
  for (Index b = 0; b < static_cast<Index>(from.size()); ++b) {
    furthest = std::max(furthest, 4 * (moved(b) - centre).squaredNorm());
    if (world.walls().size() > 0) furthest = std::max(furthest, moved(b).squaredNorm());
  }
  return std::sqrt(world.comm.max(furthest));
}

double approach_since_search(const World& world, const NearPairs& near) {
  if (world.period.any() || world.walls().size() > 0)
    return approach_from(world, world.bodies, near.found_at);
  std::vector<Vec3> displacement(near.found_at.size());
  for (std::size_t b = 0; b < displacement.size(); ++b)
    displacement[b] = world.bodies.position[b] - near.found_at[b];
  return near.cells.approach(world.comm, near.reach + near.skin, displacement);
}

void book_motion(const Comm& comm, const RowBox& velocities, double h, NearPairs& near) {
  near.moved += h * velocities.united(comm).diagonal();
  if (!std::isfinite(near.moved)) throw LostMotion("velocities are no longer finite");
}

Crowd crowd_of(const Comm& comm, const Bodies& bodies, double largest) {
  std::array<double, 4> sums{};
  for (Index b = 0; b < bodies.owned; ++b) {
    const double r = bodies.radius[b];
    if (r > largest) continue;
    const std::array<double, 4> powers{1, r, r * r, r * r * r};
    for (std::size_t k = 0; k < powers.size(); ++k) sums[k] += powers[k];
  }
  comm.sum(sums);
  const double r = sums[1] / sums[0], r2 = sums[2] / sums[0], r3 = sums[3] / sums[0];
  return {2 * r, 2 * (r2 + r * r), 2 * (r3 + 3 * r2 * r)};
}

double best_skin(const Comm& comm, const Bodies& bodies, const NearPairs& near, const Crowd& crowd,
                 double gap, const SkinRange& range) {
  if (near.skin == 0) return range.first * range.length;
  const double count = comm.sum(static_cast<double>(bodies.owned));
  const double motion = near.moved / (near.steps + 1);  // a step
  const double density = near.pairs / count / crowd.volume(gap + near.skin);
  const auto cost = [&](double skin) {
    const double searches = motion / skin;  // a step
    const double listed = density * crowd.volume(gap + skin);
    return density * crowd.volume(gap + skin / range.lists) +
           searches * (range.search + range.lists * range.list * listed);
  };
  double best = range.least * range.length;
  for (double skin = best; skin <= range.most * range.length; skin += range.step * range.length)
    if (cost(skin) < cost(best)) best = skin;
  return best;
}

}  // namespace spall
