// Small versions of the asteroid scenes: what must come out of them, on any number of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "analysis/clumps.hpp"
#include "base/first_rank.hpp"
#include "output/files.hpp"
#include "output/restart.hpp"
#include "output/stored_bodies.hpp"
#include "run/plan.hpp"
#include "run_series.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

constexpr double G = 6.67430e-11;

constexpr const char* rock = R"(
[materials.rock]
density = "2000 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
cohesion_range = "1 cm"
[gravity]
method = "direct"
)";

std::string folder_of(const std::string& name) {
  return folder_of_run("scenes_" + name);
}

/// Runs a case and gives its results back, on every rank.
toml::table results_of(const std::string& name, const std::string& text) {
  const std::string folder = folder_of(name);
  run_case(testing_world(), parse_case(text, name + ".toml"), folder, Former::overwrite);
  return results_in(folder);
}

double value(const toml::table& results, const char* section, const char* key) {
  return results[section][key].value<double>().value();
}

/// A settled pile of 200 boulders of 1 m, made once: the restart file that holds it.
std::string settled_pile() {
  static const std::string file = [] {
    const auto results = results_of("pile", std::string(rock) + R"(
[[groups]]
name = "cloud"
material = "rock"
volume = {shape = "sphere", radius = "9 m"}
packing = {kind = "random", radius = "1 m", count = 200}
[[phases]]
name = "settling"
step = "10 s"
duration = "4 h"
until = "settled"
settled_speed = "0.2 mm/s"
)");
    EXPECT_GT(value(results, "pile", "packing_fraction"), 0.55);
    EXPECT_LT(value(results, "pile", "packing_fraction"), 0.64);
    return folder_of("pile") + "/after_settling.h5";
  }();
  return file;
}

double density_of_pile() {  // bulk
  static const double packing =
      toml::parse_file((std::filesystem::path(settled_pile()).parent_path() / "results.toml")
                           .string())["pile"]["packing_fraction"]
          .value<double>()
          .value();
  return 2000 * packing;
}

/// All bodies at the end of a run's last phase, by id.
Bodies bodies_after(const std::string& name, const std::string& phase) {
  const Comm self(MPI_COMM_SELF);
  Bodies rows = read_restart(self, folder_of(name) + "/after_" + phase + ".h5").bodies;
  Bodies bodies = rows;
  for_each_field(bodies, [&](const auto&, auto& values) {
    const auto from = values;
    for (Index b = 0; b < rows.owned; ++b) values[rows.id[b]] = from[b];
  });
  return bodies;
}

/// Mass of the largest set of bodies in touch, without `primary`.
Clump largest_clump(const Bodies& bodies, std::vector<BodyId>& name, BodyId primary) {
  const Comm self(MPI_COMM_SELF);
  Links links;
  for (Index i = 0; i < bodies.owned; ++i)
    for (Index j = i + 1; j < bodies.owned; ++j)
      if ((bodies.position[i] - bodies.position[j]).norm() <
          bodies.radius[i] + bodies.radius[j] + 0.01) {
        links.i.push_back(i);
        links.j.push_back(j);
      }
  name = find_clumps(self, Ghosts(), bodies, links);
  if (primary >= 0) name[primary] = -1;
  return heaviest_clumps(self, bodies, name, 1).at(0);
}

double mass_in_touch(const Bodies& bodies) {
  std::vector<BodyId> name;
  return largest_clump(bodies, name, -1).mass;
}

/// The same with what its gravity holds.
double largest_remnant(const Bodies& bodies, BodyId primary = -1) {
  std::vector<BodyId> name;
  const Clump largest = largest_clump(bodies, name, primary);
  return add_bound_bodies(Comm(MPI_COMM_SELF), bodies, G, largest, name).mass;
}

std::string group(const std::string& name, const std::string& volume, const std::string& more) {
  return fmt::format(R"(
[[groups]]
name = "{}"
material = "rock"
volume = {{{}}}
packing = {{kind = "file", file = "{}", motion = "none"}}
{}
)",
                     name, volume, settled_pile(), more);
}

constexpr double mass_of_pile = 200 * 2000 * 4 * pi / 3;

