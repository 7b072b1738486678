// Rates are those since the last line: steps cost more as contacts are made.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/progress.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include <cmath>
#include <cstdio>

namespace spall {
namespace {
constexpr double seconds_between_lines = 5;
}

std::string readable_time(double seconds) {
  if (!std::isfinite(seconds)) return "?";
  if (seconds < 1e-3) return fmt::format("{:.3g} us", seconds * 1e6);
  if (seconds < 1) return fmt::format("{:.3g} ms", seconds * 1e3);
  if (seconds < 120) return fmt::format("{:.3g} s", seconds);
  const auto minutes = static_cast<std::int64_t>(seconds / 60);
  if (minutes < 120)
    return fmt::format("{} min {:.0f} s", minutes, std::floor(seconds - 60.0 * minutes));
  return fmt::format("{} h {} min", minutes / 60, minutes % 60);
}

Progress::Progress(const Comm& comm, const Case& scene)
    : scene_(scene), speaks_(comm.rank == 0), last_(MPI_Wtime()) {}

void Progress::begin_phase(const Clock& clock) {
  last_ = MPI_Wtime();
  last_step_ = clock.step_in_phase;
}

bool Progress::due() const {
  return speaks_ && MPI_Wtime() - last_ > seconds_between_lines;
}

void Progress::show(const Clock& clock, const State& state) {
  const double now = MPI_Wtime();
  const Phase& phase = scene_.phases[clock.phase];
  const double done = static_cast<double>(clock.step_in_phase - last_step_);
  const double rate = done / (now - last_);
  last_ = now;
  last_step_ = clock.step_in_phase;
  const double steps_left = (phase.duration - clock.time_in_phase) / phase.step;
  const std::string line = fmt::format(
      "{:<16} step {:>7}  t {:<12} {:>7.1f} steps/s  left {}{:<12} contacts {:<7} E {:.1e}  rms "
      "speed "
      "{:.2e} m/s",
      phase.name, clock.step_in_phase, readable_time(clock.time), rate,
      phase.until == PhaseEnd::settled ? "<" : "",
      readable_time(rate > 0 ? steps_left / rate : infinity), state.contacts, state.residual,
      state.rms_speed);
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

void Progress::say(const std::string& line) {
  if (!speaks_) return;
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

}  // namespace spall
