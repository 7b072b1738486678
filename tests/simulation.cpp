// The library as a program uses it: scenes, steps, own forces, questions; and integrators.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/simulation.hpp"

#include <cmath>

#include "pair_potentials.hpp"
#include "run/run.hpp"
#include "run/timetable.hpp"
#include "spall/spall.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

const std::string rock = R"(
[materials.rock]
density = "2000 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
)";
std::string phase(const std::string& keys) {
  return "[[phases]]\nname = \"only\"\n" + keys;
}

/// Four spheres in a row, apart.
Scene four(const std::string& text) {
  Scene scene = Scene::from_text(text);
  for (int k = 0; k < 4; ++k)
    scene.add({.material = "rock", .radius = 0.5, .position = {2.0 * k, 0, 0}});
  return scene;
}

/// By id, on every rank.
std::vector<Vec3> positions(const Simulation& simulation) {
  const Bodies& bodies = simulation.bodies();
  std::vector<double> rows;
  for (Index b = 0; b < bodies.owned; ++b) {
    rows.push_back(static_cast<double>(bodies.id[b]));
    rows.insert(rows.end(), bodies.position[b].data(), bodies.position[b].data() + 3);
  }
  const std::vector<double> all = testing_world().all_gather(rows);
  std::vector<Vec3> x(all.size() / 4);
  for (std::size_t k = 0; k < all.size(); k += 4)
    x[static_cast<std::size_t>(all[k])] = {all[k + 1], all[k + 2], all[k + 3]};
  return x;
}

TEST(Simulation, spheres_of_a_program_have_the_mass_of_their_material_and_the_ids_in_order) {
  const Simulation simulation(testing_world(), four(rock + phase("step = 0.01\nduration = 1\n")));
  double mass = 0;
  for (Index b = 0; b < simulation.bodies().owned; ++b) mass += simulation.bodies().mass[b];
  EXPECT_NEAR(testing_world().sum(mass), 4 * 2000 * pi / 6, 1e-9);
  const auto x = positions(simulation);
  ASSERT_EQ(x.size(), 4u);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(x[k].x(), 2.0 * k);
}

TEST(Simulation, a_material_that_the_scene_lacks_is_an_error_that_names_it) {
  Scene scene = Scene::from_text(rock + phase("step = 0.01\nduration = 1\n"));
  EXPECT_EQ(complaint_of([&] { scene.add({.material = "ice", .radius = 1}); }),
            "scene: sphere 0: material \"ice\" is not in [materials]");
}

TEST(Simulation, a_sphere_without_a_finite_size_is_an_error) {
  Scene scene = Scene::from_text(rock + phase("step = 0.01\nduration = 1\n"));
  for (const auto& [radius, told] : {std::pair(-1.0, "-1"), {0.0, "0"}, {infinity, "inf"}})
    EXPECT_EQ(complaint_of([&] { scene.add({.material = "rock", .radius = radius}); }),
              fmt::format("scene: sphere 0: radius = {} m", told));
}

TEST(Simulation, keeps_its_state_as_often_as_its_pages_say) {
  const std::string soft = "[penalty]\nmodel = \"hooke\"\nstiffness = 1e6\n";
  for (const auto& [method, often] : {std::pair("nonsmooth", 50), {"penalty", 1000}}) {
    const Case scene = parse_case(rock + R"([[groups]]
name = "ball"
material = "rock"
volume = {radius = 1}
)" + phase(fmt::format("method = \"{}\"\nstep = 0.01\nduration = 1\n", method)) +
                                      (often == 50 ? "" : soft),
                                  "x.toml");
    for (int step = 1; step <= 2 * often; ++step)
      EXPECT_EQ(keep_due(scene, {.step = step}), step % often == 0) << method << " " << step;
  }
}

