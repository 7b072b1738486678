// How long a phase will take, from a short sample of its steps.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "base/timer.hpp"
#include "spall/simulation.hpp"

namespace spall {

/// Steps that were timed.
struct Sample {
  std::int64_t steps = 0;
  double seconds = 0;  ///< of wall time, on the slowest rank
  /// Of this rank, in the order of a step, and last what belongs to none.
  std::vector<std::pair<std::string, StageUse>> stages = {};
};

/// Makes steps of the phase that has begun, with the sums that rows of the series need, until they
/// have taken `seconds` or the phase is over. Writes nothing. The first step is not counted where
/// others follow: it finds all pairs. The world's own account of its stages begins anew.
/// Collective.
Sample sample_steps(Simulation& simulation, double seconds);

/// s: what all steps of the present phase take if they cost as much as those of the sample.
double foretold_seconds(const Simulation& simulation, const Sample& sample);

/// The same in words, with what it was foretold from.
std::string describe_time(const Simulation& simulation, const Sample& sample);

}  // namespace spall
