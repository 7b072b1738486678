// Rock whose strength grows with pressure, and rubble that slides: strengths, heat, books, ranks,
// refusals.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/rock.hpp"

#include <cmath>

#include "scene/scene.hpp"
#include "solid_worlds.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3;  // m

const std::string rock = R"([[groups]]
name = "rock"
material = "rock"
volume = {shape = "sphere", radius = "3 mm"}
packing = {kind = "fcc", diameter = "1 mm"}
[[phases]]
name = "only"
method = "solid"
step = "10 ns"
duration = "20 ns"
[materials.rock]
library = "basalt"
[materials.rock.solid]
)";
const Solid& basalt() {
  static const Solid solid = *parse_case(rock, "x.toml").materials[0].solid;
  return solid;
}
const SolidLaw& breaking() {
  static const SolidLaw law = solid_law(basalt(), true, "basalt");
  return law;
}
/// No flaw opens.
const SolidLaw& lasting() {
  static const SolidLaw law = [] {
    SolidLaw without = breaking();
    without.flaws.k = 1e-100;
    return without;
  }();
  return law;
}

/// Pa, sqrt(J2) by Lundborg's formula with the constants of the file.
double intact(double pressure) {
  const double rubbed = 1.5 * pressure;
  return 1e8 + rubbed / (1 + rubbed / 3.4e9);
}

double pressure_of(const Eigen::Matrix3d& stress) {
  return -stress.trace() / 3;
}
/// sqrt(J2)
double shear_of(const Eigen::Matrix3d& stress) {
  return (stress + pressure_of(stress) * as_is).norm() / std::sqrt(2.0);
}

constexpr double h = 1e-9;
const Eigen::Matrix3d squeezing = -as_is;
const Eigen::Matrix3d shearing = [] {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(0, 1) = 1;
  return m;
}();

TEST(Rock, flows_at_the_shear_stress_of_its_pressure_and_damage) {
  for (double damage : {0.0, 0.3, 0.9, 1.0})
    for (double squeezed : {0.001, 0.01, 0.05}) {  // along each axis
      Lab world = held_ball(d, lasting(), damage);
      deform(world, squeezed / (20 * h) * squeezing, h, 20);
      deform(world, 0.2 / (100 * h) * shearing, h, 100);
      const Eigen::Matrix3d stress = stress_of_the_middle(world);
      const double pressure = pressure_of(stress), Y = intact(pressure);
      const double expected = (1 - damage) * Y + damage * std::min(0.8 * pressure, Y);
      EXPECT_GT(pressure, 2.5 * squeezed * basalt().bulk_modulus());
      EXPECT_NEAR(shear_of(stress), expected, 1e-3 * expected) << damage << " " << squeezed;
      EXPECT_NEAR(stress(0, 1), expected, 0.02 * expected);  // along the shear
      EXPECT_EQ(of_the_middle_body(world, &Bodies::damage), damage);
    }
}

TEST(Rock, pressed_along_one_axis_follows_lundborg_s_curve) {
  Lab world = held_ball(d, lasting(), 0);
  double before = 0;
  for (double squeezed : {0.004, 0.02, 0.05, 0.1}) {
    const Eigen::Matrix3d rate = -Vec3(0, 0, 1) * Vec3(0, 0, 1).transpose();
    deform(world, (squeezed - before) / (50 * h) * rate, h, 50);
    before = squeezed;
    const Eigen::Matrix3d stress = stress_of_the_middle(world);
    const double pressure = pressure_of(stress);
    const double strain = std::log(of_the_middle_body(world, &Bodies::compression));
    const double elastic = 2 / std::sqrt(3.0) * basalt().shear_modulus() * strain;
    const double expected = std::min(elastic, intact(pressure));
    EXPECT_NEAR(shear_of(stress), expected, 0.01 * expected) << squeezed;
  }
  EXPECT_LT(intact(3e9), 0.7 * 1.5 * 3e9);  // by far from a straight line
}

TEST(Rock, that_has_failed_bears_shear_as_long_as_it_is_pressed) {
  Lab world = held_ball(d, lasting(), 1);
  deform(world, 0.01 / (20 * h) * squeezing, h, 20);
  deform(world, 0.1 / (100 * h) * shearing, h, 100);
  double last = infinity;
  for (int part = 0; part < 4; ++part) {
    deform(world, -0.004 / (20 * h) * squeezing, h, 20);
    const Eigen::Matrix3d stress = stress_of_the_middle(world);
    const double pressure = pressure_of(stress);
    EXPECT_LT(pressure, std::max(last, 1e-6 * basalt().bulk_modulus()));
    const double expected = 0.8 * std::max(0.0, pressure);
    EXPECT_NEAR(shear_of(stress), expected, 1e-3 * expected + 1e-6 * basalt().shear_modulus());
    last = pressure;
  }
  EXPECT_LT(last, 1e-6 * basalt().bulk_modulus());
}

TEST(Rock, its_friction_and_flow_become_heat) {
  for (double damage : {0.0, 1.0}) {
    Lab world = held_ball(d, lasting(), damage);
    deform(world, 0.02 / (50 * h) * squeezing, h, 50);
    deform(world, 0.2 / (100 * h) * shearing, h, 100);  // until it flows
    const double volume = of_the_middle(world, [](const Bodies& bodies, Index b) {
      const double spacing = 2 * bodies.radius[b];
      return std::vector<double>{spacing * spacing * spacing / std::sqrt(2.0) /
                                 bodies.compression[b]};
    })[0];
    const auto elastic = [&] {  // of shear; volume stays
      const double shear = shear_of(stress_of_the_middle(world));
      return shear * shear / (2 * basalt().shear_modulus()) * volume;
    };
    const double heat = of_the_middle_body(world, &Bodies::heat) + elastic();
    const double internal = of_the_middle_body(world, &Bodies::internal_energy);
    double work = 0;
    for (int step = 0; step < 100; ++step) {
      const double before = stress_of_the_middle(world)(0, 1);
      deform(world, 0.1 / (100 * h) * shearing, h, 1);
      work += 0.1 / 100 * volume * (before + stress_of_the_middle(world)(0, 1)) / 2;
    }
    EXPECT_NEAR(of_the_middle_body(world, &Bodies::internal_energy) - internal, work, 1e-3 * work);
    EXPECT_NEAR(of_the_middle_body(world, &Bodies::heat) + elastic() - heat, work, 1e-3 * work)
        << damage;
  }
}