TEST(Simulation, an_own_force_like_gravity_does_what_gravity_does_with_every_engine) {
  for (const std::string method : {"nonsmooth", "penalty", "potential"}) {
    const std::string text =
        rock + "[penalty]\nmodel = \"hooke\"\nstiffness = 1e5\n" +
        "[pair_potential]\nlaw = \"lennard_jones\"\ndepth = 1\ndistance = 1\ncutoff = 1.5\n";
    const std::string steps = "method = \"" + method + "\"\nstep = 1e-3\nduration = 1\n";
    const auto fall = [&](const std::string& gravity, bool own) {
      Simulation simulation(testing_world(), four(text + gravity + phase(steps)));
      if (own)
        simulation.add_force([](const Bodies& bodies, std::span<Vec3> force) {
          for (Index b = 0; b < bodies.owned; ++b) force[b].z() -= 9.81 * bodies.mass[b];
        });
      simulation.run_until(0.5);
      EXPECT_EQ(simulation.steps(), 500);
      return std::pair(positions(simulation), simulation.energies());
    };
    const auto [x, energies] = fall("", true);
    const auto [expected, by_gravity] = fall("[gravity]\nuniform = [0, 0, -9.81]\n", false);
    for (int k = 0; k < 4; ++k)  // kicks stand half a step apart
      EXPECT_LE((x[k] - expected[k]).norm(), 9.81 * 0.5 * 1e-3) << method;
    EXPECT_NEAR(energies.own_work, energies.kinetic, 1e-9 * energies.kinetic) << method;
    EXPECT_NEAR(x[0].z(), -9.81 * 0.125, 9.81 * 0.5 * 1e-3) << method;
    EXPECT_EQ(by_gravity.own_work, 0);
  }
}

double fastest(const Simulation& simulation) {
  double most = 0;
  for (Index b = 0; b < simulation.bodies().owned; ++b)
    most = std::max(most, simulation.bodies().velocity[b].norm());
  return testing_world().max(most);
}

const std::string on_a_floor = rock +
                               "[[planes]]\npoint = [0, 0, -0.5]\nnormal = [0, 0, 1]\n"
                               "[penalty]\nmodel = \"hooke\"\nstiffness = 1e7\n";
const std::string falling = "[gravity]\nuniform = [0, 0, -9.81]\n";
const std::string then = "[[phases]]\nname = \"then\"\n";

/// Nothing is faster than so many m/s after any step.
void expect_rest(Simulation& simulation, double most) {
  while (!simulation.over()) {
    simulation.step();
    EXPECT_LT(fastest(simulation), most) << simulation.time();
  }
}

TEST(Simulation, what_rests_stays_at_rest_where_steps_become_shorter) {
  Simulation simulation(testing_world(),
                        four(on_a_floor + falling + phase("step = 0.1\nduration = 1\n") + then +
                             "step = 1e-3\nduration = 0.1\n"));
  expect_rest(simulation, 1e-6);
}

TEST(Simulation, what_rests_stays_at_rest_where_the_method_changes) {
  Simulation simulation(testing_world(),
                        four(on_a_floor + falling + phase("step = 0.01\nduration = 1\n") + then +
                             "method = \"penalty\"\nstep = 1e-5\nduration = 1e-3\n"));
  while (!simulation.over()) {
    simulation.step();
    // It sinks into its spring, from rest.
    EXPECT_LT(fastest(simulation), 9.81 * std::max(0.0, simulation.time() - 1) + 1e-6);
  }
}

TEST(Simulation, what_is_about_to_land_flies_on_where_the_method_changes) {
  const std::string above = std::string(on_a_floor).replace(on_a_floor.find("-0.5]"), 4, "-0.8");
  Simulation simulation(testing_world(),
                        four(above + falling + phase("step = 0.1\nduration = 0.2\n") + then +
                             "method = \"penalty\"\nstep = 1e-5\nduration = 1e-4\n"));
  while (!simulation.over()) simulation.step();
  EXPECT_NEAR(fastest(simulation), 9.81 * 0.2, 1e-2);  // 0.1 m above the floor
}

