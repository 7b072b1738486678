// The examples of docs/how_to_add.md do what the page says.
// SPDX-License-Identifier: BSD-3-Clause
#include <toml++/toml.h>

#include <cmath>

#include "../docs/examples/soft_law.hpp"
#include "run/simulation.hpp"
#include "scene/packing.hpp"
#include "scene/scene.hpp"
#include "testing.hpp"

namespace spall {

extern const EngineType free_engine;
extern const PackingType row_packing;
void add_light_pressure(Simulation& simulation, double pressure);

namespace {

const char* const two_bodies = R"(
[materials.rock]
density = "2000 kg/m^3"
[[groups]]
name = "bodies"
material = "rock"
volume = {shape = "box", size = [9, 2, 2]}
packing = {kind = "simple_cubic", radius = 1}
velocity = [0, 3, 0]
[[phases]]
name = "flight"
step = 0.25
duration = 8
)";

/// Lets `read` ask for the keys of a text.
void read_keys(const std::string& text, const Section::Reader& read) {
  Section::read_all(toml::parse(text), "x.toml", read, Section::reference(read));
}

/// The same case with the engine of the example in its phase.
Case in_free_flight(const std::string& keys) {
  Case scene = parse_case(two_bodies, "x.toml");
  read_keys(keys, [&](Section& in) { free_engine.read(in, scene.phases[0].settings); });
  scene.phases[0].engine = &free_engine;
  return scene;
}

TEST(ExampleEngine, slows_bodies_as_its_drag_says_and_books_what_it_takes) {
  const Case scene = in_free_flight("free = {drag = 0.125}");
  const Comm comm = testing_world();
  Simulation simulation(comm, Scene(std::make_shared<Case>(scene)));
  simulation.begin_phase();
  while (simulation.steps_left() > 0)
    simulation.advance(static_cast<int>(simulation.steps_left()), false);
  const Bodies& bodies = simulation.world().bodies;
  double before = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    EXPECT_NEAR(bodies.velocity[b].y(), 3 * std::exp(-1.0), 1e-13);
    before += bodies.mass[b] / 2 * 9;
  }
  EXPECT_NEAR(simulation.world().ledger.dissipated, before * (1 - std::exp(-2.0)), 1e-12 * before);
}

TEST(ExampleEngine, refuses_what_it_does_not_model) {
  const Comm comm = testing_world();
  const Case fast = in_free_flight("free = {drag = 8}");
  Simulation simulation(comm, Scene(std::make_shared<Case>(fast)));
  EXPECT_EQ(complaint_of([&] { simulation.begin_phase(); }),
            "x.toml:10:1: phases.flight.step = 0.25 s is longer than 1/drag, 0.125 s");
  Case walls = in_free_flight("");
  walls.planes.push_back({});
  EXPECT_EQ(complaint_of([&] {
              free_engine.check(walls, {}, walls.phases[0].settings, {.place = "x: phases.flight"});
            }),
            "x: phases.flight.method = \"free\": [[planes]], [[boxes]], [[cylinders]] and "
            "[periodic] do not act in it");
}

TEST(ExamplePacking, puts_spheres_in_a_row_with_its_gap) {
  Case scene = parse_case(two_bodies, "x.toml");
  Packing& packing = scene.groups[0].packing;
  packing.type = &row_packing;
  read_keys("gap = 0.5", [&](Section& in) { row_packing.read(in, packing); });
  const Bodies bodies = make_bodies(scene, alone());
  ASSERT_EQ(bodies.owned, 3);
  for (Index b = 0; b < 3; ++b) EXPECT_EQ(bodies.position[b], Vec3(2.5 * (b - 1), 0, 0));
}

TEST(ExampleLaw, force_is_the_slope_of_its_energy) {
  const SoftSpheres law{.depth = 3, .d = 2};
  for (double r : {0.5, 1.0, 1.9}) {
    const double dr = 1e-5;
    const double slope =
        (law.energy((r + dr) * (r + dr)) - law.energy((r - dr) * (r - dr))) / (2 * dr);
    EXPECT_NEAR(law.force_over_distance(r * r) * r, -slope, 1e-8);
  }
}

TEST(ExampleForce, accelerates_bodies_by_force_over_mass) {
  const Case scene = in_free_flight("");
  const Comm comm = testing_world();
  Simulation simulation(comm, Scene(std::make_shared<Case>(scene)));
  add_light_pressure(simulation, 5);
  simulation.begin_phase();
  while (simulation.steps_left() > 0)
    simulation.advance(static_cast<int>(simulation.steps_left()), false);
  const Bodies& bodies = simulation.world().bodies;
  for (Index b = 0; b < bodies.owned; ++b)
    EXPECT_NEAR(bodies.velocity[b].x(), 8 * 5 * pi / bodies.mass[b], 1e-13);
}

}  // namespace
}  // namespace spall
