// Steps of clouds of spheres: overlaps that part, other units, other numbers of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <random>

#include "output/diagnostics.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

/// `count` spheres of radius 1 at random, no two nearer than `nearest`, inside a cube.
std::vector<Sphere> cloud(int count, double edge, double nearest, double speed) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> place(-edge / 2, edge / 2), motion(-speed, speed);
  std::vector<Sphere> spheres;
  while (static_cast<int>(spheres.size()) < count) {
    const Vec3 x(place(random), place(random), place(random));
    const bool clear = std::none_of(spheres.begin(), spheres.end(), [&](const Sphere& other) {
      return (other.position - x).norm() < nearest;
    });
    if (!clear) continue;
    const Vec3 v(motion(random), motion(random), motion(random));
    const Vec3 spin(motion(random), motion(random), motion(random));
    spheres.push_back({.position = x, .velocity = v, .spin = spin});
  }
  return spheres;
}

double deepest_overlap(const std::vector<Sphere>& spheres) {
  double deepest = 0;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double apart = (spheres[i].position - spheres[j].position).norm();
      deepest = std::max(deepest, spheres[i].radius + spheres[j].radius - apart);
    }
  return deepest;
}

// Overlaps -----------------------------------------------------------------------------------

TEST(Overlap, bodies_at_rest_part_without_moving_on) {
  for (double h : {1e-4, 1.0}) {
    const auto spheres = cloud(60, 8.5, 1.8, 0);
    ASSERT_GT(deepest_overlap(spheres), 0.15);
    Lab world = make_world(testing_world(), spheres, {.friction = 0.5, .restitution = 0.3});
    advance(world, h, 25);
    const Diagnostics sums = diagnose(world);
    EXPECT_LT(deepest_overlap(spheres_of(world)), 1e-3) << "h " << h;
    EXPECT_EQ(sums.kinetic, 0) << "h " << h;
  }
}

TEST(Overlap, moving_bodies_keep_their_momenta_and_gain_no_energy) {
  for (double speed : {1e-3, 1.0}) {
    const double h = 0.01;
    auto spheres = cloud(60, 8.5, 1.8, speed);
    Lab world = make_world(testing_world(), spheres, {.friction = 0.5, .restitution = 0.3});
    const Diagnostics before = diagnose(world);
    double kinetic = before.kinetic;
    for (int k = 0; k < 25; ++k) {
      advance(world, h, 1);
      const Diagnostics now = diagnose(world);
      EXPECT_LE(now.kinetic, kinetic * (1 + 1e-12)) << "step " << k << " speed " << speed;
      kinetic = now.kinetic;
    }
    const Diagnostics after = diagnose(world);
    EXPECT_LE((after.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
    EXPECT_LE((after.angular_momentum - before.angular_momentum).norm(),
              1e-12 * before.angular_momentum_scale);
    EXPECT_LT(deepest_overlap(spheres_of(world)), 1e-3);
  }
}

// Invariance ---------------------------------------------------------------------------------

/// 32 spheres that fall together, in units of `length`, `mass` and `time`.
std::vector<Sphere> fallen(const Comm& comm, double length, double mass, double time, int steps,
                           const SolverSettings& solver) {
  auto spheres = cloud(32, 7.5, 2.02, 2e-3);
  for (Sphere& s : spheres) {
    s.radius *= length;
    s.mass = 1e4 * mass;
    s.position *= length;
    s.velocity *= length / time;
    s.spin /= time;
  }
  Lab world = make_world(comm, spheres,
                         {.friction = 0.5,
                          .restitution = 0.3,
                          .cohesion = 1e-3 * mass * length / (time * time),
                          .cohesion_range = 0.01 * length});
  world.gravity = {.method = GravityMethod::direct,
                   .constant = 6.67e-11 * length * length * length / (mass * time * time)};
  for (int k = 0; k < steps; ++k) nonsmooth_step(world, 8 * time, solver, 4);
  auto after = spheres_of(world);
  for (Sphere& s : after) {
    s.position /= length;
    s.velocity *= time / length;
    s.spin *= time;
  }
  return after;
}

void expect_same_bits(const std::vector<Sphere>& a, const std::vector<Sphere>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].position, b[k].position) << "body " << k;
    EXPECT_EQ(a[k].velocity, b[k].velocity) << "body " << k;
    EXPECT_EQ(a[k].spin, b[k].spin) << "body " << k;
  }
}

TEST(Invariance, units_that_differ_by_powers_of_two_give_the_same_bits) {
  const Comm comm = testing_world();
  const auto plain = fallen(comm, 1, 1, 1, 25, SolverSettings{});
  expect_same_bits(fallen(comm, 1024, 1, 0x1p-12, 25, SolverSettings{}), plain);
  expect_same_bits(fallen(comm, 0x1p-7, 0x1p21, 0x1p9, 25, SolverSettings{}), plain);
}

TEST(Invariance, ranks_change_nothing_beyond_the_solver_and_a_second_run_nothing_at_all) {
  const Comm comm = testing_world();
  const auto spheres = cloud(96, 11, 2.02, 1e-2);
  const double h = 1;
  const auto run = [&](const Comm& ranks) {
    Lab world = make_world(ranks, spheres, {.friction = 0.5, .restitution = 0.3});
    world.gravity = {.method = GravityMethod::direct, .constant = 1e-4};
    const Diagnostics before = diagnose(world);
    double p = 0, l = 0, p_scale = 0, l_scale = 0;
    for (int k = 0; k < 60; ++k) {
      nonsmooth_step(world, h, {.tolerance = 1e-10, .max_iterations = 2000, .prox = 0}, 8);
      const Diagnostics now = diagnose(world);
      p = std::max(p, (now.momentum - before.momentum).norm());
      l = std::max(l, (now.angular_momentum - before.angular_momentum).norm());
      p_scale = std::max(p_scale, now.momentum_scale);
      l_scale = std::max(l_scale, now.angular_momentum_scale);
    }
    EXPECT_LE(p, 1e-12 * p_scale);
    EXPECT_LE(l, 1e-12 * l_scale);
    EXPECT_GT(diagnose(world).dissipated, 0);
    return spheres_of(world);
  };
  const auto many = run(comm), one = run(Comm(MPI_COMM_SELF));
  expect_same_bits(run(comm), many);
  double worst = 0;
  for (std::size_t k = 0; k < one.size(); ++k)
    worst = std::max(worst, (one[k].position - many[k].position).norm());
  // Sixty steps of collisions spread the solver's 1e-10.
  EXPECT_LE(worst, 1e-5);
}

}  // namespace
}  // namespace spall
