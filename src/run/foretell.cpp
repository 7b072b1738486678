// The steps are those of a run, row for row; only files are left out.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/foretell.hpp"

#include <fmt/format.h>
#include <mpi.h>

#include "gravity/kick.hpp"
#include "output/diagnostics.hpp"
#include "run/progress.hpp"
#include "run/record.hpp"
#include "run/simulation.hpp"
#include "run/timetable.hpp"

namespace spall {

Sample sample_steps(Simulation& simulation, double seconds) {
  World& world = simulation.world();
  const Case& scene = simulation.scene();
  Sample sample;
  double start = 0;
  const auto begin = [&] {
    sample = {};
    world.stages.clear();
    traffic() = {};
    start = MPI_Wtime();
  };
  begin();
  bool first = true;
  Clock looked = simulation.clock();
  while (simulation.steps_left() > 0) {
    const bool row = simulation.synchronous() && row_due(scene, looked, simulation.clock());
    if (simulation.synchronous()) looked = simulation.clock();
    if (row) {
      evaluate_field(world);
      if (simulation.settled(diagnose(world))) break;
    }
    const int most =
        first ? 1 : most_steps(scene, simulation.clock(), simulation.steps_left(), world);
    sample.steps += simulation.advance(most, row).steps;
    sample.seconds = world.comm.max(MPI_Wtime() - start);
    if (sample.seconds > seconds) break;
    if (first && simulation.steps_left() > 0) begin();
    first = false;
  }
  StageUse rest{sample.seconds, traffic()};
  for (const std::string& stage : stages) {
    sample.stages.emplace_back(stage, world.stages[stage]);
    rest.seconds -= world.stages[stage].seconds;
    rest.traffic.take_away(world.stages[stage].traffic);
  }
  sample.stages.emplace_back("elsewhere", rest);
  return sample;
}

double foretold_seconds(const Simulation& simulation, const Sample& sample) {
  if (sample.steps == 0) return 0;
  const auto steps = static_cast<double>(simulation.phase().steps());
  return sample.seconds / static_cast<double>(sample.steps) * steps;
}

std::string describe_time(const Simulation& simulation, const Sample& sample) {
  const Phase& phase = simulation.phase();
  const int ranks = simulation.world().comm.size;
  return fmt::format(
      "\n  phase {}: {}about {} for {} steps if they cost as much as a sample of {}, which took {} "
      "on {} rank{}{}\n",
      phase.name, phase.until == PhaseEnd::settled ? "at most " : "",
      readable_time(foretold_seconds(simulation, sample)), phase.steps(), sample.steps,
      readable_time(sample.seconds), ranks, ranks == 1 ? "" : "s",
      simulation.scene().phases.size() > 1 ? "; later phases are not foretold" : "");
}

}  // namespace spall