TEST(StoredPile, is_placed_spun_carved_and_weighed_as_asked) {
  const Comm self(MPI_COMM_SELF);
  const std::string phase = "[[phases]]\nname = \"x\"\nstep = 1\nduration = 1\n";
  const Case whole = with_stored_bodies(
      parse_case(rock +
                     group("a", "radius = 100, center = [1000, 0, 0]",
                           "velocity = [0, 3, 0]\nspin = [0, 0, 0.01]\ntotal_mass = 5e6") +
                     phase,
                 "x.toml"));
  const Bodies bodies = make_bodies(whole, self);
  ASSERT_EQ(bodies.owned, 200);
  double mass = 0;
  Vec3 center = Vec3::Zero();
  for (Index b = 0; b < bodies.owned; ++b) {
    mass += bodies.mass[b];
    center += bodies.mass[b] * bodies.position[b] / 5e6;
    const Vec3 arm = bodies.position[b] - Vec3(1000, 0, 0);
    EXPECT_EQ(bodies.velocity[b], Vec3(-0.01 * arm.y(), 3 + 0.01 * arm.x(), 0));
    EXPECT_EQ(bodies.angular_velocity[b], Vec3(0, 0, 0.01));
  }
  EXPECT_NEAR(mass, 5e6, 1e-6);
  EXPECT_NEAR((center - Vec3(1000, 0, 0)).norm(), 0, 1e-9);

  const Case part = with_stored_bodies(parse_case(
      rock + group("a", "shape = \"ellipsoid\", size = [10, 8, 6]", "") + phase, "x.toml"));
  const Bodies carved = make_bodies(part, self);
  Index inside = 0;
  for (const Vec3& x : bodies.position)
    inside += ((x - Vec3(1000, 0, 0)).array() / Eigen::Array3d(5, 4, 3)).matrix().norm() <= 1;
  EXPECT_EQ(carved.owned, inside);
  EXPECT_GT(inside, 20);
  EXPECT_DOUBLE_EQ(carved.mass[0], 2000 * 4 * pi / 3);

  // Bodies keep their masses, and who asks for another density is told.
  const auto told = [&](const std::vector<std::string>& changes) {
    const Case scene = with_stored_bodies(
        parse_case(rock + group("a", "radius = 100", "") + phase, "x.toml", changes));
    return describe_phases(scene, measure_groups(scene));
  };
  const std::string note = "groups.a: masses are those of";
  EXPECT_EQ(told({}).find(note), std::string::npos);
  EXPECT_NE(told({"materials.rock.density=3000"}).find(note), std::string::npos);
  EXPECT_EQ(told({"materials.rock.density=3000", "groups.a.total_mass=5e6"}).find(note),
            std::string::npos);
}

/// A copy of `pile`, pile.h5, and a surface, tetrahedron.obj.
const std::string tetrahedron =
    "v 0 0 0\nv 9 0 0\nv 0 9 0\nv 0 0 9\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

void write_files_of_bodies(const std::string& folder, const std::string& pile) {
  std::filesystem::create_directories(folder);
  std::filesystem::copy_file(pile, folder + "/pile.h5",
                             std::filesystem::copy_options::overwrite_existing);
  write_whole(folder + "/tetrahedron.obj", tetrahedron);
}

TEST(InputFiles, are_those_of_rank_0_wherever_the_others_are) {
  const std::string folder = folder_of("files"), pile = settled_pile();
  const Comm comm = testing_world();
  on_first_rank(comm, [&] {
    write_files_of_bodies(folder, pile);
    write_whole(folder + "/metal.toml",
                "density = 2703\nsound_speed = 5350\nhugoniot_slope = 1.34\ngruneisen = 1.97\n"
                "youngs_modulus = 68.9e9\npoisson_ratio = 0.33\n");
    write_whole(folder + "/case.toml", R"(
[materials.rock]
density = 2000
[materials.metal]
file = "metal.toml"
[[groups]]
name = "shape"
material = "metal"
volume = {shape = "mesh", file = "tetrahedron.obj", center = [100, 0, 0]}
packing = {kind = "simple_cubic", radius = 0.5}
[[groups]]
name = "pile"
material = "rock"
volume = {radius = 100}
packing = {kind = "file", file = "pile.h5"}
[[phases]]
name = "x"
step = 1
duration = 1
)");
  });
  const auto here = std::filesystem::current_path();
  std::filesystem::current_path(comm.rank == 0 ? folder : "/");
  const InputFiles files(comm);
  const Bodies bodies =
      make_bodies(with_stored_bodies(read_case("case.toml", {}, files), files), comm);
  const std::string nowhere = complaint_of([&] { read_case("gone.toml", {}, files); });
  std::filesystem::current_path(here);
  EXPECT_EQ(nowhere, "there is no file 'gone.toml'");
  const Case alone = read_case(folder + "/case.toml");
  const Bodies expected = make_bodies(with_stored_bodies(alone), Comm(MPI_COMM_SELF));
  EXPECT_GT(expected.owned, 200);
  EXPECT_EQ(comm.sum(std::int64_t{bodies.owned}), expected.owned);
  Vec3 sum = Vec3::Zero(), wanted = Vec3::Zero();
  for (Index b = 0; b < bodies.owned; ++b) sum += bodies.mass[b] * bodies.position[b];
  for (Index b = 0; b < expected.owned; ++b) wanted += expected.mass[b] * expected.position[b];
  EXPECT_LT((comm.sum(sum) - wanted).norm(), 1e-12 * wanted.norm());
}

