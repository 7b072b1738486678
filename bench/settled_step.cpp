// Steps of a settled pile from a restart file, at several tolerances: seconds beside the error.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <vector>

#include "lab.hpp"
#include "output/restart.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + values.size() / 2, values.end());
  return values[values.size() / 2];
}

/// The first steps fill caches and find pairs; they are not counted.
void measure(const Comm& comm, const RestartState& state, double h, double tolerance, double prox,
             int steps) {
  const Case scene = parse_case(state.case_text, state.case_file, state.overrides);
  Lab world = make_world(comm, scene);
  world.bodies = state.bodies;
  world.rigid.neighbours.carried = state.contacts;
  world.kick.remembered_load = state.scalars.at("kick.remembered_load");
  world.kick.interval = state.scalars.at("kick.interval");
  SolverSettings solver = scene.engines.get<SolverSettings>();
  solver.tolerance = tolerance;
  solver.prox = prox;
  std::vector<double> whole, solving, products, relative, rms;
  double contacts = 0;
  for (int step = -3; step < steps; ++step) {
    const double before = world.stages["solver"].seconds;
    MPI_Barrier(comm.raw);
    const double start = MPI_Wtime();
    const StepReport report = nonsmooth_step(world, h, solver, 1);
    const double seconds = comm.max(MPI_Wtime() - start);
    if (step < 0) continue;
    whole.push_back(seconds);
    solving.push_back(comm.max(world.stages["solver"].seconds - before));
    products.push_back(report.solver.products);
    relative.push_back(report.solver.residual);
    rms.push_back(report.solver.residual_rms);
    contacts = comm.sum(static_cast<double>(report.contacts));
  }
  if (comm.rank == 0)
    fmt::print("{},{},{:g},{:g},{:g},{:.5g},{:.5g},{:.3g},{:.3g}\n", comm.size, contacts, prox,
               tolerance, median(products), median(solving), median(whole), median(relative),
               median(rms));
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    require(argc == 2, "usage: bench_settled_step out/didymoon/after_aggregation.h5");
    const RestartState state = read_restart(comm, argv[1]);
    if (comm.rank == 0)
      fmt::print("ranks,contacts,prox,tolerance,products,solver_s,step_s,E,rms_m_s\n");
    for (double tolerance : {1.0, 0.5, 0.2, 0.1, 3e-2, 1e-2, 3e-3, 1e-3})
      measure(comm, state, 10, tolerance, 4e-3, 15);
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
