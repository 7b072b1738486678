// Debris clouds of known shape, speed and pieces: what is measured is what was made.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "analysis/debris_cloud.hpp"
#include "rigid/engine.hpp"
#include "run/debris_log.hpp"
#include "testing.hpp"

namespace spall {
namespace {

Case scene(const std::string& velocity = "[0, 0, -6000]", const std::string& more = "",
           const std::string& plates = R"(plate = "plate")", const std::string& groups = "") {
  return parse_case(R"(
[materials.al.solid]
density = 2700
melt_energy = "1 MJ/kg"
sublimation_energy = "9 MJ/kg"
[[groups]]
name = "plate"
material = "al"
volume = {shape = "box", size = [50, 60, 4], center = [0, 0, -2]}
packing = {kind = "fcc", diameter = 1}
[[groups]]
name = "ball"
material = "al"
volume = {shape = "sphere", diameter = 10, center = [0, 0, 6]}
packing = {kind = "fcc", diameter = 1}
velocity = )" + velocity +
                        "\n" + groups + R"(
[[phases]]
name = "only"
step = 1
duration = 1
[debris]
projectile = "ball"
)" + plates + "\n" + more,
                    "x.toml");
}

Target target_of(const Case& laid) {
  return find_target(laid, laid.debris->plates.front());
}

struct Body {
  int group;
  double mass;
  Vec3 position, velocity;
  double heat = 0;
};

/// Bodies shared by the ranks in turn.
Bodies bodies_of(const Comm& comm, const std::vector<Body>& all) {
  Bodies bodies;
  for (std::size_t k = 0; k < all.size(); ++k) {
    if (static_cast<int>(k) % comm.size != comm.rank) continue;
    const Index row = append_row(bodies);
    bodies.id[row] = static_cast<BodyId>(k);
    bodies.group[row] = all[k].group;
    bodies.mass[row] = all[k].mass;
    bodies.position[row] = all[k].position;
    bodies.velocity[row] = all[k].velocity;
    bodies.heat[row] = all[k].heat;
  }
  bodies.owned = bodies.size();
  return bodies;
}

/// The plate as points of mass on a fine grid, with a hole.
std::vector<Body> plate(const Target& target, double hole, const Vec3& middle) {
  std::vector<Body> all;
  const double step = 0.2;
  for (double x = -25 + step / 2; x < 25; x += step)
    for (double y = -30 + step / 2; y < 30; y += step)
      if (Vec3(x - middle.x(), y - middle.y(), 0).norm() > hole / 2)
        all.push_back({0, target.areal_density * step * step, {x, y, -2}, {0, 0, 3}});
  return all;
}

TEST(Debris, target_is_what_the_case_laid) {
  const Target t = target_of(scene("[3000, 0, -6000]"));
  EXPECT_EQ(t.normal, Vec3(0, 0, -1));
  EXPECT_DOUBLE_EQ(t.diameter, 10);
  EXPECT_DOUBLE_EQ(t.thickness, 4);
  EXPECT_DOUBLE_EQ(t.areal_density, 2700 * 4);
  Case heavy = scene();
  heavy.groups[0].total_mass = 3e6;
  EXPECT_DOUBLE_EQ(target_of(heavy).areal_density, 1000);
  // From 8 m above the plate's middle, half as far across.
  EXPECT_LE((t.origin - Vec3(4, 0, -4)).norm(), 1e-12);
  EXPECT_DOUBLE_EQ(t.half_width, 21);
}

TEST(Debris, target_of_a_tilted_plate_has_its_normal) {
  const double angle = 0.4;
  Case tilted = scene("[0, 0, -6000]");
  tilted.groups[0].volume.axes = Eigen::AngleAxisd(angle, Vec3::UnitX()).toRotationMatrix();
  const Target t = target_of(tilted);
  EXPECT_LE((t.normal - Vec3(0, std::sin(angle), -std::cos(angle))).norm(), 1e-14);
  // Straight down to the plate's middle; from there to its rear face, and its nearest rim.
  EXPECT_LE((t.origin - (Vec3(0, 0, -2) + 2 * t.normal)).norm(), 1e-12);
  EXPECT_NEAR(t.half_width, 25, 1e-12);
  EXPECT_NEAR(t.across[0].cross(t.across[1]).cross(t.normal).norm(), 0, 1e-14);
}

