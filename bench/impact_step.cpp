// The first step of an impact on a settled pile, at several tolerances: energy beside the time.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
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
  double energy = 0;   ///< J, kinetic, after the step
  double seconds = 0;  ///< of solving
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
      outcome.report = nonsmooth_step(world, phase.step, solver, 1);
      outcome.seconds = comm.max(world.stages["solver"].seconds);
      outcome.energy = diagnose(world).kinetic;
      return outcome;
    }
  throw Error("the case has no impactor");
}

}  // namespace

int main(int argc, char** argv) {
  Session session(argc, argv);
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
    for (const double prox : {0.0, 1e-3, 4e-3})
      for (const double tolerance : {1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5, 1e-6}) {
        const Outcome now =
            impact(comm, state, {.friction = friction, .tolerance = tolerance, .prox = prox});
        const SolverReport& solve = now.report.solver;
        const double contacts = comm.sum(static_cast<double>(now.report.contacts));
        if (comm.rank == 0)
          fmt::print(
              "prox {:g} tolerance {:g}: contacts {} products {} E {:.2g} E_eps {:.2g} max {:.2g} "
              "rms {:.2g} m/s solver {:.3f} s energy {:+.3g}\n",
              prox, tolerance, contacts, solve.products, solve.residual, solve.residual_prox,
              solve.residual_max, solve.residual_rms, now.seconds,
              now.energy / converged.energy - 1);
      }
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
