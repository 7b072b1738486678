// Forces and torques on walls and held groups: weights, momenta, and the columns that tell them.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/reactions.hpp"

#include <cmath>

#include "output/diagnostics.hpp"
#include "penalty_worlds.hpp"
#include "run_series.hpp"

namespace spall {
namespace {

const std::string rock = R"(
[materials.rock]
density = "2000 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
[penalty]
model = "hooke"
stiffness = 1e5
[output]
series_every = 0.05
)";
std::string frictionless() {
  std::string text = rock;
  return text.replace(text.find("friction = 0.5"), 14, "friction = 0.0");
}
/// Bodies that meet nobody, so that four ranks have one each.
std::string idle() {
  std::string text;
  for (int k = 1; k < 4; ++k)
    text += fmt::format(
        "[[groups]]\nname = \"idle_{}\"\nmaterial = \"rock\"\nvolume = {{radius = 0.1, center = "
        "[{}, 0, 9]}}\n",
        k, k);
  return text;
}
constexpr double g = 9.81;
constexpr double ball_mass = 2000 * 4 * pi / 3 * 1e-3;  // kg, of a radius of 0.1 m

std::string phase(const std::string& method, double step, double duration) {
  return fmt::format("[[phases]]\nname = \"only\"\nmethod = \"{}\"\nstep = {}\nduration = {}\n",
                     method, step, duration);
}
const std::vector<std::pair<std::string, double>> methods = {{"nonsmooth", 1e-3},
                                                             {"penalty", 2.5e-4}};

TEST(Reactions, a_resting_pile_weighs_on_its_floor_what_it_weighs) {
  for (const auto& [method, h] : methods) {
    // Eight balls between four walls, which bear no weight without friction.
    const auto rows = series_of(frictionless() + R"(
[gravity]
uniform = [0, 0, -9.81]
[[planes]]
name = "floor"
point = [0.3, 0.2, 0]
[[boxes]]
name = "bowl"
center = [0, 0, 5]
size = [0.402, 0.402, 20]
[[groups]]
name = "pile"
material = "rock"
volume = {shape = "box", size = [0.4, 0.4, 0.4], center = [0, 0, 0.2]}
packing = {kind = "simple_cubic", radius = 0.1}
)" + phase(method, h, 2));
    const double weight = 8 * ball_mass * g;
    const auto& row = rows.back();
    EXPECT_NEAR(row.at("floor_force_z"), -weight, 1e-4 * weight) << method;
    EXPECT_EQ(rows.front().at("floor_force_z"), 0);
    for (const char* side : {"x", "y"})
      EXPECT_NEAR(row.at(fmt::format("floor_force_{}", side)) +
                      row.at(fmt::format("bowl_{}_low_force_{}", side, side)) +
                      row.at(fmt::format("bowl_{}_high_force_{}", side, side)),
                  0, 1e-4 * weight)
          << method;
    EXPECT_EQ(row.at("bowl_z_high_force_z"), 0);
    // The pile stands about the origin, the torque is about the floor's point.
    EXPECT_NEAR(row.at("floor_torque_x"), 0.2 * weight, 2e-3 * weight) << method;
    EXPECT_NEAR(row.at("floor_torque_y"), -0.3 * weight, 2e-3 * weight) << method;
  }
}

TEST(Reactions, a_bounce_is_the_impulse_that_turns_a_ball_round) {
  // One bounce at 3 m/s: m (1 + e) v, whole and at once, in the mean over the row.
  for (const auto& [method, h] : methods) {
    const auto rows = series_of(rock + R"(
[solver]
prox = 0
tolerance = 1e-12
[[planes]]
[[groups]]
name = "ball"
material = "rock"
volume = {radius = 0.1, center = [0, 0, 0.4]}
velocity = [0, 0, -3]
)" + idle() + phase(method, h / 4, 0.3));
    double impulse = 0;
    for (const auto& row : rows) impulse += 0.05 * row.at("plane_0_force_z");
    EXPECT_NEAR(impulse, -ball_mass * 1.3 * 3, (method == "penalty" ? 1e-2 : 1e-10) * ball_mass)
        << method;
  }
}

/// A crowd in a closed box, of which nothing gets out.
Lab crowd_in_a_box(const ContactLaw& law) {
  std::vector<Sphere> spheres = crowd(60, 0.3, 2);
  Lab world =
      penalty_world(testing_world(), spheres,
                    {.model = PenaltyModel::hooke, .stiffness = 2e6, .rolling_friction = 0.1}, law);
  const double half = 1.2 * std::cbrt(60) + 1.5;
  for (int k = 0; k < 3; ++k)
    for (double side : {-1.0, 1.0})
      world.planes.push_back(
          {.point = side * half * Vec3::Unit(k), .normal = -side * Vec3::Unit(k)});
  return world;
}

TEST(Reactions, walls_receive_the_momentum_that_bodies_lose) {
  const ContactLaw law{.friction = 0.5, .restitution = 0.6};
  Lab rigid = crowd_in_a_box(law), soft = crowd_in_a_box(law);
  soft.cylinders.push_back({.point = {0.3, 0, 0}, .axis = {0, 0, 1}, .radius = 8});
  const Diagnostics before = diagnose(rigid);
  for (int k = 0; k < 300; ++k) nonsmooth_step(rigid, 2e-2, {.tolerance = 1e-6}, 1);
  for (int k = 0; k < 40; ++k) penalty_steps(soft, 5e-4, 50);
  for (const Lab* world : {&rigid, &soft}) {
    const Diagnostics now = diagnose(*world);
    EXPECT_GT(now.given_momentum.norm(), 0.1 * before.momentum_scale / 60);
    EXPECT_LE((now.momentum - now.given_momentum - before.momentum).norm(),
              1e-11 * before.momentum_scale);
  }
  // Rigid bodies that are taken out of walls gain a little angular momentum there.
  const Diagnostics now = diagnose(soft);
  EXPECT_LE((now.angular_momentum - now.given_angular_momentum - before.angular_momentum).norm(),
            1e-11 * before.angular_momentum_scale);
}

TEST(Reactions, are_the_same_on_any_number_of_ranks) {
  const ContactLaw law{.friction = 0.5, .restitution = 0.6};
  const auto run = [&](Lab world, const Comm& comm) {
    world.comm = comm;
    for (int k = 0; k < 20; ++k) penalty_steps(world, 5e-4, 50);
    std::vector<double> sums;
    for (std::size_t w = 0; w < 6; ++w) {
      const Reaction own =
          w < world.reactions.of_walls.size() ? world.reactions.of_walls[w] : Reaction{};
      for (const Vec3& v : {comm.sum(own.impulse), comm.sum(own.moment)})
        sums.insert(sums.end(), v.data(), v.data() + 3);
    }
    return sums;
  };
  const std::vector<double> many = run(crowd_in_a_box(law), testing_world());
  std::vector<Sphere> spheres = crowd(60, 0.3, 2);
  Lab one =
      penalty_world(alone(), spheres,
                    {.model = PenaltyModel::hooke, .stiffness = 2e6, .rolling_friction = 0.1}, law);
  one.planes = crowd_in_a_box(law).planes;
  const std::vector<double> single = run(std::move(one), alone());
  double largest = 0;
  for (double value : single) largest = std::max(largest, std::abs(value));
  EXPECT_GT(largest, 100);
  for (std::size_t k = 0; k < many.size(); ++k)
    EXPECT_NEAR(many[k], single[k], 1e-6 * largest) << k;  // collisions spread round-off
}

TEST(Reactions, a_drum_that_turns_takes_its_power_by_its_torque) {
  for (const auto& [method, h] : methods) {
    // A ring of held grains about y, half full, turns once in five seconds.
    const auto rows = series_of(rock + R"(
[gravity]
uniform = [0, 0, -9.81]
[[planes]]
name = "back"
point = [0, -0.11, 0]
normal = [0, 1, 0]
[[planes]]
name = "front"
point = [0, 0.11, 0]
normal = [0, -1, 0]
)" + [] {
      std::string ring;
      for (int k = 0; k < 36; ++k)
        ring += fmt::format(
            "[[groups]]\nname = \"ring_{}\"\nmaterial = \"rock\"\nvolume = {{radius = 0.1, center "
            "= "
            "[{}, 0, {}]}}\nmotion.rotation = {{point = [0, 0, 0], axis = [0, 1, 0], rate = \"0.2 "
            "rev/s\"}}\n",
            k, 1.2 * std::cos(2 * pi * k / 36), 1.2 * std::sin(2 * pi * k / 36));
      return ring;
    }() + R"(
[[groups]]
name = "grains"
material = "rock"
volume = {shape = "box", size = [1.4, 0.21, 1], center = [0, 0, -0.2]}
packing = {kind = "simple_cubic", radius = 0.1, spacing = 0.2}
)" + phase(method, h, 1));
    const double rate = 0.2 * 2 * pi;  // rad/s
    double torque = 0, work = 0, weight = 0;
    for (const auto& row : rows)
      for (int k = 0; k < 36; ++k) {
        torque += 0.05 * row.at(fmt::format("ring_{}_torque_y", k));
        weight += row.at(fmt::format("ring_{}_force_z", k)) / static_cast<double>(rows.size() - 1);
      }
    work = rows.back().at("prescribed_work");
    EXPECT_GT(work, 1) << method;
    EXPECT_NEAR(-torque * rate, work, 1e-2 * work) << method;  // chords instead of arcs
    EXPECT_NEAR(weight, -35 * ball_mass * g, 0.2 * 35 * ball_mass * g) << method;
  }
}