TEST(Simulation, what_falls_freely_goes_on_so_where_an_impactor_is_added) {
  Scene scene = four(rock + falling + phase("step = 0.1\nduration = 1\n") + then +
                     "step = 1e-3\nduration = 0.01\n"
                     "impactor = {mass = 1, radius = 0.1, speed = 1, distance = 1e4}\n");
  Simulation simulation(testing_world(), scene);
  while (!simulation.over()) simulation.step();
  const double t = 1.01 - 1e-3 / 2;  // velocities are those of half a step before
  EXPECT_NEAR(fastest(simulation), std::hypot(9.81 * t, 1), 1e-9);
  double slowest = infinity;
  for (Index b = 0; b < simulation.bodies().owned; ++b)
    slowest = std::min(slowest, simulation.bodies().velocity[b].norm());
  EXPECT_NEAR(testing_world().min(slowest), 9.81 * t, 1e-9);
}

TEST(Simulation, what_an_own_force_presses_down_rests) {
  Simulation simulation(testing_world(),
                        four(on_a_floor + phase("step = 1e-3\nduration = 0.05\n")));
  simulation.add_force([](const Bodies& bodies, std::span<Vec3> force) {
    for (Index b = 0; b < bodies.owned; ++b) force[b].z() -= 9.81 * bodies.mass[b];
  });
  expect_rest(simulation, 1e-9);
}

TEST(Simulation, questions_move_nothing) {
  const std::string text =
      rock + "[gravity]\nmethod = \"direct\"\n" + phase("step = 1\nduration = 4000\n");
  Simulation asked(testing_world(), four(text)), silent(testing_world(), four(text));
  for (int k = 0; k < 100; ++k) {
    asked.step();
    silent.step();
    EXPECT_GE(asked.energies().kinetic, 0);
    asked.pairs();
  }
  const auto a = positions(asked), b = positions(silent);
  for (int k = 0; k < 4; ++k) EXPECT_EQ(a[k], b[k]);  // the same bits
}

TEST(Simulation, touching_bodies_are_told_as_pairs_once) {
  Scene scene = Scene::from_text(rock + phase("step = 0.01\nduration = 1\n"));
  for (int k = 0; k < 5; ++k)
    scene.add({.material = "rock", .radius = 0.5, .position = {1.0 * k, 0, 0}});
  const Simulation simulation(testing_world(), scene);
  std::int64_t count = 0;
  for (const BodyPair& pair : simulation.pairs()) {
    EXPECT_EQ(pair.j, pair.i + 1);
    ++count;
  }
  EXPECT_EQ(testing_world().sum(count), 4);
}

TEST(Simulation, a_change_of_bodies_is_booked_and_followed) {
  Simulation simulation(testing_world(), four(rock + phase("step = 0.01\nduration = 1\n")));
  simulation.step();
  simulation.change_bodies([](Bodies& bodies) {
    for (Index b = 0; b < bodies.owned; ++b)
      if (bodies.id[b] == 0) bodies.velocity[b] = {10, 0, 0};
  });
  simulation.run_until(0.3);
  // The ball flies 1 m to its neighbour and hands its momentum on; what is lost is booked.
  const double given = 0.5 * 2000 * pi / 6 * 100;
  const Energies energies = simulation.energies();
  EXPECT_NEAR(energies.kinetic + energies.dissipated, given, 1e-6 * given);
  EXPECT_GT(energies.dissipated, 0.1 * given);
  EXPECT_GT(positions(simulation)[1].x(), 2);
}

TEST(Simulation, a_check_counts_the_spheres_of_a_program) {
  Scene scene = four(rock + phase("step = 0.01\nduration = 1\n"));
  scene.add({.material = "rock", .radius = 1, .position = {0, 9, 0}, .fixed = true});
  const std::string text = check_case(testing_world(), *scene.parts());
  const std::string row = "of the program           5              0.5 to 1";
  EXPECT_NE(text.find(row), std::string::npos) << text;
  EXPECT_NE(text.find("1 fixed\n\n  5 bodies, at most about"), std::string::npos) << text;
  EXPECT_NE(text.find("  no self-gravity\n"), std::string::npos) << text;
}