TEST(Mesh, that_flies_at_a_wall_is_as_wide_as_its_file_says) {
  const std::string folder = folder_of("mesh");
  const Comm comm = testing_world();
  on_first_rank(comm, [&] {
    std::filesystem::create_directories(folder);
    write_whole(folder + "/tetrahedron.obj", tetrahedron);
  });
  const auto told = [&](const std::string& unit, const std::string& asked) {
    const std::string text = R"([materials.al]
library = "aluminium_6061_t6"
[solid]
courant = 0.2
[[groups]]
name = "wall"
material = "al"
volume = {shape = "box", size = ["14 mm", "14 mm", "3 mm"]}
packing = {kind = "fcc", diameter = "1 mm", orientation = "random"}
[[groups]]
name = "ball"
material = "al"
volume = {shape = "mesh", file = "tetrahedron.obj", center = [0, 0, "20 mm"], unit = ")" +
                             unit + R"("}
packing = {kind = "fcc", diameter = "0.5 mm"}
velocity = [0, 0, "-3 km/s"]
[[phases]]
name = "impact"
method = "solid"
step = "0.1 us"
duration = "10 us"
)" + asked;
    on_first_rank(comm, [&] { write_whole(folder + "/case.toml", text); });
    return complaint_of([&] { read_case(folder + "/case.toml", {}, InputFiles(comm)); });
  };
  EXPECT_EQ(told("0.5 mm", "[[shields]]\nwall = \"wall\"\n"), "");
  EXPECT_NE(told("3 mm", "[[shields]]\nwall = \"wall\"\n").find("flies at its rim, or past it"),
            std::string::npos);
  EXPECT_EQ(told("0.5 mm", "[debris]\nprojectile = \"ball\"\nplate = \"wall\"\n"), "");
}

TEST(Restart, goes_on_without_the_files_of_its_bodies) {
  const std::string folder = folder_of("left"), pile = settled_pile();
  const Comm comm = testing_world();
  on_first_rank(comm, [&] {
    write_files_of_bodies(folder, pile);
    write_whole(folder + "/case.toml", R"(
[materials.rock]
density = 2000
[[groups]]
name = "shape"
material = "rock"
volume = {shape = "mesh", file = "tetrahedron.obj", center = [100, 0, 0]}
packing = {kind = "simple_cubic", radius = 0.5}
[[groups]]
name = "pile"
material = "rock"
volume = {radius = 50}
packing = {kind = "file", file = "pile.h5"}
[[phases]]
name = "one"
step = 1
duration = 2
[[phases]]
name = "two"
step = 1
duration = 2
)");
  });
  const Case scene = read_case(folder + "/case.toml", {}, InputFiles(comm));
  EXPECT_TRUE(run_case(comm, scene, folder + "/run", Former::overwrite));
  on_first_rank(comm, [&] {
    for (const char* file : {"/pile.h5", "/tetrahedron.obj"})
      std::filesystem::remove(folder + file);
  });
  const std::string restart = folder + "/run/after_one.h5";
  EXPECT_TRUE(resume_case(comm, restart, {folder + "/again", Former::overwrite, {}, false}));
  PlanRequest request;
  request.ranks = {2};
  const bool planned = plan(comm, restart, request).find("efficiency") != std::string::npos;
  EXPECT_EQ(planned, comm.rank == 0);
  // Groups as they are and by the recipe.
  const Case whole =
      with_stored_bodies(parse_case(std::string(rock) + group("a", "radius = 100", "") +
                                        "[[phases]]\nname = \"x\"\nstep = 1\nduration = 1\n",
                                    "x.toml"));
  const auto made = measure_bodies(comm, whole, make_bodies(whole, comm));
  const auto told = measure_groups(whole);
  ASSERT_EQ(made.size(), 1u);
  EXPECT_EQ(made[0].count, told[0].count);
  EXPECT_EQ(made[0].movable, told[0].movable);
  EXPECT_NEAR(made[0].mass, told[0].mass, 1e-12 * told[0].mass);
  EXPECT_EQ(made[0].lightest, told[0].lightest);
  EXPECT_EQ(made[0].smallest, told[0].smallest);
  EXPECT_EQ(made[0].largest, told[0].largest);
}

