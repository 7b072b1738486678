// What contact codes break on: extreme masses, long chains, hyperstatic piles, rest, long steps.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include "contact_problems.hpp"
#include "output/diagnostics.hpp"
#include "run/simulation.hpp"
#include "spall/error.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

/// Where many steps of few bodies would mean many messages, every rank computes them by itself.
// Extreme numbers ----------------------------------------------------------------------------

/// No contact slides in these, so that the convex problem's solution is Coulomb's.
SolverSettings convex(double tolerance) {
  return {.friction = FrictionModel::convex,
          .tolerance = tolerance,
          .max_iterations = 200000,
          .prox = 0};
}

TEST(HardCase, a_body_carries_one_that_is_up_to_a_million_times_heavier_or_lighter) {
  // Both fall onto the ground at speed 1. The ratio is the condition of the problem.
  for (double above_over_below : {1e-9, 1e-6, 1e-3, 1e3, 1e6}) {
    WholeProblem whole;
    whole.inverse_mass = {1, 1 / above_over_below};
    whole.add(0, ground, -Vec3::UnitZ(), Vec3(0, 0, 1), 0.5);
    whole.add(0, 1, Vec3::UnitZ(), Vec3::Zero(), 0.5);
    const Solved solved = solve_whole(whole, convex(1e-9));
    const double carried = 1 + above_over_below;
    EXPECT_TRUE(solved.report.converged) << above_over_below;
    EXPECT_NEAR(solved.impulse[0].z(), -carried, 1e-6 * carried) << above_over_below;
    EXPECT_NEAR(solved.impulse[1].z(), above_over_below, 1e-6 * carried) << above_over_below;
  }
}

TEST(HardCase, a_column_of_a_thousand_carries_its_weight) {
  constexpr int n = 1000;
  WholeProblem whole;
  whole.inverse_mass.assign(n, 1);
  whole.add(0, ground, -Vec3::UnitZ(), Vec3(0, 0, 1), 0.5);
  for (Index b = 1; b < n; ++b) whole.add(b - 1, b, Vec3::UnitZ(), Vec3::Zero(), 0.5);
  std::vector<int> owner(n);
  for (int b = 0; b < n; ++b) owner[b] = b * testing_world().size / n;
  const Solved solved = solve_whole(whole, convex(1e-7), owner);
  EXPECT_TRUE(solved.report.converged) << solved.report.iterations;
  EXPECT_NEAR(solved.impulse[0].z(), -n, 1e-4 * n);
  for (Index b = 1; b < n; ++b) ASSERT_NEAR(solved.impulse[b].z(), n - b, 1e-4 * n);
}

TEST(HardCase, a_chain_of_bonds_holds_just_below_its_strength_and_parts_at_both_ends_above) {
  constexpr int n = 100;
  const double c = 2;  // the cohesive impulse of a step
  for (double pull : {0.999, 1.001}) {
    WholeProblem whole;
    whole.inverse_mass.assign(n, 1);
    for (Index b = 1; b < n; ++b) {
      const double ends = (b == 1) + (b == n - 1);
      whole.add(b - 1, b, Vec3::UnitX(), Vec3(ends * pull * c, 0, 0), 0.5, c);
    }
    const Solved solved =
        solve_whole(whole, {.tolerance = 1e-9, .max_iterations = 50000, .prox = 0});
    EXPECT_TRUE(solved.report.converged) << pull;
    // What lies between the ends stays at rest at its strength; the ends fly off with the rest.
    for (const Vec3& p : solved.impulse) EXPECT_NEAR(p.x(), -std::min(pull, 1.0) * c, 1e-6 * c);
    const double parting = std::max(pull - 1, 0.0) * c;
    EXPECT_NEAR(solved.linear[0].x() - pull * c, -parting, 1e-6 * c) << pull;
  }
}

TEST(HardCase, numbers_that_are_none_are_refused_whatever_they_are) {
  const WholeProblem good = shaken_block(2, 0.4, 0.1);
  for (double bad : {std::nan(""), infinity, -1.0})
    for (int field = 0; field < 6; ++field) {
      if (bad == -1 && field >= 3) continue;  // these may be negative
      WholeProblem whole = good;
      std::vector<Vec3> start(whole.contacts(), Vec3::Zero());
      double* const numbers[] = {&whole.inverse_mass[3],     &whole.friction[3],
                                 &whole.cohesive_impulse[3], &whole.kappa[3],
                                 &whole.normal[3].y(),       &start[3].z()};
      *numbers[field] = bad;
      EXPECT_THROW(solve_whole(whole, {}, {}, start), Error) << bad << " in field " << field;
    }
}

// Rest ---------------------------------------------------------------------------------------

/// Spheres of radius 1 and of a rock's mass at random in a cube, gaps between them.
std::vector<Sphere> cloud(int count, double edge, double speed) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-edge / 2, edge / 2), motion(-speed, speed);
  std::vector<Sphere> spheres;
  while (static_cast<int>(spheres.size()) < count) {
    const Vec3 x(place(random), place(random), place(random));
    if (std::any_of(spheres.begin(), spheres.end(),
                    [&](const Sphere& other) { return (other.position - x).norm() < 2.02; }))
      continue;
    const Vec3 v(motion(random), motion(random), motion(random));
    spheres.push_back({.mass = 1600 * 4 * pi / 3, .position = x, .velocity = v});
  }
  return spheres;
}