TEST(Simulation, a_check_tells_how_gravity_is_summed) {
  const Scene scene =
      four("[gravity]\nmethod = \"auto\"\n" + rock + phase("step = 1\nduration = 1\n"));
  const std::string text = check_case(testing_world(), *scene.parts());
  const std::string line = "\n  self-gravity: exact sum over the pairs of 4 bodies (automatic)\n";
  EXPECT_NE(text.find(line), std::string::npos) << text;
}

TEST(Simulation, what_a_case_is_refused_for_is_refused_with_spheres_of_a_program) {
  const auto told = [](const std::string& text, const std::vector<SceneSphere>& spheres) {
    return complaint_of([&] {
      Scene scene = Scene::from_text(rock + text);
      for (const SceneSphere& sphere : spheres) scene.add(sphere);
      const Simulation simulation(testing_world(), scene);
    });
  };
  const std::string one = phase("step = 0.01\nduration = 1\n");
  std::vector<SceneSphere> row;  // far from each other
  for (int k = 0; k < 4; ++k)
    row.push_back({.material = "rock", .radius = 1, .position = {9.0 * k, 0, 0}});
  EXPECT_EQ(told(one, row), "");
  std::vector<SceneSphere> spheres = row;
  spheres[2].position.x() = 1.5;
  EXPECT_TRUE(told(one, spheres)
                  .starts_with("scene: sphere 2: body 2 at (1.5, 0, 0) m overlaps body "
                               "0 of the program at (0, 0, 0) m by 0.5 m"))
      << told(one, spheres);
  const std::string group =
      "[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nvolume = {radius = 1, center = [0, 1, 0]}\n";
  EXPECT_TRUE(told(one + group, row)
                  .starts_with("scene: sphere 0: body 1 at (0, 0, 0) m overlaps "
                               "body 0 of groups.a"))
      << told(one + group, row);
  EXPECT_TRUE(
      told(one + "[[planes]]\npoint = [0, 0, -0.5]\n", row)
          .starts_with("scene: sphere 0: body 0 at (0, 0, 0) m lies 0.5 m deep in the wall"));
  spheres = row;
  spheres[3].fixed = true;
  EXPECT_TRUE(told(phase("step = 0.01\nduration = 1\nremove_drift = true\n"), spheres)
                  .ends_with("remove_drift: a fixed sphere of the program would stay where it is "
                             "while bodies are moved"));
  EXPECT_TRUE(told(one + "[gravity]\nmethod = \"direct\"\n", spheres)
                  .starts_with("scene: a fixed sphere: self-gravity needs finite masses"));
  const std::string springs = "[penalty]\nmodel = \"hertz\"\n";
  const std::string by_springs = phase("method = \"penalty\"\nstep = 1e-6\nduration = 1\n");
  EXPECT_TRUE(told(springs + by_springs, row)
                  .starts_with("scene: sphere: penalty.model = \"hertz\" needs "
                               "materials.rock.youngs_modulus"))
      << told(springs + by_springs, row);
  // A scene may have no groups, and spheres that are hit.
  Scene scene =
      Scene::from_text("read_out = [0.5]\n" + rock + one +
                       "impactor = {mass = 1, radius = 0.1, speed = 1, distance = 0.1}\n");
  for (const SceneSphere& sphere : row) scene.add(sphere);
  EXPECT_EQ(complaint_of([&] { const Simulation simulation(testing_world(), scene); }), "");
}