const std::string materials_of_triple = "[materials.rock]\ndensity = 1000\n";

/// A restart file with a body at rest, one that flies and spins, and one that is fixed.
std::string stored_triple(const Vec3& period = Vec3::Zero()) {
  const Comm self(MPI_COMM_SELF);
  RestartState state;
  state.period = period;
  Bodies& bodies = state.bodies;
  bodies.owned = 3;
  resize(bodies, 3);
  for (Index b = 0; b < 3; ++b) {
    bodies.id[b] = b;
    bodies.radius[b] = 1;
    bodies.mass[b] = b == 2 ? infinity : 1.0 + 2 * b;
    bodies.position[b] = Vec3(4 * b, 0, 0);
  }
  bodies.velocity[1] = Vec3(1, 2, 3);
  bodies.angular_velocity[1] = Vec3(0, 0, 5);
  const std::string file = folder_of("triple") + fmt::format(".{}.h5", testing_world().rank);
  std::filesystem::create_directories(std::filesystem::path(file).parent_path());
  write_restart(self, file, state);
  return file;
}

TEST(StoredPile, keeps_velocities_spins_and_what_is_fixed) {
  const std::string file = stored_triple();
  const auto made = [&](const std::string& packing, const std::string& group,
                        const std::string& phase = "") {
    const std::string text = fmt::format(
        "[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nvolume = {{radius = 100, center = [0, 9, "
        "0]}}\npacking = {{kind = \"file\", file = \"{}\"{}}}\n{}[[phases]]\nname = \"x\"\nstep = "
        "1\nduration = 1\n{}",
        file, packing, group, phase);
    return make_bodies(with_stored_bodies(parse_case(materials_of_triple + text, "x.toml")),
                       Comm(MPI_COMM_SELF));
  };
  // A quarter turn about z: x becomes y. The centre of mass of what moves is at (3, 0, 0).
  const Bodies turned = made(", rotation = [0, 0, 1.5707963267948966]", "");
  ASSERT_EQ(turned.owned, 3);
  const auto expect_near = [](const Vec3& is, const Vec3& wanted) {
    EXPECT_LT((is - wanted).norm(), 1e-14) << is.transpose();
  };
  expect_near(turned.position[0], Vec3(0, 6, 0));
  expect_near(turned.position[1], Vec3(0, 10, 0));
  expect_near(turned.position[2], Vec3(0, 14, 0));
  expect_near(turned.velocity[0], Vec3::Zero());
  expect_near(turned.velocity[1], Vec3(-2, 1, 3));
  expect_near(turned.angular_velocity[1], Vec3(0, 0, 5));
  EXPECT_EQ(turned.mass, (std::vector<double>{1, 3, infinity}));
  EXPECT_EQ(turned.velocity[2], Vec3(Vec3::Zero()));

  const Bodies resting = made(", motion = \"none\"", "total_mass = 8\n");
  for (const Vec3& v : resting.velocity) EXPECT_EQ(v, Vec3(Vec3::Zero()));
  EXPECT_EQ(resting.mass, (std::vector<double>{2, 6, infinity}));
  EXPECT_EQ(
      complaint_of([&] { made("", "velocity = [1, 0, 0]\n"); }),
      "x.toml:3:1: groups.a: velocity and spin would move bodies of '" + file + "' that are fixed");
  EXPECT_EQ(complaint_of([&] { made("", "", "remove_drift = true\n"); }),
            "x.toml:3:1: groups.a: '" + file +
                "' has fixed bodies: they would stay where they are while x.toml:8:1: "
                "phases.x.remove_drift moves all others");
  std::filesystem::remove(file);
}