TEST(Walls, count_planes_first_and_cylinders_after_them) {
  std::vector<Plane> planes;
  for (double height : {0.0, 1.0}) planes.push_back({.point = {0, 0, height}});
  const std::vector<Cylinder> cylinders{{.point = {1, 2, 3}, .material = 4, .name = "first"},
                                        {.point = {5, 6, 7}, .material = 8, .name = "second"}};
  const Walls walls{planes, cylinders};
  EXPECT_EQ(walls.size(), 4u);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(walls.point(planes.size() + k), cylinders[k].point);
    EXPECT_EQ(walls.material(planes.size() + k), cylinders[k].material);
    EXPECT_EQ(walls.name(planes.size() + k), cylinders[k].name);
  }
}

TEST(Reactions, columns_bear_the_names_of_walls_and_held_groups) {
  const Case scene = parse_case(R"(
materials.rock.density = 1600
[[planes]]
name = "floor"
[[planes]]
point = [0, 0, -9]
[[boxes]]
name = "bin"
size = [50, 50, 50]
[[cylinders]]
radius = 9
[[cylinders]]
name = "drum"
radius = 8
[[groups]]
name = "a, b"
material = "rock"
fixed = true
volume = {radius = 1}
[[groups]]
name = "free"
material = "rock"
volume = {radius = 1, center = [3, 0, 0]}
[contact]
restitution = 0.5
[penalty]
model = "hooke"
stiffness = 1
[[phases]]
name = "only"
method = "penalty"
step = 1
duration = 1
)",
                                "x.toml");
  std::vector<std::string> names;
  for (const Column& column : ReactionRows(scene).columns())
    if (column.name.ends_with("_force_x")) names.push_back(column.name);
  EXPECT_EQ(names,
            (std::vector<std::string>{
                "floor_force_x", "plane_1_force_x", "bin_x_low_force_x", "bin_x_high_force_x",
                "bin_y_low_force_x", "bin_y_high_force_x", "bin_z_low_force_x",
                "bin_z_high_force_x", "cylinder_0_force_x", "drum_force_x", "a_ b_force_x"}));
  const auto columns = ReactionRows(scene).columns();
  EXPECT_EQ(columns[5].name, "floor_torque_z");
  EXPECT_EQ(columns[5].unit, "N m");
}

TEST(Reactions, of_a_resumed_run_go_on) {
  const Case scene = parse_case(R"(
materials.rock.density = 1600
[[planes]]
name = "floor"
[[groups]]
name = "free"
material = "rock"
volume = {radius = 1, center = [3, 0, 5]}
[[phases]]
name = "only"
step = 1
duration = 1
)",
                                "x.toml");
  ReactionRows rows(scene), resumed(scene);
  EXPECT_EQ(rows.row(0.5, {3, 0, 0, 0, 0, 0}), std::vector<double>(6, 0));
  Scalars scalars;
  rows.save(scalars);
  resumed.load(scalars);
  for (ReactionRows* one : {&rows, &resumed})
    EXPECT_EQ(one->row(2.5, {7, 0, -1, 0, 6, 0}), (std::vector<double>{2, 0, -0.5, 0, 3, 0}));
}

}  // namespace
}  // namespace spall