TEST(Simulation, a_change_that_leaves_no_body_is_refused_and_changes_nothing) {
  Simulation simulation(testing_world(), four(rock + phase("step = 0.01\nduration = 1\n")));
  simulation.step();
  const std::vector<Vec3> before = positions(simulation);
  const auto told = [&](auto&& change) {
    return complaint_of([&] {
      simulation.change_bodies([&](Bodies& bodies) {
        for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] *= 2;
        for (Index b = 0; b < bodies.owned; ++b)
          if (bodies.id[b] == 2) change(bodies, b);
      });
    });
  };
  const std::string begin = "change_bodies: body 2 would have ";
  EXPECT_EQ(told([](Bodies& of, Index b) { of.radius[b] = 0; }),
            begin + "a radius that is not more than 0");
  for (double mass : {0.0, -1.0, infinity, std::nan("")})
    EXPECT_EQ(told([&](Bodies& of, Index b) { of.mass[b] = mass; }),
              begin + "a mass that is not more than 0 or finite as before");
  for (int material : {-1, 1})
    EXPECT_EQ(told([&](Bodies& of, Index b) { of.material[b] = material; }),
              begin + "a material that is not in [materials]");
  EXPECT_EQ(told([](Bodies& of, Index b) { ++of.group[b]; }), begin + "another group");
  EXPECT_EQ(told([](Bodies& of, Index b) { of.velocity[b].x() = infinity; }),
            begin + "a place, velocity or spin that is not finite");
  EXPECT_EQ(positions(simulation), before);
  EXPECT_EQ(simulation.energies().kinetic, 0);
  simulation.run_until(1);
  EXPECT_TRUE(simulation.over());
}

TEST(Simulation, what_stress_is_of_stays_as_it_is) {
  Simulation simulation(
      testing_world(),
      Scene::from_text("[materials.metal]\nlibrary = \"copper\"\n[[groups]]\nname = \"ball\"\n"
                       "material = \"metal\"\n"
                       "volume = {shape = \"sphere\", diameter = 6e-3}\n"
                       "packing = {kind = \"fcc\", diameter = 1e-3}\n" +
                       phase("method = \"solid\"\nstep = 1e-9\nduration = 1e-7\n")));
  const auto told = [&](auto&& change) {
    return complaint_of([&] { simulation.change_bodies(change); });
  };
  const std::string refused = "another radius, mass or material than its stress is of";
  for (auto Bodies::*field : {&Bodies::radius, &Bodies::mass})
    EXPECT_TRUE(told([&](Bodies& bodies) {
                  for (double& value : bodies.*field) value *= 1.2;
                }).ends_with(refused));
  for (auto Bodies::*field :
       {&Bodies::compression, &Bodies::plastic_strain, &Bodies::internal_energy})
    for (const double wrong : {-1.0, std::nan(""), infinity})
      EXPECT_NE(told([&](Bodies& bodies) {
                  for (double& value : bodies.*field) value = wrong;
                }).find("a compression that is not more than 0, or"),
                std::string::npos);
  EXPECT_TRUE(told([](Bodies& bodies) {
                bodies.pressure.assign(bodies.size(), infinity);
              }).ends_with("a stress that is not finite"));
  EXPECT_EQ(told([](Bodies& bodies) {
              for (Index b = 0; b < bodies.owned; ++b) bodies.velocity[b].x() = 1;
            }),
            "");
}