TEST(StoredPile, keeps_clear_of_its_own_images_unless_it_lay_so_before) {
  const auto made = [&](const Vec3& stored_period, const std::string& size,
                        const std::string& packing = "") {
    const std::string file = stored_triple(stored_period);
    const std::string text = fmt::format(R"(
[periodic]
low = [-20, -20, -20]
size = {}
[penalty]
model = "hooke"
stiffness = 1e6
[contact]
restitution = 0.5
[[groups]]
name = "a"
material = "rock"
volume = {{radius = 100}}
packing = {{kind = "file", file = "{}"{}}}
[[phases]]
name = "x"
method = "penalty"
step = 1e-3
duration = 1
)",
                                         size, file, packing);
    return complaint_of([&] {
      make_bodies(with_stored_bodies(parse_case(materials_of_triple + text, "x.toml")),
                  Comm(MPI_COMM_SELF));
    });
  };
  // Two diameters of 2 m lie between the three: at 0, 4 and 8 m along x.
  const std::string overlaps = "body 2 at (5, 0, 0) m overlaps an image of body 0 of groups.a";
  EXPECT_EQ(made(Vec3::Zero(), "[10.1, 0, 0]"), "");
  EXPECT_NE(made(Vec3::Zero(), "[9.5, 0, 0]").find(overlaps), std::string::npos);
  EXPECT_NE(made(Vec3(9.6, 9.5, 0), "[9.5, 0, 0]").find(overlaps), std::string::npos);
  EXPECT_EQ(made(Vec3(9.5, 0, 0), "[9.5, 0, 0]"), "");
  EXPECT_EQ(made(Vec3(9.5, 0, 0), "[0, 9.5, 0]"), "");
  // Turned, it lies along y and has other images.
  const std::string turn = ", rotation = [0, 0, 1.5707963267948966]";
  EXPECT_EQ(made(Vec3(9.5, 0, 0), "[9.5, 0, 0]", turn), "");
  EXPECT_NE(made(Vec3(9.5, 9.5, 0), "[0, 9.5, 0]", turn).find("an image of body"),
            std::string::npos);
}

TEST(StoredPile, that_is_not_there_or_none_is_told_with_its_group) {
  const auto complaint = [](const std::string& file) -> std::string {
    return complaint_of([&] {
      with_stored_bodies(
          parse_case(std::string(rock) +
                         "[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nvolume = {radius = 1}"
                         "\npacking = {kind = \"file\", file = \"" +
                         file + "\"}\n[[phases]]\nname = \"x\"\nstep = 1\nduration = 1\n",
                     "x.toml"));
    });
  };
  EXPECT_EQ(complaint("nowhere.h5"), "x.toml:10:1: groups.a: there is no file 'nowhere.h5'");
  settled_pile();
  const std::string other = folder_of("pile") + "/results.toml";
  EXPECT_EQ(complaint(other).find("x.toml:10:1: groups.a: '" + other + "' is not a restart file"),
            0u);
}

/// Steps end 0.1, 0.2, 0.3 s after the impact, then 0.8 and 1.3 s after it.
TEST(ReadOuts, are_made_once_each_at_the_nearest_step_or_the_first_of_a_phase) {
  const auto results = results_of("read_outs", R"(read_out = [0.04, 0.26, 0.4, 0.9, 1.3]
[materials.rock]
density = 2000
[[groups]]
name = "four"
material = "rock"
volume = {shape = "box", size = [4, 4, 2]}
packing = {kind = "simple_cubic", radius = 1}
[[phases]]
name = "hit"
step = 0.1
duration = 0.3
impactor = {mass = 1, radius = 0.1, speed = 10, distance = 0.3}
[[phases]]
name = "after"
step = 0.5
duration = 1
)");
  std::vector<double> times;
  for (const toml::node& time : *results["read_out"]["since_impact"].as_array())
    times.push_back(*time.value<double>());
  ASSERT_EQ(times.size(), 5u);
  const double expected[] = {0.1, 0.3, 0.8, 0.8, 1.3};
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(times[k], expected[k], 1e-12) << k;
}

