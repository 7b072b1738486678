// Bounds from boxes of velocities; the cost of a step as a function of the skin.
// SPDX-License-Identifier: BSD-3-Clause
#include "flight.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "spall/base/require.hpp"

namespace spall {

Motion Motion::united(const Comm& comm) const {
  const RowHalf &low = velocities.low, &high = velocities.high;
  std::array<double, 7> ends{-low[0], -low[1], -low[2], high[0], high[1], high[2], kick};
  comm.max(ends);
  Motion all;
  all.velocities.low = RowHalf{-ends[0], -ends[1], -ends[2], 0};
  all.velocities.high = RowHalf{ends[3], ends[4], ends[5], 0};
  all.kick = ends[6];
  return all;
}

Motion motion_of(const Bodies& bodies) {
  Motion motion;
  for (Index b = 0; b < bodies.owned; ++b) motion.velocities.add(bodies.velocity[b]);
  return motion;
}

void book_motion(const Comm& comm, const Motion& motion, double h, NearPairs& near) {
  const Motion all = motion.united(comm);
  Outlook& o = near.outlook;
  o.time += h;
  o.ahead -= h;
  o.by_speed += h * all.largest_difference();
  o.kicks += all.kick;
  o.by_kicks += 2 * h * o.kicks;  // of either body
  near.moved = o.moved + (o.ahead >= 0 ? std::min(o.by_speed, o.by_kicks) : o.by_speed);
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
