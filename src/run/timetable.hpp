// Instants at which a run looks at its bodies: multiples of an interval, and times after an impact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "output/restart.hpp"
#include "scene/case.hpp"
#include "state/world.hpp"

namespace spall {

/// How often walls that are to hold are looked at in a phase: what comes at them, and, where there
/// are no snapshots, what has become of them.
inline constexpr double looks_a_phase = 50, judgements_a_phase = 10;

/// Steps of `h` (s) that may pass until something must be seen at its own instant; at least 1.
std::int64_t steps_to_event(const Case& scene, const Clock& clock, double h);

/// Whether the read-out `at` (s after the impact) is due at the instant `now`, the next that is
/// looked at after `before`: each is made once, at the step that is nearest to it, or at the first
/// one of a phase. Both clocks are in the same phase.
bool read_out_due(const Case& scene, const Clock& before, const Clock& now, double at);

/// Whether the series has a row of the instant `now`, the next that is looked at after `before`, in
/// the same phase. Where a phase begins they are the same.
bool row_due(const Case& scene, const Clock& before, const Clock& now);

/// Whether the run keeps its state and goes on from it. Restart files hold such a state: there
/// pairs are searched anew, by the run that goes on as by the one that resumes, so that both come
/// to the same bits. Steps are counted, for the moments at which files are asked for are never the
/// same. It costs one search in so many steps.
bool keep_due(const Case& scene, const Clock& clock);

/// Steps that may pass before something is asked for, of `left` in the phase. Collective.
int most_steps(const Case& scene, const Clock& clock, std::int64_t left, const World& world);

/// Whether a multiple of `every` (s) is nearer to the instant `now` or one before it than to
/// `before`, the last that was looked at, in the same phase; never where that is 0.
bool passed_multiple(const Case& scene, const Clock& before, const Clock& now, double every);

}  // namespace spall