/// Kinetic energy of a sphere on three that touch each other on the floor, over that of free fall.
double motion_of_vault(double mu) {
  const double g = 9.8, h = 1e-3;
  const int steps = 50;
  std::vector<Sphere> spheres;
  for (int k = 0; k < 3; ++k) {
    const double angle = 2 * pi * k / 3, away = 2 / std::sqrt(3.0);
    spheres.push_back({.position = {away * std::cos(angle), away * std::sin(angle), 1}});
  }
  spheres.push_back({.position = {0, 0, 1 + std::sqrt(8.0 / 3)}});
  Lab world = make_world(alone(), spheres, {.friction = mu});
  world.planes = {{.point = Vec3::Zero(), .normal = Vec3::UnitZ()}};
  world.uniform_gravity = {0, 0, -g};
  advance(world, h, steps, {.tolerance = 1e-8, .max_iterations = 20000, .prox = 0});
  return diagnose(world).kinetic / (4 * std::pow(g * h * steps, 2) / 2);
}

TEST(HardCase, a_vault_stands_on_friction_alone_down_to_its_exact_coefficient) {
  // The top sphere rests on lines at phi from the vertical, sin phi = 1/sqrt 3. Nothing may turn,
  // so a lower sphere's friction T is alike at its top and its foot: T = N sin phi - T cos phi.
  const double needed = std::tan(std::asin(1 / std::sqrt(3.0)) / 2);
  EXPECT_LT(motion_of_vault(1.01 * needed), 1e-15);
  EXPECT_GT(motion_of_vault(0.99 * needed), 1e-7);  // it gives way: 1 % of the way to free fall
}

double radius_of_gyration(const Lab& world) {
  const Diagnostics sums = diagnose(world);
  double square = 0;
  for (Index b = 0; b < world.bodies.owned; ++b)
    square += world.bodies.mass[b] * (world.bodies.position[b] - sums.centre).squaredNorm();
  return std::sqrt(world.comm.sum(square) / sums.mass);
}

TEST(HardCase, a_ball_in_an_edge_without_a_solution_takes_no_contact_from_others) {
  Simulation simulation(alone(), Scene::from_text(R"(
[materials.rock]
density = 2500
[contact]
restitution = 0.5
friction = 10
[[boxes]]
center = [-50, -50, -50]
size = [101, 101, 100]
[[groups]]
name = "ball"
material = "rock"
volume = {radius = 0.06, center = [0.439, 0.439, -49]}
velocity = [0.257, 1.004, -2.166]
[[groups]]
name = "bystander"
material = "rock"
volume = {radius = 0.06, center = [0, -20, -99.93]}
velocity = [0, 0, -2.1]
[[phases]]
name = "only"
step = 0.005
duration = 0.05
)"));
  while (!simulation.over()) simulation.step();
  const Bodies& bodies = simulation.bodies();
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.id[b] == 1) {
      EXPECT_NEAR(bodies.velocity[b].z(), 1.05, 1e-6);
      continue;
    }
    EXPECT_LE(bodies.position[b].head<2>().maxCoeff(), 0.44 * (1 + 1e-4));
    EXPECT_LE(bodies.velocity[b].head<2>().maxCoeff(), 1e-6);
  }
}

TEST(HardCase, a_pile_at_rest_stays_at_rest_and_does_not_creep) {
  // Spheres fall together under their own gravity and settle; then 10,000 steps at rest, with the
  // solver as a case has it by default.
  Lab world = make_world(alone(), cloud(64, 12, 0), {.friction = 0.5, .restitution = 0.3});
  world.gravity = {.method = GravityMethod::direct};
  const auto step = [&] { nonsmooth_step(world, 20, SolverSettings{}, 1); };
  step();
  const double start = world.kick.potential;
  for (int k = 1; k < 3000; ++k) step();
  const double released = start - world.kick.potential, size = radius_of_gyration(world);
  EXPECT_GT(released, 0.4 * std::abs(start));
  for (int k = 0; k < 10000; ++k) {
    step();
    if (k % 50 != 0) continue;
    ASSERT_LT(diagnose(world).kinetic, 1e-10 * released) << k;
    ASSERT_NEAR(radius_of_gyration(world), size, 1e-6 * size) << k;
  }
}

// Collisions ---------------------------------------------------------------------------------

