// Scenes that the solver's benchmarks generate, and how each becomes the state that is measured.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "gravity/kick.hpp"
#include "lab.hpp"
#include "output/diagnostics.hpp"
#include "scene/scene.hpp"

namespace spall {

/// A case, and how it becomes the state whose next step is measured.
struct BenchScene {
  std::string name;
  double step;           ///< s
  int most_steps;        ///< before the measured one
  double settled_speed;  ///< m/s, rms, at which they end early
  double warm_prox;      ///< of the steps before, and of the proximal method
  std::string text;
};

inline const std::string rock = R"(
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
[gravity]
method = "tree"
[[phases]]
name = "rest"
step = "10 s"
duration = "10 s"
)";

inline BenchScene pile(int count) {
  return {"pile",
          10,
          700,
          1e-4,
          4e-3,
          fmt::format(R"(
title = "Spheres settled under their own gravity"
[[groups]]
name = "cloud"
material = "rock"
volume = {{shape = "sphere", radius = {}}}
packing = {{kind = "random", radius = "3 m", count = {}}}
)",
                      3 + 89 * std::cbrt(count / 1e4), count) +
              rock};
}

inline BenchScene nucleus(int count) {
  return {"nucleus",
          10,
          500,
          1e-4,
          4e-3,
          fmt::format(R"(
title = "Boulders settled on one body 7e4 times heavier"
[[groups]]
name = "nucleus"
material = "rock"
volume = {{radius = "70 m"}}
[[groups]]
name = "boulders"
material = "rock"
volume = {{shape = "hollow_sphere", radius = {}, inner_radius = "70 m"}}
packing = {{kind = "random", diameter = "3.4 m", count = {}}}
)",
                      std::cbrt(343000 + count * 22.8787), count) +
              rock};
}

/// A lattice `layers` thick and `across` wide under a sphere 40 diameters across, of one body or of
/// the same grains. Without friction a contact has one unknown.
inline BenchScene plate(int layers, int across, double friction, bool grains) {
  constexpr double d = 0.237e-3, speed = 6700, sphere = 20 * d;
  const double step = d / 2 / speed;
  return {
      "plate",
      step,
      12,
      0,
      1e-3,
      fmt::format(R"(
title = "A lattice plate under a sphere at 6.7 km/s, held by cohesion"
[materials.aluminium]
density = "2703 kg/m^3"
[contact]
friction = {}
cohesion = "1500 N"
cohesion_range = "0.01 mm"
[[groups]]
name = "plate"
material = "aluminium"
volume = {{shape = "box", size = [{}, {}, {}], center = [{}, 0, 0]}}
packing = {{kind = "simple_cubic", diameter = "0.237 mm"}}
[[groups]]
name = "sphere"
material = "aluminium"
volume = {{radius = {}}}
{}velocity = [{}, 0, 0]
[[phases]]
name = "impact"
step = {}
duration = {}
)",
                  friction, layers * d, across * d, across * d, sphere + layers * d / 2 + 0.0455e-3,
                  sphere,
                  grains ? "packing = {kind = \"simple_cubic\", diameter = \"0.237 mm\"}\n" : "",
                  speed, step, step)};
}

/// All that a step starts from.
struct State {
  Case scene;
  Bodies bodies;
  ContactMemory memory;
  GravityKick kick;

  Lab world(const Comm& comm, bool warm) const {
    Lab result = make_world(comm, scene);
    result.bodies = bodies;
    result.kick = kick;
    if (warm) result.rigid.neighbours.carried = memory;
    return result;
  }
};

inline State prepare(const Comm& comm, const BenchScene& scene) {
  State state{parse_case(scene.text, scene.name, {}), {}, {}, {}};
  Lab world = make_world(comm, state.scene);
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
  state.memory = remember(world.bodies, world.rigid.neighbours.pairs, false);
  state.bodies = world.bodies;
  resize(state.bodies, state.bodies.owned);
  state.kick = world.kick;
  return state;
}

}  // namespace spall