TEST(Pull, two_bodies_fall_as_kepler_lets_them) {
  if (testing_world().size > 2) GTEST_SKIP() << "two bodies lie on at most two ranks";
  results_of("pull", std::string(rock) + R"(
[[groups]]
name = "pair"
material = "rock"
volume = {shape = "box", size = ["200 m", "100 m", "100 m"]}
packing = {kind = "simple_cubic", radius = "40 m", spacing = "100 m"}
[[phases]]
name = "fall"
step = "10 s"
duration = "2000 s"
)");
  const Bodies pair = bodies_after("pull", "fall");
  const double x = (pair.position[1] - pair.position[0]).norm() / 100;
  const double unit = std::sqrt(1e6 / (2 * G * (pair.mass[0] + pair.mass[1])));
  const double time = unit * (std::sqrt(x * (1 - x)) + std::acos(std::sqrt(x)));
  EXPECT_NEAR(time, 2000, 0.2);  // a leapfrog of 10 s in a fall of 2283 s to contact
}

TEST(Merge, below_the_escape_speed_at_least_95_percent_are_one) {
  // The escape speed at contact is 6 mm/s.
  const auto results = results_of(
      "merge",
      rock + group("target", "radius = 100", "") +
          group("projectile", "radius = 4, center = [-14, 0, 0]", "velocity = [5e-3, 0, 0]") +
          "[[phases]]\nname = \"encounter\"\nstep = \"10 s\"\nduration = \"4000 s\"\n");
  EXPECT_LT(value(results, "conservation", "linear"), 1e-10);
  EXPECT_LT(value(results, "conservation", "angular"), 1e-10);
  const Bodies bodies = bodies_after("merge", "encounter");
  double all = 0;
  for (double m : bodies.mass) all += m;
  EXPECT_GT(all, 1.03 * mass_of_pile);
  EXPECT_GE(largest_remnant(bodies), 0.95 * all);
}

TEST(Spin, beyond_the_limit_bodies_lift_off_and_below_none) {
  const double limit = std::sqrt(4 * pi * G * density_of_pile() / 3);  // P = sqrt(3 pi / (G rho))
  const auto lifted = [&](const std::string& name, double part) {
    results_of(
        name, rock + group("pile", "radius = 100", fmt::format("spin = [0, 0, {}]", part * limit)) +
                  "[[phases]]\nname = \"spinning\"\nstep = \"10 s\"\nduration = \"3000 s\"\n");
    return 1 - mass_in_touch(bodies_after(name, "spinning")) / mass_of_pile;
  };
  EXPECT_LT(lifted("slow", 0.7), 0.03);  // a pile of 200 has bodies that only lie near others
  EXPECT_GT(lifted("fast", 1.3), 0.2);
}

TEST(Tides, tear_a_pile_apart_near_a_planet_and_leave_it_whole_far_away) {
  constexpr double planet = 6371e3, mu = G * 5.972e24;
  /// On a parabola from 4 planet radii before to 4 behind the closest approach, in planet radii.
  const auto whole = [&](const std::string& name, double approach) {
    const double q = approach * planet, r = 4 * planet, D = -std::sqrt(r / q - 1);
    const double nu = 2 * std::atan(D), v = std::sqrt(mu / (2 * q));
    const Vec3 out(std::cos(nu), std::sin(nu), 0), along(-out.y(), out.x(), 0);
    const Vec3 x = r * out, u = v * (std::sin(nu) * out + (1 + std::cos(nu)) * along);
    const double duration = -2 * std::sqrt(2 * q * q * q / mu) * (D + D * D * D / 3);
    results_of(name,
               std::string(rock) + R"(
[[groups]]
name = "planet"
material = "rock"
volume = {radius = "6371 km"}
total_mass = "5.972e24 kg"
)" +
                   group("pile", fmt::format("radius = 100, center = [{}, {}, 0]", x.x(), x.y()),
                         fmt::format("velocity = [{}, {}, 0]", u.x(), u.y())) +
                   fmt::format("[[phases]]\nname = \"passage\"\nstep = 20\nduration = {}\n",
                               20 * std::round(duration / 20)));
    return largest_remnant(bodies_after(name, "passage"), 0) / mass_of_pile;
  };
  EXPECT_LT(whole("near", 1.2), 0.5);
  EXPECT_GT(whole("far", 3.0), 0.99);
}

