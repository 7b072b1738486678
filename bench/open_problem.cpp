// How far the Coulomb problem of a settled pile can be solved: residuals against products.
// SPDX-License-Identifier: BSD-3-Clause
//
// Three ways: the centre of the proximal term stays, it follows, or the pile itself may move.
#include <cstdio>
#include <string>

#include "scenes.hpp"

namespace {

using namespace spall;

/// Solves the step of `state` from its impulses and puts the new ones in their place.
SolverReport solve_on(const Comm& comm, const SolverSettings& settings, double step, State& state) {
  Lab world = state.world(comm, true);
  const StepReport report = nonsmooth_step(world, step, settings, 1);
  state.memory = remember(world.bodies, world.rigid.neighbours.pairs, false);
  state.kick.remembered_load = world.kick.remembered_load;
  return report.solver;
}

/// A whole step: the pile moves on.
void advance(const Comm& comm, double step, double tolerance, State& state) {
  Lab world = state.world(comm, true);
  nonsmooth_step(world, step, {.tolerance = tolerance}, 1);
  evaluate_field(world);
  state.memory = remember(world.bodies, world.rigid.neighbours.pairs, false);
  state.bodies = world.bodies;
  resize(state.bodies, state.bodies.owned);
  state.kick = world.kick;
}

void measure(const Comm& comm, const std::string& age, double step, const State& state) {
  constexpr int most = 20000;
  const auto print = [&](FrictionModel friction, const std::string& way, int products, double E) {
    if (comm.rank == 0)
      fmt::print("{},{},{},{},{:.4g}\n", age,
                 friction == FrictionModel::convex ? "convex" : "coulomb", way, products, E);
    std::fflush(stdout);
  };
  for (const auto friction : {FrictionModel::convex, FrictionModel::coulomb}) {
    const auto settings = [&](double prox, int products) {
      return SolverSettings{.friction = friction,
                            .tolerance = 1e-12,
                            .max_iterations = 1 << 30,
                            .max_products = products,
                            .prox = prox};
    };
    for (double prox : {0.0, 4e-3})
      for (int products = 25; products <= most; products *= 2) {
        State start = state;
        const SolverReport report = solve_on(comm, settings(prox, products), step, start);
        print(friction, prox > 0 ? "prox" : "plain", report.products, report.residual);
      }
    for (double prox : {4e-3, 1e-3}) {
      State start = state;
      int products = 0;
      for (int next = 200; products < most;) {
        const SolverReport report = solve_on(comm, settings(prox, 200), step, start);
        products += report.products;
        if (products < next) continue;
        print(friction, fmt::format("prox {:g} centred anew every 200", prox), products,
              report.residual);
        next = products * 5 / 4;
      }
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    if (comm.rank == 0) fmt::print("age,friction,way,products,E\n");
    const BenchScene scene = pile(argc > 1 ? std::atoi(argv[1]) : 10000);
    State state = prepare(comm, scene);
    state.kick.remembered_load = state.kick.interval;
    measure(comm, "just settled", scene.step, state);
    for (int step = 0; step < 400; ++step) advance(comm, scene.step, 1e-3, state);
    measure(comm, "400 steps later", scene.step, state);
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