TEST(Simulation, what_tears_and_what_is_crushed_stay_measures) {
  Simulation simulation(
      testing_world(),
      Scene::from_text(
          "[materials.foam]\nlibrary = \"aluminium_6061_t6\"\nsolid = {distension = 1.2, "
          "elastic_pressure = 1e7, compaction_pressure = 1e9}\n[[groups]]\nname = \"ball\"\n"
          "material = \"foam\"\nvolume = {shape = \"sphere\", diameter = 6e-3}\n"
          "packing = {kind = \"fcc\", diameter = 1e-3}\n" +
          phase("method = \"solid\"\nstep = 1e-9\nduration = 1e-8\n")));
  const auto told = [&](std::vector<double> Bodies::*field, double value) {
    return complaint_of([&] {
      simulation.change_bodies([&](Bodies& of) { (of.*field).assign(of.size(), value); });
    });
  };
  for (const double wrong : {-1.0, std::nan(""), infinity})
    EXPECT_TRUE(told(&Bodies::strained, wrong)
                    .ends_with("a sum of strains (`strained`) that is negative or not finite"));
  for (const double wrong : {-0.1, 1.1, std::nan("")})
    EXPECT_TRUE(told(&Bodies::crushed, wrong)
                    .ends_with("pores that are crushed by less than 0 or more than 1"));
  for (const double wrong : {-0.1, 1.1, std::nan("")})
    EXPECT_TRUE(
        told(&Bodies::damage, wrong).ends_with("a damage that is less than 0 or more than 1"));
  EXPECT_EQ(told(&Bodies::strained, 2), "");
  EXPECT_EQ(told(&Bodies::crushed, 1), "");
}

TEST(Simulation, a_step_that_an_error_broke_off_is_the_last) {
  Simulation simulation(testing_world(), four(rock + phase("step = 0.01\nduration = 1\n")));
  simulation.add_force([&](const Bodies&, std::span<Vec3>) {
    if (simulation.steps() == 3) throw Error("of the program");
  });
  EXPECT_EQ(complaint_of([&] { simulation.run_until(1); }), "of the program");
  EXPECT_TRUE(complaint_of([&] { simulation.step(); }).starts_with("an error broke off a step"));
}

TEST(Simulation, a_step_within_a_step_or_a_change_is_refused) {
  Simulation simulation(testing_world(), four(rock + phase("step = 0.01\nduration = 1\n")));
  const std::string within = " is called within a force or a change of bodies, which wait for it";
  EXPECT_EQ(complaint_of([&] { simulation.change_bodies([&](Bodies&) { simulation.step(); }); }),
            "step" + within);
  simulation.step();
  simulation.add_force([&](const Bodies&, std::span<Vec3>) {
    EXPECT_EQ(complaint_of([&] { simulation.step(); }), "step" + within);
    simulation.change_bodies([](Bodies&) {});
  });
  EXPECT_EQ(complaint_of([&] { simulation.step(); }), "change_bodies" + within);
}

TEST(Simulation, what_no_step_can_go_on_with_is_refused) {
  Scene scene = Scene::from_text(rock + phase("step = 0.01\nduration = 1\n"));
  const double nan = std::nan("");
  const std::string of_sphere = "scene: sphere 0: position, velocity and spin must be finite";
  EXPECT_EQ(complaint_of([&] {
              scene.add({.material = "rock", .radius = 1, .position = {0, nan, 0}});
            }),
            of_sphere);
  EXPECT_EQ(complaint_of([&] {
              scene.add({.material = "rock", .radius = 1, .velocity = {infinity, 0, 0}});
            }),
            of_sphere);
  Simulation simulation(testing_world(), four(rock + phase("step = 0.01\nduration = 1\n")));
  EXPECT_EQ(complaint_of([&] { simulation.step(0); }),
            "step: 0 steps are asked for; 1 or more are wanted");
  EXPECT_EQ(complaint_of([&] { simulation.run_until(nan); }),
            "run_until: the time is not a number");
  simulation.add_force([&](const Bodies& bodies, std::span<Vec3> force) {
    for (Index b = 0; b < bodies.owned; ++b)
      if (bodies.id[b] == 2) force[b] = {nan, 0, 0};
  });
  EXPECT_EQ(complaint_of([&] { simulation.step(); }),
            "the program's own force on body 2 is not finite");
}

