// Impacts come out as restitution says, and what bounces comes to rest, with settings as they are.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <numbers>
#include <random>

#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

const SolverSettings as_they_are;

TEST(FreshImpact, leaves_as_restitution_says_whatever_the_prox) {
  for (const double e : {0.0, 0.3, 0.8, 1.0})
    for (const double friction : {0.0, 0.5}) {
      Lab world = make_world(testing_world(),
                             {{.position = Vec3(-1.0005, 0, 0), .velocity = Vec3(1, 0, 0)},
                              {.mass = 3, .position = Vec3(1, 0, 0)}},
                             {.friction = friction, .restitution = e});
      advance(world, 1e-3, 2, as_they_are);
      const std::vector<Sphere> after = spheres_of(world);
      EXPECT_NEAR(after[1].velocity.x() - after[0].velocity.x(), e, 1e-6) << e;
      EXPECT_NEAR(after[1].velocity.x(), (1 + e) / 4, 1e-6) << e;
    }
}

/// Five balls of radius 1 in a row, the first of which flies at speed 1 to the others.
std::vector<Sphere> cradle(double gap) {
  std::vector<Sphere> balls;
  for (int k = 0; k < 5; ++k) balls.push_back({.position = Vec3((2 + gap) * k, 0, 0)});
  balls[0].velocity.x() = 1;
  return balls;
}

TEST(FreshImpact, touching_balls_of_a_cradle_leave_as_the_simultaneous_law_says) {
  Lab world = make_world(testing_world(), cradle(0), {.restitution = 1});
  advance(world, 1e-4, 3, as_they_are);
  const std::vector<Sphere> after = spheres_of(world);
  EXPECT_NEAR(after[0].velocity.x(), -0.6, 1e-6);
  for (int k = 1; k < 5; ++k) EXPECT_NEAR(after[k].velocity.x(), 0.4, 1e-6) << k;
}

TEST(FreshImpact, balls_of_a_cradle_a_thousandth_apart_pass_the_impact_on_to_the_last) {
  Lab world = make_world(testing_world(), cradle(1e-3), {.restitution = 1});
  advance(world, 3e-4, 40, as_they_are);
  const std::vector<Sphere> after = spheres_of(world);
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(after[k].velocity.x(), 0, 1e-6) << k;
  EXPECT_NEAR(after[4].velocity.x(), 1, 1e-6);
}

/// As the first step of didymoon's impact, with settings as they are.
TEST(FreshImpact, on_a_pile_leaves_the_energy_of_the_converged_step_within_a_hundredth) {
  std::vector<Sphere> pile;
  constexpr int most = 6;
  for (int i = -most; i <= most; ++i)
    for (int j = -most; j <= most; ++j)
      for (int k = -most; k <= most; ++k)
        if ((i + j + k) % 2 == 0 && i * i + j * j + k * k <= most * most)
          pile.push_back(
              {.position = std::numbers::sqrt2 * Vec3(i, j, k)});  // a lattice that touches
  pile.push_back({.mass = 0.1,
                  .position = Vec3(std::numbers::sqrt2 * most + 2.001, 0, 0),
                  .velocity = Vec3(-4000, 0, 0)});
  const auto energy_after = [&](const SolverSettings& settings) {
    Lab world = make_world(testing_world(), pile, {.friction = 0.5, .restitution = 0.3});
    advance(world, 1e-6, 1, settings);
    double energy = 0;
    for (const Sphere& s : spheres_of(world))
      energy += s.mass * s.velocity.squaredNorm() / 2 +
                moment_of_inertia(s.mass, s.radius) * s.spin.squaredNorm() / 2;
    return energy;
  };
  const double converged = energy_after({.tolerance = 1e-8, .max_iterations = 20000, .prox = 0});
  EXPECT_LT(converged, 0.5 * 0.1 * 4000 * 4000 / 2);  // it has hit
  EXPECT_NEAR(energy_after(as_they_are), converged, 0.01 * converged);
}

constexpr double g = 9.81;

TEST(FreshImpact, a_bouncing_ball_loses_a_share_of_its_height_at_each_bounce_and_rests) {
  for (const double e : {0.3, 0.65, 0.8, 0.9, 0.95}) {
    Lab world = make_world(testing_world(), {{.radius = 0.01, .position = Vec3(0, 0, 0.11)}},
                           {.restitution = e});
    world.planes = {Plane{}};
    world.uniform_gravity = Vec3(0, 0, -g);
    // Bounces of a ball dropped from height 0.1 m take sqrt(2 H/g) (1 + e)/(1 - e) in all.
    const double h = 1e-3, all = std::sqrt(2 * 0.1 / g) * (1 + e) / (1 - e);
    double fastest_late = 0, highest_late = 0;
    for (int k = 0; k * h < all + 0.2; ++k) {
      nonsmooth_step(world, h, as_they_are, 1);
      if (k * h < all + 0.1) continue;
      const Sphere ball = spheres_of(world)[0];
      fastest_late = std::max(fastest_late, ball.velocity.norm());
      highest_late = std::max(highest_late, ball.position.z() - ball.radius);
    }
    EXPECT_LT(fastest_late, 1e-6 * g * h) << e;
    EXPECT_LT(highest_late, 3 * g * h * h) << e;
  }
}

