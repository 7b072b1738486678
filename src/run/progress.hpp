// What the terminal shows while a run goes on.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "output/restart.hpp"
#include "scene/case.hpp"

namespace spall {

/// A line every few seconds, from rank 0.
class Progress {
 public:
  Progress(const Comm& comm, const Case& scene);

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
  const Case& scene_;
  bool speaks_;
  double last_;                 // s, when a line was shown or the phase began
  std::int64_t last_step_ = 0;  // of the phase, made by then
};

/// "1.5 km", "12.3 ms", "2 h 4 min": numbers as people read them.
std::string readable_time(double seconds);

}  // namespace spall