TEST(Simulation, a_body_without_a_finite_motion_is_named_with_the_step) {
  // The second falls by g h^2 n (n + 1) / 2 until the middle of step n: by 3.75 m after 15. There
  // its distance to the first is 1e-45 m, whose force no double holds.
  Scene scene = Scene::from_text(
      rock + "[pair_potential]\nlaw = \"lennard_jones\"\ndepth = 1e-3\ndistance = 0.0625\n" +
      "cutoff = 0.125\n[gravity]\nuniform = [0, 0, -32768]\n" +
      phase("method = \"potential\"\nstep = 0.0009765625\nduration = 1\n"));
  scene.add({.material = "rock", .radius = 0.01, .fixed = true});
  scene.add({.material = "rock", .radius = 0.01, .position = {0, 1e-45, 3.75}});
  for (double far : {5.0, 6.0})  // a body for each rank
    scene.add({.material = "rock", .radius = 0.01, .position = {far, 0, 0}, .fixed = true});
  Simulation simulation(testing_world(), scene);
  EXPECT_EQ(
      complaint_of([&] {
        for (int k = 0; k < 20; ++k) simulation.step();
      }),
      "scene:14:1: phases.only: body 0 has no finite place, velocity or spin any more after step "
      "15 of phase only: the step may be too long, or a force of the program no number");
}

TEST(Simulation, phases_follow_each_other_and_end) {
  Simulation simulation(
      testing_world(),
      four(rock + "[[phases]]\nname = \"a\"\nstep = 0.1\nduration = 0.3\n[[phases]]\nname = \"b\"\n"
                  "step = 0.05\nduration = 0.1\n"));
  EXPECT_EQ(simulation.phase_name(), "a");
  simulation.run_until(infinity);
  EXPECT_TRUE(simulation.over());
  EXPECT_EQ(simulation.steps(), 5);
  EXPECT_NEAR(simulation.time(), 0.4, 1e-12);
  EXPECT_NE(complaint_of([&] { simulation.step(); }).find("all phases are over"),
            std::string::npos);
}

/// A program's law: Lennard-Jones as a textbook writes it, to compare with Spall's own.
struct Textbook {
  double depth, d;
  Lanes force_over_distance(const Lanes& r2) const {
    const Lanes s2 = d * d / r2, s6 = s2 * s2 * s2;
    return 12 * depth * (s6 * s6 - s6) / r2;
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes s2 = d * d / r2, s6 = s2 * s2 * s2;
    return depth * (s6 * s6 - 2.0 * s6);
  }
};

TEST(Simulation, a_pair_law_of_a_program_acts_like_the_same_law_of_spall) {
  const auto drop = [](const std::string& law, bool own) {
    Scene scene = Scene::from_text("[materials.rock]\ndensity = 1\n[pair_potential]\n" + law +
                                   "distance = 1.1\ncutoff = 1.8\n" +
                                   phase("method = \"potential\"\nstep = 0.01\nduration = 5\n"));
    if (own) scene.set_pair_law(Textbook{0.7, 1.1});
    for (int k = 0; k < 8; ++k)
      scene.add({.material = "rock",
                 .radius = 0.5,
                 .mass = 1,
                 .position = {1.2 * (k & 1), 1.15 * (k >> 1 & 1), 1.1 * (k >> 2 & 1)}});
    Simulation simulation(testing_world(), scene);
    const double before = simulation.energies().pairs;
    simulation.run_until(2);
    const Energies now = simulation.energies();
    EXPECT_NEAR(now.kinetic + now.pairs, before, 2e-4 * std::abs(before));  // leapfrog
    return positions(simulation);
  };
  const auto expected = drop("law = \"lennard_jones\"\ndepth = 0.7\n", false);
  const auto x = drop("law = \"program\"\n", true);
  for (int k = 0; k < 8; ++k) EXPECT_LE((x[k] - expected[k]).norm(), 1e-11) << k;
  EXPECT_NE(complaint_of([&] { drop("law = \"program\"\n", false); }).find("set_pair_law"),
            std::string::npos);
}