TEST(Debris, hole_is_as_wide_as_it_was_made) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  for (double hole : {0.0, 13.0, 21.7, 30.0}) {
    const Bodies bodies = bodies_of(comm, plate(t, hole, Vec3::Zero()));
    const Cloud cloud = measure_cloud(comm, bodies, t, 0);
    // The grid is an eleventh of a ring wide.
    EXPECT_NEAR(cloud.hole, hole, 0.2) << hole;
    EXPECT_LT(cloud.hole_spread, 0.2);
    EXPECT_NEAR(cloud.plate_speed, -3, 1e-12);
  }
}

TEST(Debris, a_hole_that_reaches_the_rim_has_no_spread) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  const auto spread = [&](double hole, const Vec3& middle) {
    return measure_cloud(comm, bodies_of(comm, plate(t, hole, middle)), t, 0).hole_spread;
  };
  EXPECT_FALSE(std::isnan(spread(40, Vec3::Zero())));
  EXPECT_TRUE(std::isnan(spread(48, Vec3::Zero())));
  EXPECT_FALSE(std::isnan(spread(30, {5, 0, 0})));
  EXPECT_TRUE(std::isnan(spread(30, {9, 0, 0})));  // on one side alone
}

TEST(Debris, a_melt_energy_that_only_melts_is_refused) {
  const auto complaint = [](const char* melt_energy) {
    return complaint_of([&] {
      parse_case(std::string("[materials.al.solid]\ndensity = 2700\nspecific_heat = 900\n"
                             "melting_point = 900\nmelt_energy = ") +
                     melt_energy + "\n",
                 "x.toml");
    });
  };
  EXPECT_NE(complaint("397e3").find("latent heat alone"), std::string::npos);
  EXPECT_EQ(complaint("1e6").find("latent heat alone"), std::string::npos);
}

TEST(Debris, a_rod_is_as_wide_as_it_is_seen_along_its_flight) {
  Case rod = scene();
  Volume& volume = rod.groups[1].volume;
  volume.shape = Shape::cylinder;
  volume.radius = 1;
  volume.extents = {2, 2, 16};
  EXPECT_DOUBLE_EQ(target_of(rod).diameter, 2);
  volume.axes = Eigen::AngleAxisd(pi / 2, Vec3::UnitX()).toRotationMatrix();  // flies across
  EXPECT_DOUBLE_EQ(target_of(rod).diameter, 16);
}

TEST(Debris, whole_plate_of_coarse_bodies_has_no_hole) {
  // Between bodies that are farther apart than rings are wide a whole plate looks open.
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  for (const auto& [spacing, hole] :
       {std::pair(0.5, 0.0), {1.0, 0.0}, {1.6, 0.0}, {2.5, 0.0}, {1.6, 13.0}}) {
    std::vector<Body> all;
    for (double x = -25 + spacing / 2; x < 25; x += spacing)
      for (double y = -30 + spacing / 2; y < 30; y += spacing)
        if (std::hypot(x, y) > hole / 2)
          all.push_back({0, t.areal_density * spacing * spacing, {x, y, -2}, {0, 0, 0}});
    Bodies bodies = bodies_of(comm, all);
    std::ranges::fill(bodies.radius, spacing / 2);
    const Cloud cloud = measure_cloud(comm, bodies, t, 0);
    EXPECT_NEAR(cloud.hole, hole, hole > 0 ? 2.5 * spacing : 0) << spacing;
  }
}

TEST(Debris, hole_off_the_middle_has_the_spread_of_its_sectors) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  const Bodies bodies = bodies_of(comm, plate(t, 24, {2, 0, 0}));
  const Cloud cloud = measure_cloud(comm, bodies, t, 0);
  // r = 2 cos a + sqrt(144 - 4 sin^2 a): mean 12 - 4/48, standard deviation 2/sqrt 2.
  EXPECT_NEAR(cloud.hole, 2 * (12 - 1. / 12), 0.2);
  EXPECT_NEAR(cloud.hole_spread, 2 * std::sqrt(2.0), 0.15);
}

