// What the terminal shows while a run goes on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "output/restart.hpp"
#include "scene/case.hpp"

namespace spall {

/// From rank 0: on a terminal one line that is written over each second, else lines that become
/// rarer as the run goes on.
class Progress {
 public:
  Progress(const Comm& comm, const Case& scene);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  struct State {
    double residual = 0;  ///< E of the last step
    std::int64_t contacts = 0;
    double rms_speed = 0;  ///< m/s
  };
  /// The rate of steps counts from here.
  void begin_phase(const Clock& clock);
  /// True when a line is due; then `show` prints it. Both on every rank; only rank 0 acts.
  bool due() const;
  void show(const Clock& clock, const State& state);
  /// A line of its own that stays.
  void say(const std::string& line);

 private:
  /// Takes the line that is written over off the terminal.
  void clear();

  const Case& scene_;
  bool speaks_;
  int columns_;                 // of the terminal; 0: there is none
  bool in_place_ = false;       // a line stands there that is to be written over
  double begin_;                // s, when the run began
  double last_;                 // s, when a line was shown or the phase began
  std::int64_t last_step_ = 0;  // of the phase, made by then
};

/// "12.3 ms", "2 h 4 min": times as people read them.
std::string readable_time(double seconds);

}  // namespace spall