TEST(Simulation, a_body_that_falls_through_periods_gains_what_gravity_gives) {
  Scene scene = Scene::from_text(R"(
[materials.rock]
density = "1000 kg/m^3"
[contact]
restitution = 0.5
[penalty]
model = "hooke"
stiffness = 1e5
[periodic]
low = [-1, -1, -1]
size = [2, 2, 2]
[gravity]
uniform = [3, -1, 0]
[[phases]]
name = "fall"
method = "penalty"
step = "0.5 ms"
duration = "4 s"
)");
  for (int k = 0; k < 4; ++k)  // one moves against the others, so that pairs are searched
    scene.add({.material = "rock",
               .radius = 0.1,
               .position = {0.4 * k, 0, 0},
               .velocity = {0, 0, k == 0 ? 1.0 : 0.0}});
  Simulation simulation(testing_world(), scene);
  const Energies start = simulation.energies();
  while (!simulation.over()) simulation.step(100);
  const double t = 4, g2 = 10, mass = 4 * 1000 * 4 / 3.0 * pi * 1e-3;
  const Energies now = simulation.energies();
  EXPECT_NEAR(now.kinetic - start.kinetic, mass / 2 * g2 * t * t, 1e-9 * now.kinetic);
  EXPECT_NEAR(now.gravitational - start.gravitational, start.kinetic - now.kinetic,
              1e-9 * now.kinetic);
  for (Index b = 0; b < simulation.bodies().owned; ++b)
    EXPECT_LT(simulation.bodies().position[b].cwiseAbs().maxCoeff(), 3);  // not 24
}

// Integrators: two bodies swing and turn about each other in Morse's potential, inside its range.

const Splitting velocity_verlet{0, {{0.5, 1}, {0.5, 0}}};
/// Fourth order (Forest & Ruth, Physica D 43 (1990) 105).
const Splitting forest_ruth = [] {
  const double w = 1 / (2 - std::cbrt(2.0)), v = 1 - 2 * w;
  return Splitting{w / 2, {{w, (w + v) / 2}, {v, (w + v) / 2}, {w, w / 2}}};
}();

/// Largest error of energy over some oscillations of `steps` steps.
double error_of_energy(const Splitting& integrator, int steps) {
  Lab lab = make_world(
      alone(), {{.velocity = {0, -0.2, 0}}, {.position = {1.2, 0, 0}, .velocity = {0, 0.2, 0}}},
      {});
  lab.potential = Potential([] {
    PairPotential far = morse;
    far.cutoff = 4 * far.distance;
    return far;
  }());
  lab.potential.integrator = integrator;
  const auto energy = [&] {
    double kinetic = 0;
    for (const Vec3& v : lab.bodies.velocity) kinetic += v.squaredNorm() / 2;
    return kinetic + potential_energy(lab);
  };
  const double before = energy();
  double worst = 0;
  for (int k = 0; k < steps; ++k) {
    potential_steps(lab, 3.0 / steps, 1);
    worst = std::max(worst, std::abs(energy() - before));
  }
  return worst;
}

TEST(Integrators, leapfrog_and_velocity_verlet_are_of_second_order_forest_and_ruth_of_fourth) {
  for (const auto& [integrator, order] :
       {std::pair(leapfrog, 2.0), std::pair(velocity_verlet, 2.0), std::pair(forest_ruth, 4.0)}) {
    const double coarse = error_of_energy(integrator, 100), fine = error_of_energy(integrator, 200);
    EXPECT_NEAR(std::log2(coarse / fine), order, 0.25);
  }
  EXPECT_LT(error_of_energy(forest_ruth, 200), 0.1 * error_of_energy(leapfrog, 200));
}

TEST(Integrators, shares_of_kicks_and_drifts_are_whole_steps) {
  for (const Splitting& s : {leapfrog, velocity_verlet, forest_ruth}) {
    double kicks = 0, drifts = s.first_drift;
    for (const auto& stage : s.stages) {
      kicks += stage.kick;
      drifts += stage.drift;
    }
    EXPECT_NEAR(kicks, 1, 1e-14);
    EXPECT_NEAR(drifts, 1, 1e-14);
  }
}

}  // namespace
}  // namespace spall