TEST(Debris, speeds_masses_and_extents_are_those_of_the_cloud) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  std::vector<Body> all;
  // A column of 101 pieces of each kind, of speeds 0 to 5000, 10 to 110 m behind the plate.
  for (int k = 0; k <= 100; ++k) {
    const double z = -4 - 10 - k;
    all.push_back({1, 2, {0, 0, z}, {0, 30.0 * k, -50.0 * k}, k < 10 ? 2e7 : k < 25 ? 3e6 : 1e6});
    all.push_back({0, 1, {3, 4, z}, {0, 0, -50.0 * k}, 2e6});
  }
  all.push_back({0, 7, {0, 0, 20}, {0, 0, 100}});  // ejecta
  all.push_back({0, 7, {0, 0, -4.1}, {0, 0, 0}});  // plate
  const Cloud c = measure_cloud(comm, bodies_of(comm, all), t, 1);
  EXPECT_NEAR(c.front, 4950, 1e-9);
  EXPECT_NEAR(c.centre, 2500, 1e-9);
  EXPECT_NEAR(c.rear, 50, 1e-9);
  EXPECT_NEAR(c.length, 98, 1e-9);
  EXPECT_NEAR(c.width, 10, 1e-9);
  EXPECT_NEAR(c.projectile_mass, 202, 1e-9);
  EXPECT_NEAR(c.projectile_momentum, 202 * 2500., 1e-6);
  EXPECT_NEAR(c.plate_mass, 101, 1e-9);
  EXPECT_NEAR(c.projectile_melted, 25. / 101, 1e-12);
  EXPECT_NEAR(c.plate_melted, 1, 1e-12);
  EXPECT_NEAR(c.projectile_vapour, 10. / 101, 1e-12);
  EXPECT_EQ(c.plate_vapour, 0);
  EXPECT_NEAR(c.ejecta_mass, 7, 1e-12);
  EXPECT_NEAR(c.ejecta_momentum, -700, 1e-9);
  // Speeds across: 0 to 3000 of 202 kg, 0 of 101 kg: 99 % of 303 kg is the 98.5th of 101 steps.
  EXPECT_NEAR(c.radial, 2970, 31);
}

TEST(Debris, melts_by_its_own_material_where_that_is_known) {
  const Comm comm = testing_world();
  const std::vector<Body> all{{1, 2, {0, 0, -20}, {0, 0, -50}, 3e6}, {0, 1, {0, 0, -20}, {}, 2e6}};
  Target t = target_of(scene());
  t.melt_energy = {1e6, 3e6};
  EXPECT_EQ(measure_cloud(comm, bodies_of(comm, all), t, 1).projectile_melted, 1);
  EXPECT_EQ(measure_cloud(comm, bodies_of(comm, all), t, 1).plate_melted, 0);
  t.sublimation_energy = {0, 1.5e6};
  EXPECT_TRUE(std::isnan(measure_cloud(comm, bodies_of(comm, all), t, 1).projectile_vapour));
  EXPECT_EQ(measure_cloud(comm, bodies_of(comm, all), t, 1).plate_vapour, 1);
  const Target of_two =
      target_of(parse_case(scene().text + "[materials.cu.solid]\ndensity = 8930\n", "x.toml",
                           {"groups.ball.material=cu"}));
  EXPECT_EQ(of_two.melt_energy, (std::array{0.0, 1e6}));
  EXPECT_EQ(of_two.sublimation_energy, (std::array{0.0, 9e6}));
  const Cloud cloud = measure_cloud(comm, bodies_of(comm, all), of_two, 1);
  EXPECT_TRUE(std::isnan(cloud.projectile_melted));
  EXPECT_EQ(cloud.plate_melted, 1);
}

