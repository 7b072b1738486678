// Every method on three generated scenes: products and seconds to reach ever smaller residuals.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "scenes.hpp"

namespace {

using namespace spall;

struct Entrant {
  const char* name;
  SolverSettings settings;
};

void measure(const Comm& comm, const BenchScene& scene, const State& state) {
  using enum SolverMethod;
  const auto convex = FrictionModel::convex, coulomb = FrictionModel::coulomb;
  const Entrant entrants[] = {
      {"accelerated", {.method = accelerated, .friction = convex, .prox = 0}},
      {"apgd", {.method = apgd, .friction = convex, .prox = 0}},
      {"bb", {.method = barzilai_borwein, .friction = convex, .prox = 0}},
      {"sor", {.method = sor, .friction = convex, .prox = 0, .relaxation = 1.3}},
      {"accelerated", {.method = accelerated, .friction = coulomb, .prox = 0}},
      {"accelerated prox", {.method = accelerated, .friction = coulomb, .prox = scene.warm_prox}},
      {"sor", {.method = sor, .friction = coulomb, .prox = 0, .relaxation = 1.3}},
  };
  for (bool warm : {false, true})
    for (const Entrant& entrant : entrants)
      for (double tolerance : {1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6}) {
        Lab world = state.world(comm, warm);
        SolverSettings settings = entrant.settings;
        settings.tolerance = tolerance;
        settings.max_iterations = 1 << 30;
        settings.max_products = 4000;
        const StepReport report = nonsmooth_step(world, scene.step, settings, 1);
        const SolverReport& solved = report.solver;
        const auto contacts = comm.sum(report.contacts);
        if (comm.rank == 0) {
          fmt::print("{},{},{},{},{},{},{:g},{:g},{},{},{:.6g},{:.4g},{:.4g},{:.4g},{}\n",
                     scene.name, warm ? "warm" : "cold", entrant.name,
                     settings.friction == convex ? "convex" : "coulomb", comm.size, contacts,
                     settings.prox, tolerance, solved.iterations, solved.products, solved.seconds,
                     solved.residual, solved.residual_prox, solved.residual_max,
                     solved.converged ? 1 : 0);
          std::fflush(stdout);
        }
        if (!solved.converged) break;
      }
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    if (comm.rank == 0)
      fmt::print(
          "scene,start,method,friction,ranks,contacts,prox,tolerance,iterations,products,"
          "seconds,E,E_eps,max_m_s,converged\n");
    const std::vector<std::string> wanted(argv + 1, argv + argc);
    for (const BenchScene& scene : {pile(10000), nucleus(10000), plate(17, 40, 0.3, false)})
      if (wanted.empty() || std::find(wanted.begin(), wanted.end(), scene.name) != wanted.end())
        measure(comm, scene, prepare(comm, scene));
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