TEST(Rock, shares_its_stress_so_that_all_of_it_is_borne) {
  const double pressure = 3e8, slides = std::sqrt(3.0) * 0.8 * pressure;
  for (double damage : {0.0, 0.4, 0.999})
    for (double whole : {0.3, 1.0, 1.4}) {
      const double t = whole * slides, s = (1 - damage) * t + damage * std::min(t, slides);
      EXPECT_NEAR(intact_stress(breaking(), damage, s, pressure), t, 1e-9 * t);
    }
}

// --- balls that meet and break ---

Lab two_balls(const Comm& comm, double speed) {
  std::vector<Sphere> all;
  for (int side : {-1, 1})
    for (Sphere s : ball(d, basalt().density, side < 0 ? as_is : turned, 3.2 * d)) {
      s.position += side * Vec3(3.8 * d, 0.3 * d, 0);
      s.velocity = -side * Vec3(speed, 0, 0);
      all.push_back(s);
    }
  Lab world = world_of(comm, all, breaking());
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.group[b] = all[world.bodies.id[b]].velocity.x() < 0;
  return world;
}
double mean_damage(const Lab& world) {
  double sum = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) sum += world.bodies.damage[b];
  return world.comm.sum(sum) / world.comm.sum(static_cast<double>(world.bodies.owned));
}

TEST(Rock, momenta_and_energy_are_kept_where_balls_meet_and_break) {
  const double speed = 300;
  std::vector<double> errors;
  for (double share : {0.1, 0.025}) {
    Lab world = two_balls(testing_world(), speed);
    const Sums before = sums_of(world);
    const double scale = before.kinetic / speed;
    solid_steps(world, share * d / breaking().sound_speed(),
                static_cast<int>(std::lround(40 / share)));
    const Sums after = sums_of(world);
    EXPECT_LE((after.momentum - before.momentum).norm(), 1e-12 * scale);
    EXPECT_LE((after.angular - before.angular).norm(), 1e-12 * scale * 4 * d);
    EXPECT_GT(after.heat, 0.2 * before.kinetic);
    EXPECT_GT(mean_damage(world), 0.1);
    const double contacts = world.solid.energy(world) - (after.internal - after.heat);
    errors.push_back(std::abs(after.kinetic + after.internal + contacts - before.kinetic) /
                     before.kinetic);
  }
  EXPECT_LT(errors[0], 0.02);
  EXPECT_LT(errors[1], 0.5 * errors[0]);
}

TEST(Rock, breaks_alike_on_any_number_of_ranks_and_after_a_restart) {
  Lab one = two_balls(alone(), 300), many = two_balls(testing_world(), 300);
  const double step = 0.1 * d / breaking().sound_speed();
  for (int part = 0; part < 2; ++part) {
    solid_steps(one, step, 60);
    solid_steps(many, step, 60);
    many.solid.restart_pairs(many, {});
  }
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-8 * d) << k;
  EXPECT_GT(mean_damage(one), 0.01);
}

// --- how cases ask for it ---

std::string complaint(const std::string& more) {
  return complaint_of([&] { parse_case(rock + more, "x.toml"); });
}

TEST(RockCase, refuses_what_does_not_go_together) {
  EXPECT_EQ(complaint(""), "");
  EXPECT_NE(complaint("johnson_cook_a = \"1 GPa\"").find("lundborg_limit and johnson_cook_a"),
            std::string::npos);
  EXPECT_EQ(complaint("lundborg_cohesion = \"4 GPa\""),
            "x.toml:1:1: groups.rock.material = \"rock\": lundborg_limit = 3.5e+09 Pa must be more "
            "than lundborg_cohesion = 4e+09 Pa");
}

TEST(RockCase, needs_all_of_lundborg_s_constants_and_flaws) {
  const auto complains = [](const Solid& solid) {
    return complaint_of([&] { solid_law(solid, true, "x"); });
  };
  Solid half = basalt();
  half.rock.friction = 0;
  EXPECT_EQ(complains(half),
            "x: a solid with a stress needs lundborg_friction beside the others of Lundborg");
  half = basalt();
  half.weibull = {};
  EXPECT_EQ(complains(half), "x: a solid with a stress needs weibull_k beside lundborg_limit");
  half = basalt();
  half.rock = {.failed_friction = 0.6};
  EXPECT_EQ(complains(half),
            "x: a solid with a stress needs johnson_cook_a, steinberg_y0, yield_strength or "
            "lundborg_limit");
  half.yield_strength = 1e9;
  EXPECT_EQ(complains(half), "");
  half.johnson_cook.c = 0.01;
  EXPECT_EQ(complains(half), "x: johnson_cook_b, c, n and m need johnson_cook_a beside them");
  half = basalt();
  half.melting_point = 273;
  EXPECT_EQ(complains(half),
            "x: melting_point = 273 K: solids begin at 298 K, and would be liquid");
}

}  // namespace
}  // namespace spall