TEST(Debris, what_would_boil_before_it_melts_is_refused) {
  const std::string complaint = complaint_of([] {
    parse_case("[materials.al.solid]\ndensity = 2700\nmelt_energy = 3\nsublimation_energy = 2\n",
               "x.toml");
  });
  EXPECT_EQ(complaint.substr(0, 34), "x.toml:4:22: materials.al.solid.su");
}

TEST(Debris, maps_that_end_keep_the_line_of_flight_in_their_middle) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  const std::vector<Body> on_axis{{1, 3, {0.1, 0.1, -20}, {0, 0, -50}}};
  for (double distance : {100.0, 1e4})
    EXPECT_DOUBLE_EQ(load_wall(comm, bodies_of(comm, on_axis), t, distance).peak, 150 / 25.)
        << distance;
  std::vector<Body> all{{1, 1, {5000, 5000, -20}, {0, 0, -1}}};
  for (double x = -9.75; x < 10; x += 0.5)
    for (double y = -9.75; y < 10; y += 0.5)
      for (double z = -20; z > -40; z -= 0.5)
        all.push_back({1, 270 * 0.125, {x, y, z}, {0, 0, -1}});
  EXPECT_NEAR(measure_cloud(comm, bodies_of(comm, all), t, 1).contour_width, 20, 5);
}

TEST(Debris, of_a_cloud_without_bodies_are_zeros) {
  const Target t = target_of(scene());
  const Cloud cloud = measure_cloud(testing_world(), {}, t, 0);
  for_each_column(cloud, [&](const std::string& name, double value, auto&&...) {
    if (name == "hole_spread")
      EXPECT_TRUE(std::isnan(value));  // nothing is left of the plate
    else
      EXPECT_EQ(value, name == "hole" ? cloud.hole : 0) << name;
  });
}

TEST(Debris, of_one_rank_alone_are_those_of_all) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  const std::vector<Body> one{{1, 2, {0, 0, -20}, {3, 4, -50}}};
  const Cloud c = measure_cloud(comm, bodies_of(comm, one), t, 1);
  EXPECT_NEAR(c.front, 50, 1e-9);
  EXPECT_NEAR(c.rear, 50, 1e-9);
  EXPECT_NEAR(c.radial, 5, 1e-9);
}

TEST(Debris, ejecta_are_farther_before_the_plate_than_a_quarter_of_the_projectile) {
  const Comm comm = testing_world();
  Target t = target_of(scene());
  t.origin = Vec3::Zero();  // all that follows is exact
  const double nearest = t.thickness + t.diameter / 4;
  const std::vector<Body> all{{0, 3, {0, 0, nearest}, {0, 0, 100}},
                              {0, 5, {0, 0, nearest + 0.125}, {0, 0, 100}}};
  EXPECT_EQ(measure_cloud(comm, bodies_of(comm, all), t, 1).ejecta_mass, 5);
}

TEST(Debris, contour_holds_what_is_thick_enough) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  std::vector<Body> all;
  // A block 40 x 20 x 20 m of a tenth of the density, and dust around it that no contour shows.
  for (double z = 0.25; z < 40; z += 0.5)
    for (double x = -9.75; x < 10; x += 0.5)
      for (double y = -9.75; y < 10; y += 0.5)
        all.push_back({1, 270 * 0.125, {x, y, -4 - 5 - z}, {0, 0, -1000}});
  for (int k = 0; k < 90; ++k) all.push_back({1, 1e-3, {k - 45., 0, -4. - k}, {0, 0, -1}});
  const Cloud c = measure_cloud(comm, bodies_of(comm, all), t, 1);
  const double pixel = 2.5;
  EXPECT_NEAR(c.contour_length, 40, pixel);
  EXPECT_NEAR(c.contour_width, 20, 2 * pixel);
}

