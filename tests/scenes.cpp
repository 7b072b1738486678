// Small versions of the asteroid scenes: what must come out of them, on any number of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "spall/base/require.hpp"
#include "spall/output/restart.hpp"
#include "spall/output/stored_bodies.hpp"
#include "spall/run/run.hpp"
#include "spall/scene/scene.hpp"
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
  return std::filesystem::absolute(fmt::format("scenes_{}_{}", name, testing_world().size))
      .string();
}

/// Runs a case and gives its results back, on every rank.
toml::table results_of(const std::string& name, const std::string& text) {
  const std::string folder = folder_of(name);
  run_case(testing_world(), parse_case(text, name + ".toml"), folder);
  testing_world().any(false);  // rank 0 has written them
  return toml::parse_file(folder + "/results.toml");
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

std::string group(const std::string& name, const std::string& volume, const std::string& more) {
  return fmt::format(R"(
[[groups]]
name = "{}"
material = "rock"
volume = {{{}}}
packing = {{kind = "file", file = "{}"}}
{}
)",
                     name, volume, settled_pile(), more);
}

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
}

TEST(StoredPile, that_is_not_there_or_none_is_told_with_its_group) {
  const auto complaint = [](const std::string& file) -> std::string {
    try {
      with_stored_bodies(
          parse_case(std::string(rock) +
                         "[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nvolume = {radius = 1}"
                         "\npacking = {kind = \"file\", file = \"" +
                         file + "\"}\n[[phases]]\nname = \"x\"\nstep = 1\nduration = 1\n",
                     "x.toml"));
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(complaint("nowhere.h5"), "x.toml:10:1: groups.a: there is no file 'nowhere.h5'");
  settled_pile();
  const std::string other = folder_of("pile") + "/results.toml";
  EXPECT_EQ(complaint(other).find("x.toml:10:1: groups.a: '" + other + "' is not a restart file"),
            0u);
}

}  // namespace
}  // namespace spall
