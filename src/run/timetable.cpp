// Times count as reached within half a step.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/timetable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/type.hpp"

namespace spall {
namespace {

/// Steps of `h` from `time` until the next multiple of `every`; at least 1.
std::int64_t steps_to_multiple(double time, double h, double every) {
  const double next = (std::floor((time + h / 2) / every) + 1) * every;
  return std::max<std::int64_t>(1, std::llround((next - time) / h));
}

/// s after the impact, up to which read-outs have been made where the clock stands: those that are
/// nearer to this instant than to the next, and before the first step of a phase those of the
/// former phase's last one.
double read_until(const Case& scene, const Clock& clock) {
  const Phase& phase = scene.phases[clock.phase];
  if (clock.step_in_phase > 0) return clock.since_impact + phase.step / 2;
  if (phase.impactor || clock.phase == 0) return 0;
  return clock.since_impact + scene.phases[clock.phase - 1].step / 2;
}

}  // namespace

bool read_out_due(const Case& scene, const Clock& before, const Clock& now, double at) {
  return now.since_impact >= 0 && at > read_until(scene, before) && at <= read_until(scene, now);
}

std::int64_t steps_to_event(const Case& scene, const Clock& clock, double h) {
  std::int64_t steps = std::numeric_limits<std::int64_t>::max();
  const double debris_every = scene.debris ? scene.debris->every : 0;
  for (double every :
       {scene.output.series_every.value_or(0), scene.output.snapshot_every, debris_every})
    if (every > 0) steps = std::min(steps, steps_to_multiple(clock.time, h, every));
  if (clock.since_impact >= 0)
    for (double at : scene.read_out)
      if (at > read_until(scene, clock))
        steps = std::min<std::int64_t>(
            steps, std::max<std::int64_t>(1, std::llround((at - clock.since_impact) / h)));
  return steps;
}

bool passed_multiple(const Clock& clock, double h, double every) {
  return every > 0 &&
         std::floor((clock.time + h / 2) / every) > std::floor((clock.time - h / 2) / every);
}

namespace {

/// A row costs as much as most of a step of smooth forces: without being told, one in so many.
constexpr std::int64_t steps_a_row = 100;

std::int64_t steps_a_keep(const Case& scene, const Clock& clock) {
  return scene.phases[clock.phase].engine->steps_a_keep;
}

/// Of smooth forces; what a time tells is an event.
std::int64_t steps_to_row(const Case& scene, const Clock& clock) {
  const auto& every = scene.output.series_every;
  if (every) return *every > 0 ? std::numeric_limits<std::int64_t>::max() : 1;
  return steps_a_row - clock.step_in_phase % steps_a_row;
}

}  // namespace

bool row_due(const Case& scene, const Clock& clock) {
  const auto& every = scene.output.series_every;
  const Phase& phase = scene.phases[clock.phase];
  if (every && *every > 0) return clock.step == 0 || passed_multiple(clock, phase.step, *every);
  return every || phase.engine->solves || clock.step_in_phase % steps_a_row == 0;
}

bool keep_due(const Case& scene, const Clock& clock) {
  return clock.step % steps_a_keep(scene, clock) == 0;
}

namespace {

/// Signals, progress and restarts wait no longer: for less than a second, where mpirun gives two.
/// Bodies are counted, not seconds, for a case must cut its steps alike whenever it runs.
std::int64_t most_at_once(const World& world) {
  constexpr double steps_of_bodies = 5e5, most = 100;
  if (world.gravity.method != GravityMethod::none) return most;  // its field is held so long
  const double bodies_a_rank =
      static_cast<double>(world.comm.sum(std::int64_t{world.bodies.owned})) / world.comm.size;
  return static_cast<std::int64_t>(std::clamp(steps_of_bodies / bodies_a_rank, 1.0, most));
}

}  // namespace

int most_steps(const Case& scene, const Clock& clock, std::int64_t left, const World& world) {
  const Phase& phase = scene.phases[clock.phase];
  const std::int64_t a_keep = steps_a_keep(scene, clock);
  const std::int64_t steps =
      std::min({left, steps_to_event(scene, clock, phase.step), a_keep - clock.step % a_keep});
  if (phase.engine->solves) return static_cast<int>(std::min<std::int64_t>(steps, 1 << 30));
  return static_cast<int>(std::min({steps, most_at_once(world), steps_to_row(scene, clock)}));
}

}  // namespace spall