/// Of a basalt body of 10 km that one of this diameter hits at 5 km/s: the share that its gravity
/// holds in the end. First it breaks as a solid, then its pieces fly as rigid bodies.
double left_of_monolith(const std::string& name, const std::string& diameter) {
  const auto results = results_of(name, fmt::format(R"(
[materials.basalt]
library = "basalt"
[contact]
friction = 0.5
restitution = 0.3
[solid]
courant = 0.2
[gravity]
method = "direct"
[[groups]]
name = "target"
material = "basalt"
volume = {{radius = "10 km"}}
packing = {{kind = "fcc", diameter = "2.5 km"}}
[[groups]]
name = "projectile"
material = "basalt"
volume = {{diameter = "{0}", center = ["9.4 km", 0, "9.4 km"]}}
packing = {{kind = "fcc", diameter = "{0}"}}
velocity = [0, 0, "-5 km/s"]
[[phases]]
name = "breakup"
method = "solid"
step = "0.4 s"
duration = "40 s"
[[phases]]
name = "flight"
step = "2 s"
duration = "200 s"
[[phases]]
name = "reaccumulation"
step = "20 s"
duration = "2 h"
)",
                                                    diameter));
  EXPECT_LT(value(results, "conservation", "linear"), 1e-12);
  EXPECT_LT(std::abs(value(results, "conservation", "energy_unexplained")), 0.02);
  double target = 0, damage = 0;
  const Bodies broken = bodies_after(name, "breakup");
  for (Index b = 0; b < broken.owned; ++b)
    if (broken.group[b] == 0) {
      target += broken.mass[b];
      damage += std::min(broken.damage[b], 1.0) * broken.mass[b];
    }
  EXPECT_GT(damage, 0.9 * target);
  return largest_remnant(bodies_after(name, "reaccumulation")) / target;
}

TEST(Monolith, that_is_shattered_falls_together_unless_it_is_hit_too_hard) {
  // A quarter of Benz & Asphaug's threshold (Icarus 142 (1999) 5) and four times it.
  EXPECT_GT(left_of_monolith("shattered", "1.3 km"), 0.8);
  EXPECT_LT(left_of_monolith("dispersed", "3.3 km"), 0.4);
}

TEST(Nucleus, under_boulders_stays_whole_and_momentum_closes) {
  const auto results = results_of("nucleus", "read_out = [\"1 s\", \"4 s\"]\n" + std::string(rock) +
                                                 R"(
[[groups]]
name = "nucleus"
material = "rock"
volume = {radius = "8 m"}
[[groups]]
name = "boulders"
material = "rock"
volume = {shape = "hollow_sphere", radius = "10.4 m", inner_radius = "8 m"}
packing = {kind = "random", diameter = "1.2 m", count = 300}
[[phases]]
name = "settling"
step = "10 s"
duration = "2000 s"
[[phases]]
name = "impact"
step = "0.2 ms"
duration = "20 ms"
remove_drift = true
cohesion = "1 N"
impactor = {mass = "0.5 kg", diameter = "10 cm", speed = "4 km/s", distance = "0.5 m"}
[[phases]]
name = "evolution"
step = "0.1 s"
duration = "4 s"
)");
  EXPECT_LT(value(results, "deflection", "momentum_closure"), 1e-10);
  EXPECT_LT(value(results, "conservation", "linear"), 1e-10);
  EXPECT_LT(value(results, "conservation", "angular"), 1e-10);
  EXPECT_GE(value(results, "deflection", "dv"), value(results, "deflection", "dv_plastic"));
  const Bodies settled = bodies_after("nucleus", "settling");
  ASSERT_EQ(settled.owned, 301);
  ASSERT_EQ(settled.radius[0], 8);
  Index lying = 0;  // on the nucleus; the others lie on these
  for (Index b = 1; b < settled.owned; ++b) {
    const double height = (settled.position[b] - settled.position[0]).norm() - 8 - 0.6;
    EXPECT_GT(height, -1e-3 * 0.6);
    lying += height < 0.01;
  }
  EXPECT_GT(lying, 150);
}