TEST(HardCase, friction_and_restitution_add_no_energy) {
  for (double mu : {0.0, 0.5, 2.0})
    for (double e : {0.0, 0.3, 0.5, 0.8, 1.0}) {
      // Newton's restitution lets friction in simultaneous impacts do work where nothing is lost
      // along the normals (Kane & Levinson 1985): a thousandth of it here.
      const double most = mu > 0 && e == 1 ? 2e-3 : 1e-7;
      auto spheres = cloud(48, 10, 1);
      for (Sphere& s : spheres) s.velocity -= 0.5 * s.position;  // towards each other
      Lab world = make_world(alone(), spheres, {.friction = mu, .restitution = e});
      const Diagnostics start = diagnose(world);
      double kinetic = start.kinetic;
      for (int k = 0; k < 60; ++k) {
        advance(world, 0.02, 1, {.tolerance = 1e-8, .max_iterations = 5000, .prox = 0});
        const double now = diagnose(world).kinetic;
        EXPECT_LE(now, kinetic * (1 + most)) << "mu " << mu << " e " << e << " step " << k;
        kinetic = now;
      }
      const Diagnostics end = diagnose(world);
      if (mu > 0 || e < 1) {
        EXPECT_LT(kinetic, 0.95 * start.kinetic) << "mu " << mu << " e " << e;
      }
      EXPECT_LT((end.momentum - start.momentum).norm(), 1e-12 * start.momentum_scale);
      EXPECT_LT((end.angular_momentum - start.angular_momentum).norm(),
                1e-12 * start.angular_momentum_scale);
    }
}

TEST(HardCase, contacts_that_all_open_at_once_carry_nothing) {
  // A lattice that was pressed together a step ago flies apart.
  const Vec3 centre(3, 3, 3);
  std::vector<Sphere> lattice;
  for (int k = 0; k < 64; ++k)
    lattice.push_back({.position = 2.0 * Vec3(k % 4, k / 4 % 4, k / 16)});
  for (Sphere& s : lattice) s.velocity = centre - s.position;
  Lab world = make_world(testing_world(), lattice, {.friction = 0.5});
  advance(world, 1e-3, 1);
  for (Index b = 0; b < world.bodies.owned; ++b) {
    world.bodies.velocity[b] = 0.1 * (world.bodies.position[b] - centre);
    world.bodies.angular_velocity[b].setZero();
  }
  const double kinetic = diagnose(world).kinetic;
  const StepReport report = nonsmooth_step(world, 1e-3, SolverSettings{}, 1);
  EXPECT_GE(world.comm.sum(report.contacts), 3 * 3 * 4 * 4);
  EXPECT_EQ(report.solver.iterations, 0);
  EXPECT_EQ(diagnose(world).kinetic, kinetic);
}

TEST(HardCase, one_body_and_bodies_without_contacts_move_freely) {
  for (int count : {1, 2}) {
    std::vector<Sphere> spheres;
    for (int k = 0; k < count; ++k)
      spheres.push_back({.position = {100.0 * k, 0, 0}, .velocity = {0, 3, k - 0.5}});
    Lab world = make_world(testing_world(), spheres, {.friction = 0.5, .restitution = 0.3});
    advance(world, 0.25, 8);
    const auto after = spheres_of(world);
    for (int k = 0; k < count; ++k) {
      EXPECT_EQ(after[k].velocity, spheres[k].velocity);
      EXPECT_EQ(after[k].position, Vec3(spheres[k].position + 2 * spheres[k].velocity));
    }
  }
}

TEST(HardCase, a_hypervelocity_projectile_misses_no_contact_at_any_step) {
  // A sphere onto the middle of a plate of smaller ones. However far it flies in a step, the
  // column of spheres in its way stays ahead of it, and it ends inside none.
  const double r = 1, big = 4;
  for (double v : {4000.0, 6700.0})
    for (double along : {0.1, 1.0, 10.0, 100.0}) {  // radii that it flies in a step
      const double h = along * r / v, face = big + r + 0.3 * along * r;
      std::vector<Sphere> spheres = {
          {.radius = big, .mass = big * big * big, .velocity = {0, 0, v}}};
      for (int z = 0; z < 3; ++z)
        for (int y = -3; y <= 3; ++y)
          for (int x = -3; x <= 3; ++x)
            spheres.push_back({.radius = r, .position = {2 * r * x, 2 * r * y, face + 2 * r * z}});
      Lab world = make_world(testing_world(), spheres, {.friction = 0.3});
      const Diagnostics before = diagnose(world);
      double kinetic = before.kinetic;
      for (int k = 0; k < (along < 1 ? 20 : 4); ++k) {
        advance(world, h, 1, {.tolerance = 1e-6, .max_iterations = 5000, .prox = 0});
        const double now = diagnose(world).kinetic;
        EXPECT_LE(now, kinetic * (1 + 1e-5)) << v << " " << along << " step " << k;
        kinetic = now;
      }
      const Diagnostics after = diagnose(world);
      EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum_scale);
      const auto end = spheres_of(world);
      EXPECT_LT(end[0].velocity.z(), 0.9 * v) << v << " " << along;
      double deepest = 0;
      for (std::size_t k = 1; k < end.size(); ++k) {
        if (spheres[k].position.head<2>().isZero(0)) {
          EXPECT_GT(end[k].position.z(), end[0].position.z()) << v << " " << along;
        }
        deepest = std::max(deepest, big + r - (end[k].position - end[0].position).norm());
      }
      EXPECT_LT(deepest, 1e-2 * r) << v << " " << along;
    }
}

}  // namespace
}  // namespace spall
