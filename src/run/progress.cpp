// Rates are those since the last line: steps cost more as contacts are made.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/progress.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <mpi.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace spall {
namespace {

/// Of the terminal that standard output goes to; 0 where it goes elsewhere.
int terminal_columns() {
  const char* kind = std::getenv("TERM");
  if (!isatty(STDOUT_FILENO) || !kind || std::string_view(kind) == "dumb") return 0;
  // Open MPI gives a rank a terminal of its own wherever mpirun, its parent, writes.
  const bool by_mpirun = std::getenv("OMPI_COMM_WORLD_RANK") != nullptr;
  const std::string path = fmt::format("/proc/{}/fd/1", by_mpirun ? getppid() : getpid());
  struct stat what {};
  if (stat(path.c_str(), &what) != 0 || !S_ISCHR(what.st_mode)) return 0;
  const int terminal = open(path.c_str(), O_WRONLY | O_NOCTTY | O_NONBLOCK);
  if (terminal < 0) return 0;
  winsize size{};
  const bool is_terminal = ioctl(terminal, TIOCGWINSZ, &size) == 0;
  close(terminal);
  constexpr int usual = 80;
  return !is_terminal ? 0 : size.ws_col > 0 ? size.ws_col : usual;
}

/// A log that is read later has the more lines the longer a run takes, but not in proportion.
double seconds_to_next_line(bool in_place, double elapsed) {
  return in_place ? 1 : std::max(5.0, elapsed / 20);
}

}  // namespace

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
    : scene_(scene),
      speaks_(comm.rank == 0),
      columns_(speaks_ ? terminal_columns() : 0),
      begin_(MPI_Wtime()),
      last_(begin_) {}

Progress::~Progress() {
  clear();
}

void Progress::begin_phase(const Clock& clock) {
  last_ = MPI_Wtime();
  last_step_ = clock.step_in_phase;
}

bool Progress::due() const {
  const double now = MPI_Wtime();
  return speaks_ && now - last_ > seconds_to_next_line(columns_ > 0, now - begin_);
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
      "speed {:.2e} m/s",
      phase.name, clock.step_in_phase, readable_time(clock.time), rate,
      phase.until == PhaseEnd::settled ? "<" : "",
      readable_time(rate > 0 ? steps_left / rate : infinity), state.contacts, state.residual,
      state.rms_speed);
  if (columns_ > 0)  // one sign less than there is room for: it must not begin a second line
    fmt::print("\r{}\x1b[K", line.substr(0, static_cast<std::size_t>(columns_ - 1)));
  else
    fmt::print("{}\n", line);
  std::fflush(stdout);
  in_place_ = columns_ > 0;
}

void Progress::clear() {
  if (!in_place_) return;
  fmt::print("\r\x1b[K");
  std::fflush(stdout);
  in_place_ = false;
}

void Progress::say(const std::string& line) {
  if (!speaks_) return;
  clear();
  fmt::print("{}\n", line);
  std::fflush(stdout);
}

}  // namespace spall
