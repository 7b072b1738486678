// Every method on three generated scenes: products and seconds to reach ever smaller residuals.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <string>
#include <vector>

#include "spall/domain/pack.hpp"
#include "spall/motion/gravity_kick.hpp"
#include "spall/motion/nonsmooth_step.hpp"
#include "spall/output/diagnostics.hpp"
#include "spall/scene/scene.hpp"

namespace {

using namespace spall;

/// A case, and how it becomes the state whose next step is measured.
struct Scene {
  const char* name;
  double step;           ///< s
  int most_steps;        ///< before the measured one
  double settled_speed;  ///< m/s, rms, at which they end early
  double warm_prox;      ///< of the steps before, and of the proximal method
  const char* text;
};

const Scene scenes[] = {
    {"pile", 10, 700, 1e-4, 4e-3, R"(
title = "10,000 spheres settled under their own gravity"
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
[[groups]]
name = "cloud"
material = "rock"
volume = {shape = "sphere", radius = "92 m"}
packing = {kind = "random", radius = "3 m", count = 10000}
[gravity]
method = "tree"
[[phases]]
name = "rest"
step = "10 s"
duration = "10 s"
)"},
    {"nucleus", 10, 500, 1e-4, 4e-3, R"(
title = "10,000 boulders settled on one body 7e4 times heavier"
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
[[groups]]
name = "nucleus"
material = "rock"
volume = {radius = "70 m"}
[[groups]]
name = "boulders"
material = "rock"
volume = {shape = "hollow_sphere", radius = "83 m", inner_radius = "70 m"}
packing = {kind = "random", diameter = "3.4 m", count = 10000}
[gravity]
method = "tree"
[[phases]]
name = "rest"
step = "10 s"
duration = "10 s"
)"},
    {"plate", 1.7687e-8, 12, 0, 1e-3, R"(
title = "A lattice plate under a sphere at 6.7 km/s, held by cohesion"
[materials.aluminium]
density = "2703 kg/m^3"
[contact]
friction = 0.3
cohesion = "1500 N"
cohesion_range = "0.01 mm"
[[groups]]
name = "plate"
material = "aluminium"
volume = {shape = "box", size = ["4.029 mm", "9.48 mm", "9.48 mm"], center = ["6.8 mm", "0 m", "0 m"]}
packing = {kind = "simple_cubic", diameter = "0.237 mm"}
[[groups]]
name = "sphere"
material = "aluminium"
volume = {radius = "4.74 mm"}
velocity = ["6.7 km/s", "0 m/s", "0 m/s"]
[[phases]]
name = "impact"
step = "17.687 ns"
duration = "17.687 ns"
)"},
};

/// All that a step starts from.
struct State {
  Case scene;
  Bodies bodies;
  ContactMemory memory;
  GravityKick kick;

  World world(const Comm& comm, bool warm) const {
    World result = make_world(comm, scene);
    result.bodies = bodies;
    result.kick = kick;
    if (warm) result.neighbours.carried = memory;
    return result;
  }
};

State prepare(const Comm& comm, const Scene& scene) {
  State state{parse_case(scene.text, scene.name, {}), {}, {}, {}};
  World world = make_world(comm, state.scene);
  world.bodies = make_bodies(state.scene, comm);
  int steps = 0;
  for (bool moved = false; steps < scene.most_steps; ++steps) {
    nonsmooth_step(world, scene.step, {.tolerance = 1e-2, .prox = scene.warm_prox}, 1);
    const double speed = diagnose(world).rms_speed;
    if (moved && speed < scene.settled_speed) break;
    moved = moved || speed > scene.settled_speed;
  }
  evaluate_field(world);  // once for all measured steps
  const double speed = diagnose(world).rms_speed;
  if (comm.rank == 0)
    fmt::print(stderr, "{}: {} steps, rms speed {:.3g} m/s\n", scene.name, steps, speed);
  state.memory = remember(world.bodies, world.neighbours.pairs, false);
  state.bodies = world.bodies;
  resize(state.bodies, state.bodies.owned);
  state.kick = world.kick;
  return state;
}

struct Entrant {
  const char* name;
  SolverSettings settings;
};

void measure(const Comm& comm, const Scene& scene, const State& state) {
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
        World world = state.world(comm, warm);
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
  Session session(argc, argv);
  const Comm comm = session.world();
  try {
    if (comm.rank == 0)
      fmt::print(
          "scene,start,method,friction,ranks,contacts,prox,tolerance,iterations,products,"
          "seconds,E,E_eps,max_m_s,converged\n");
    const std::vector<std::string> wanted(argv + 1, argv + argc);
    for (const Scene& scene : scenes)
      if (wanted.empty() || std::find(wanted.begin(), wanted.end(), scene.name) != wanted.end())
        measure(comm, scene, prepare(comm, scene));
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    Session::abort_all(1);
  }
}