TEST(Debris, pieces_are_counted_and_weighed_on_any_number_of_ranks) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  // Chains of 1, 2, 3, ..., 30 bodies behind the plate, one chain before it; all on rank 0.
  std::vector<Body> all;
  Links links;
  for (int chain = 1; chain <= 31; ++chain)
    for (int k = 0; k < chain; ++k) {
      if (k > 0 && comm.rank == 0) {
        links.i.push_back(static_cast<Index>(all.size()) - 1);
        links.j.push_back(static_cast<Index>(all.size()));
      }
      all.push_back({chain % 2, 2, {0, 0, chain == 31 ? 50. : -50.}, Vec3::Zero()});
    }
  Bodies bodies;
  if (comm.rank == 0) bodies = bodies_of(Comm(MPI_COMM_SELF), all);
  const Ghosts none(comm, bodies.owned, {});
  const Fragments f = find_fragments(comm, none, bodies, links, t);
  EXPECT_EQ(f.singles, 1);
  EXPECT_EQ(f.pieces, 29);
  EXPECT_EQ(f.largest, 60);
  EXPECT_EQ(f.counts, (std::vector<double>{8, 21}));
}

TEST(Debris, wall_receives_what_flies_there) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  std::vector<Body> all;
  for (int k = 0; k < 100; ++k) {
    const double a = 2 * pi * k / 100, r = 1 + 0.1 * k;  // where it hits
    const Vec3 side(std::cos(a), std::sin(a), 0);
    // 20 m behind the plate now, at the wall, 100 m behind it, after 0.1 s.
    all.push_back({1, 3, Vec3(0, 0, -24) + 0.2 * r * side, Vec3(0, 0, -800) + 8 * r * side});
  }
  all.push_back({0, 1e3, {0, 0, -2}, {0, 0, -900}});  // still in the plate
  const WallLoad load = load_wall(comm, bodies_of(comm, all), t, 100);
  EXPECT_NEAR(load.momentum, 100 * 3 * 800, 1e-6);
  EXPECT_NEAR(load.half_radius, 5.9, 1e-9);
  EXPECT_NEAR(load.radius, 9.9, 1e-9);
  EXPECT_GT(load.peak, 0);
}

TEST(Debris, what_has_passed_the_wall_is_counted_where_it_came_through) {
  const Comm comm = testing_world();
  const Target t = target_of(scene());
  WallLoad load[2];
  for (int late = 0; late < 2; ++late) {
    std::vector<Body> all;
    for (int k = 1; k <= 9; ++k) {
      const Vec3 velocity(0, 10. * k, -50);
      all.push_back({1, 1, Vec3(0, 0, -14) + (late ? 4. : 0.5) * velocity, velocity});
    }
    load[late] = load_wall(comm, bodies_of(comm, all), t, 100);
  }
  EXPECT_NEAR(load[1].half_radius, load[0].half_radius, 1e-9 * load[0].half_radius);
  EXPECT_NEAR(load[1].radius, load[0].radius, 1e-9 * load[0].radius);
  EXPECT_EQ(load[1].peak, load[0].peak);
}

TEST(Debris, wall_receives_what_is_slow_and_nothing_of_what_stands_still) {
  const Comm comm = testing_world();
  const std::vector<Body> all{{1, 3, {0, 0, -24}, {0, 0, -0.5}}, {1, 7, {0, 0, -24}, {9, 0, 0}}};
  const WallLoad load = load_wall(comm, bodies_of(comm, all), target_of(scene()), 100);
  EXPECT_EQ(load.momentum, 1.5);
  EXPECT_LT(load.radius, 1);
}

TEST(Debris, log_survives_a_restart_and_reports_all_read_outs) {
  const Comm comm = testing_world();
  Case asked = scene("[0, 0, -6000]", "every = 1\n");
  asked.debris->projectile_name = "ball\nA";
  World world;
  world.comm = comm;
  world.bodies = bodies_of(comm, plate(target_of(asked), 20, Vec3::Zero()));
  DebrisLog log(asked), resumed(asked);
  log.read_out(world, 1);
  Scalars scalars;
  log.save(scalars);
  for (const auto& [name, value] : scalars)  // a restart file has them line by line
    EXPECT_EQ(name.find('\n'), std::string::npos) << name;
  resumed.load(scalars);
  ResultTable one, two;
  log.conclude(world, Rigid(), false, 2, one);
  resumed.conclude(world, Rigid(), false, 2, two);
  EXPECT_EQ(one.toml(), two.toml());
  EXPECT_NE(one.toml().find("time = [1.0, 2.0]"), std::string::npos);
}

