// Times count as reached within half a step.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/timetable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace spall {
namespace {

/// Steps of `h` from `time` until the next multiple of `every`; at least 1.
std::int64_t steps_to_multiple(double time, double h, double every) {
  const double next = (std::floor((time + h / 2) / every) + 1) * every;
  return std::max<std::int64_t>(1, std::llround((next - time) / h));
}

}  // namespace

std::int64_t steps_to_event(const Case& scene, const Clock& clock, double h) {
  std::int64_t steps = std::numeric_limits<std::int64_t>::max();
  const double debris_every = scene.debris ? scene.debris->every : 0;
  for (double every :
       {scene.output.series_every.value_or(0), scene.output.snapshot_every, debris_every})
    if (every > 0) steps = std::min(steps, steps_to_multiple(clock.time, h, every));
  if (clock.since_impact >= 0)
    for (double at : scene.read_out)
      if (at > clock.since_impact + h / 2)
        steps = std::min<std::int64_t>(
            steps, std::max<std::int64_t>(1, std::llround((at - clock.since_impact) / h)));
  return steps;
}

bool passed_multiple(const Clock& clock, double h, double every) {
  return every > 0 &&
         std::floor((clock.time + h / 2) / every) > std::floor((clock.time - h / 2) / every);
}

}  // namespace spall
