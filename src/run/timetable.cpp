// Times count as reached within half a step.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/timetable.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/type.hpp"
#include "scene/consistency.hpp"

namespace spall {
namespace {

/// Steps of `h` to the instant that is nearest to what is `ahead` (s), the earlier of two; at least
/// 1.
std::int64_t steps_to(double ahead, double h) {
  constexpr double never = 1e18;  // steps; more have no number
  return std::max<std::int64_t>(
      1, static_cast<std::int64_t>(std::ceil(std::min(ahead / h, never) - 0.5)));
}

/// s: up to what is nearer to this `instant` than to the next, and before the first step of a phase
/// up to what was so at the former phase's last one.
double seen_until(const Case& scene, const Clock& clock, double instant) {
  return instant + scene.phases[clock.phase_of_last_step()].step / 2;
}

/// How many multiples of `every` are seen.
double multiples(const Case& scene, const Clock& clock, double every) {
  return std::floor(seen_until(scene, clock, clock.time) / every);
}

/// s after the impact, up to which read-outs have been made where the clock stands.
double read_until(const Case& scene, const Clock& clock) {
  const bool none = scene.phases[clock.phase].impactor || clock.phase == 0;
  if (clock.step_in_phase == 0 && none) return 0;
  return seen_until(scene, clock, clock.since_impact);
}

}  // namespace

bool read_out_due(const Case& scene, const Clock& before, const Clock& now, double at) {
  return now.since_impact >= 0 && at > read_until(scene, before) && at <= read_until(scene, now);
}

std::int64_t steps_to_event(const Case& scene, const Clock& clock, double h) {
  std::int64_t steps = std::numeric_limits<std::int64_t>::max();
  const double debris_every = scene.debris ? scene.debris->every : 0;
  const double looks_every =
      scene.shields.empty() ? 0 : scene.phases[clock.phase].duration / looks_a_phase;
  for (double every : {scene.output.series_every.value_or(0), scene.output.snapshot_every,
                       debris_every, looks_every})
    if (every > 0)
      steps =
          std::min(steps, steps_to((multiples(scene, clock, every) + 1) * every - clock.time, h));
  if (clock.since_impact >= 0)
    for (double at : scene.read_out)
      if (at > read_until(scene, clock))
        steps = std::min(steps, steps_to(at - clock.since_impact, h));
  return steps;
}

bool passed_multiple(const Case& scene, const Clock& before, const Clock& now, double every) {
  return every > 0 && multiples(scene, now, every) > multiples(scene, before, every);
}

namespace {

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

bool row_due(const Case& scene, const Clock& before, const Clock& now) {
  const auto& every = scene.output.series_every;
  if (every && *every > 0) return now.step == 0 || passed_multiple(scene, before, now, *every);
  return every || scene.phases[now.phase].engine->solves || now.step_in_phase % steps_a_row == 0;
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