TEST(FreshImpact, a_ball_bounces_to_the_height_that_restitution_leaves_it) {
  // Whatever the gap at the begin of the step of its impact: starts a fraction of a step apart.
  for (const double e : {0.5, 0.9, 1.0})
    for (int part = 0; part < 10; ++part) {
      const double height = 0.1 * (1 + 0.003 * part), h = 1e-3;
      Lab world =
          make_world(testing_world(), {{.radius = 0.01, .position = Vec3(0, 0, height + 0.01)}},
                     {.restitution = e});
      world.planes = {Plane{}};
      world.uniform_gravity = Vec3(0, 0, -g);
      double highest = 0;
      bool bounced = false;
      for (int k = 0; k < 400; ++k) {
        nonsmooth_step(world, h, as_they_are, 1);
        const Sphere ball = spheres_of(world)[0];
        const bool rises = ball.velocity.z() > 0;
        if (bounced && !rises) break;
        bounced |= rises;
        if (bounced) highest = std::max(highest, ball.position.z() - ball.radius);
      }
      // The highest point lies between two steps: up to g h^2/8 above what is seen.
      EXPECT_NEAR(highest, e * e * height, g * h * h) << e << ' ' << part;
    }
}

/// m/s: rms speed of 400 grains of 1 cm poured into a box, after 2.5 s.
double rms_speed_of_a_bed(double e) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> shift(-1e-3, 1e-3);
  std::vector<Sphere> grains;
  for (int k = 0; k < 400; ++k) {
    const int x = k % 8, y = k / 8 % 8, z = k / 64;
    grains.push_back(
        {.radius = 0.005,
         .mass = 1e-3,
         .position = Vec3(0.0125 * x + 0.0075 + shift(random), 0.0125 * y + 0.0075 + shift(random),
                          0.0125 * z + 0.0075 + shift(random))});
  }
  Lab world = make_world(testing_world(), grains, {.friction = 0.5, .restitution = e});
  world.planes = {{},
                  {.point = Vec3::Zero(), .normal = Vec3::UnitX()},
                  {.point = Vec3::Zero(), .normal = Vec3::UnitY()},
                  {.point = Vec3(0.1025, 0, 0), .normal = -Vec3::UnitX()},
                  {.point = Vec3(0, 0.1025, 0), .normal = -Vec3::UnitY()}};
  world.uniform_gravity = Vec3(0, 0, -g);
  advance(world, 1e-3, 2500, as_they_are);
  double sum = 0;
  for (const Sphere& grain : spheres_of(world)) sum += grain.velocity.squaredNorm();
  return std::sqrt(sum / 400);
}

TEST(FreshImpact, what_gravity_keeps_from_bouncing_is_told_where_it_does_not_press) {
  const double fall = 9.81, h = 0.01, e = 0.9, m = 2;
  // Two fall side by side, slower against each other than 2 h g, or faster; one lies still.
  for (const double closing : {0.18, 0.22}) {
    Lab world = make_world(testing_world(),
                           {{.radius = 1, .mass = m, .velocity = {closing, 0, 0}},
                            {.radius = 1, .mass = m, .position = {2.001, 0, 0}},
                            {.radius = 1, .mass = m, .position = {50, 0, -99}}},
                           {.restitution = e});
    world.uniform_gravity = {0, 0, -fall};
    world.planes = {{.point = {0, 0, -100}, .normal = {0, 0, 1}}};
    const double withheld = nonsmooth_step(world, h, {.tolerance = 1e-9}, 1).withheld;
    const double kept = e * closing;
    EXPECT_NEAR(withheld, closing < 2 * h * fall ? m / 2 * kept * kept / 2 : 0, 1e-9 * m)
        << closing;
  }
}

TEST(FreshImpact, a_bed_of_lively_grains_settles_as_one_of_dull_grains_does) {
  const double dull = rms_speed_of_a_bed(0.3), lively = rms_speed_of_a_bed(0.9);
  RecordProperty("dull", std::to_string(dull));
  if (testing_world().rank == 0) std::printf("rms speeds %fall %fall m/s\n", dull, lively);
  EXPECT_LT(lively, 3 * dull + 1e-6);
}

}  // namespace
}  // namespace spall