TEST(Rest, a_pile_stays_as_it_is) {
  results_of("rest", rock + group("pile", "radius = 100", "") + R"(
[solver]
tolerance = 1e-4
[[phases]]
name = "settling"
step = "10 s"
duration = "16000 s"
[[phases]]
name = "rest"
step = "10 s"
duration = "4000 s"
)");
  const Bodies before = bodies_after("rest", "settling"), after = bodies_after("rest", "rest");
  const auto size = [](const Bodies& bodies) {  // radius of gyration
    Vec3 center = Vec3::Zero();
    double square = 0;
    for (const Vec3& x : bodies.position) center += x / static_cast<double>(bodies.owned);
    for (const Vec3& x : bodies.position)
      square += (x - center).squaredNorm() / static_cast<double>(bodies.owned);
    return std::sqrt(square);
  };
  EXPECT_NEAR(size(after), size(before), 1e-4 * size(before));
  Vec3 momentum = Vec3::Zero();
  // The escape speed is 6 mm/s. A boulder may lie loose in a void and fall there: in one of eight
  // piles one does, at 8e-6 to 5e-5 m/s, while all others are slower than 1e-8 m/s.
  Index moving = 0;
  for (Index b = 0; b < after.owned; ++b) {
    momentum += after.velocity[b];
    moving += after.velocity[b].norm() > 1e-5;
    EXPECT_LT(after.velocity[b].norm(), 6e-3 / 50);
  }
  EXPECT_LE(moving, 1);
  EXPECT_LT(momentum.norm() / 200, 1e-10 * 6e-3);
}

TEST(Dart, on_graded_boulders_closes_its_momentum) {
  const auto results =
      results_of("dart", "read_out = [\"1 s\", \"4 s\"]\n" + std::string(rock) + R"(
[[groups]]
name = "dimorphos"
material = "rock"
volume = {shape = "ellipsoid", size = ["24 m", "23 m", "16 m"]}
packing = {kind = "graded", radius = "3 m", smallest = "1.5 m", growth = 0.3, site = ["-12 m", 0, 0]}
total_mass = "4.3e6 kg"
[[phases]]
name = "settling"
step = "10 s"
duration = "600 s"
[[phases]]
name = "impact"
step = "0.2 ms"
duration = "20 ms"
remove_drift = true
cohesion = "0.1 N"
impactor = {mass = "0.6 kg", diameter = "20 cm", speed = "6.1 km/s", distance = "1 m", aim = "line"}
[[phases]]
name = "evolution"
step = "0.05 s"
duration = "4 s"
)");
  EXPECT_LT(value(results, "deflection", "momentum_closure"), 1e-10);
  EXPECT_LT(value(results, "conservation", "linear"), 1e-10);
  EXPECT_NEAR(value(results, "pile", "mass"), 4.3e6, 1e-6 * 4.3);
  EXPECT_GT(value(results, "deflection", "beta"), 1);
}

/// Materials are counted by their names' order, so that one more changes what bodies are of.
TEST(Scene, goes_on_with_a_material_that_is_added) {
  std::string text = R"(
[materials.rock]
density = 1000
[contact]
restitution = 0
[[phases]]
name = "before"
step = "1 ms"
duration = "2 ms"
[[phases]]
name = "impact"
step = "0.1 ms"
duration = "30 ms"
)";
  // The first is hit; each rank has one.
  for (const auto& [name, y, z] :
       {std::tuple("hit", 0, 0), std::tuple("left", 9, 0), std::tuple("right", -9, 0),
        std::tuple("above", 0, 9), std::tuple("below", 0, -9)})
    text += fmt::format(
        "[[groups]]\nname = \"{}\"\nmaterial = \"rock\"\nvolume = {{radius = 0.1, center = [0, "
        "{}, {}]}}\n",
        name, y, z);
  run_case(testing_world(), parse_case(text, "added.toml"), folder_of("added"), Former::overwrite);
  const ResumeOptions how{
      .folder = folder_of("added_after"),
      .former = Former::overwrite,
      .overrides = {"phases.impact.impactor={mass=1, radius=0.05, speed=10, distance=0.02}",
                    "contact.between=[{materials=[\"rock\", \"impactor\"], restitution=1}]",
                    "materials.impactor={density=1909.8593}"}};
  resume_case(testing_world(), folder_of("added") + "/after_before.h5", how);
  const toml::table results = results_in(how.folder);
  EXPECT_NEAR(value(results, "conservation", "kinetic"), 50, 1e-3);  // a share of 0.8 else is lost
}

}  // namespace
}  // namespace spall
