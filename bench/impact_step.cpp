// The first step of an impact on a settled pile, at several tolerances: energy beside the time.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <ctime>
#include <string>
#include <vector>

#include "lab.hpp"
#include "output/diagnostics.hpp"
#include "output/restart.hpp"
#include "scene/impactor.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

struct Outcome {
  StepReport report;
  double energy = 0;             ///< J, kinetic, after the step
  double seconds = 0;            ///< of solving
  double processor_seconds = 0;  ///< of this rank, in the whole step
};

/// One step of the phase with the impactor, from the pile as the file has it.
Outcome impact(const Comm& comm, const RestartState& state, const SolverSettings& solver) {
  const Case scene = parse_case(state.case_text, state.case_file, state.overrides);
  Lab world = make_world(comm, scene);
  world.bodies = state.bodies;
  world.rigid.neighbours.carried = state.contacts;
  world.kick.remembered_load = state.scalars.at("kick.remembered_load");
  for (const Phase& phase : scene.phases)
    if (phase.impactor) {
      add_impactor(comm, scene, *phase.impactor, world.bodies);
      world.kick.interval = 0;
      if (phase.cohesion) set_cohesion(world.contact, *phase.cohesion);
      Outcome outcome;
      const std::clock_t before = std::clock();
      outcome.report = nonsmooth_step(world, phase.step, solver, 1);
      outcome.processor_seconds = static_cast<double>(std::clock() - before) / CLOCKS_PER_SEC;
      outcome.seconds = comm.max(world.stages["solver"].seconds);
      outcome.energy = diagnose(world).kinetic;
      return outcome;
    }
  throw Error("the case has no impactor");
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    require(argc >= 2,
            "usage: bench_impact_step out/didymoon/after_aggregation.h5 [coulomb|convex]");
    const RestartState state = read_restart(comm, argv[1]);
    const FrictionModel friction = argc > 2 && argv[2] == std::string("convex")
                                       ? FrictionModel::convex
                                       : FrictionModel::coulomb;
    const Outcome converged = impact(
        comm, state, {.friction = friction, .tolerance = 1e-8, .max_iterations = 20000, .prox = 0});
    if (comm.rank == 0)
      fmt::print("converged: {:.6g} J after {} products, E {:.2g}\n", converged.energy,
                 converged.report.solver.products, converged.report.solver.residual);
    const auto show = [&](const std::string& what, const SolverSettings& solver) {
      const Outcome now = impact(comm, state, solver);
      const SolverReport& solve = now.report.solver;
      const double contacts = comm.sum(static_cast<double>(now.report.contacts));
      if (comm.rank == 0)
        fmt::print(
            "{}: contacts {} products {} E {:.2g} E_eps {:.2g} max {:.2g} rms {:.2g} m/s solver "
            "{:.3f} s of the processor {:.3f} s energy {:+.3g}\n",
            what, contacts, solve.products, solve.residual, solve.residual_prox, solve.residual_max,
            solve.residual_rms, now.seconds, now.processor_seconds,
            now.energy / converged.energy - 1);
    };
    show("as they are", {.friction = friction});
    for (const double prox : {0.0, 1e-3, 4e-3})
      for (const double tolerance : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6})
        show(fmt::format("prox {:g} tolerance {:g}", prox, tolerance),
             {.friction = friction, .tolerance = tolerance, .prox = prox});
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