TEST(Debris, a_plate_is_as_heavy_as_its_bodies) {
  const Comm comm = testing_world();
  const Case asked = scene("[0, 0, -6000]", "every = 1\n");
  std::vector<Body> bodies = plate(target_of(asked), 13, Vec3::Zero());
  for (Body& body : bodies) body.mass *= 0.4;
  World world;
  world.comm = comm;
  world.bodies = bodies_of(comm, bodies);
  std::vector<GroupContent> contents(2);
  contents[0].mass = 0.4 * 2700 * 50 * 60 * 4;
  DebrisLog log(asked);
  log.weigh(contents);
  log.read_out(world, 1);
  ResultTable table;
  log.conclude(world, Rigid(), false, 1, table);
  const std::string told = table.toml(), key = "\nhole = ";
  const auto at = told.find(key);
  ASSERT_NE(at, std::string::npos) << told;
  EXPECT_NEAR(std::stod(told.substr(at + key.size())), 13, 0.2) << told;
}

TEST(Debris, log_warns_where_the_plate_has_moved_away) {
  const Comm comm = testing_world();
  const Case asked = scene("[0, 0, -6000]", "every = 1\n");
  const std::vector<Body> bodies = plate(target_of(asked), 20, Vec3::Zero());
  World world;
  world.comm = comm;
  DebrisLog log(asked);
  // Beside 10 m / 4.
  for (const auto& [moved, lines] : {std::pair(0.5, 1), {1.5, 1}, {3.5, 2}}) {
    std::vector<Body> there = bodies;
    for (Body& body : there) body.position.z() -= moved;
    world.bodies = bodies_of(comm, there);
    EXPECT_EQ(log.read_out(world, moved).size(), lines);
  }
  ResultTable table;
  log.conclude(world, Rigid(), false, 4, table);
  EXPECT_NE(table.toml().find("plate_moved = 3.5 "), std::string::npos) << table.toml();
}

TEST(Debris, each_of_two_plates_is_measured_as_if_it_were_alone) {
  const std::string second = R"(
[[groups]]
name = "rear-2"
material = "al"
volume = {shape = "box", size = [50, 60, 2], center = [0, 0, -21]}
packing = {kind = "fcc", diameter = 1}
)";
  const Comm comm = testing_world();
  std::vector<Body> bodies = plate(target_of(scene()), 20, Vec3::Zero());
  for (const double depth : {10.0, 30.0})
    bodies.push_back({1, depth, {0.3 * depth, 0, -4 - depth}, {0, 0, -100 * depth}});
  bodies.push_back({2, 5, {1, 2, -40}, {0, 0, -700}});
  World world;
  world.comm = comm;
  world.bodies = bodies_of(comm, bodies);
  const auto results = [&](const std::string& plates) {
    DebrisLog log(scene("[0, 0, -6000]", "every = 1\n", plates, second));
    log.read_out(world, 1);
    Scalars scalars;
    log.save(scalars);
    DebrisLog resumed(scene("[0, 0, -6000]", "every = 1\n", plates, second));
    resumed.load(scalars);
    ResultTable table;
    resumed.conclude(world, Rigid(), false, 2, table);
    return table.toml();
  };
  std::string alone = results(R"(plate = "plate")") + "\n" + results(R"(plate = "rear-2")");
  for (const char* section : {"[debris", "[cloud"}) {
    const std::size_t length = std::string(section).size();
    alone.insert(alone.rfind(section) + length, "_rear_2");
    alone.insert(alone.find(section) + length, "_plate");
  }
  EXPECT_EQ(results(R"(plates = ["plate", "rear-2"])"), alone);
  for (const char* wrong :
       {R"(plates = [])", R"(plates = ["plate", "ball"])", "", R"(plates = ["plate", "plate"])",
        "plate = \"plate\"\nplates = [\"rear-2\"]"})
    EXPECT_THROW(scene("[0, 0, -6000]", "", wrong, second), Error) << wrong;
}

}  // namespace
}  // namespace spall
