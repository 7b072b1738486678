// Gravity over long times, through the step: orbits, a collapse, bodies of very different size.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <numbers>

#include "gravity/kick.hpp"
#include "output/diagnostics.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

using std::numbers::pi;

/// A few bodies for long: one rank does it.
Lab small_world(const std::vector<Sphere>& spheres) {
  Lab world = make_world(alone(), spheres, {});
  world.gravity = {.method = GravityMethod::direct, .constant = 1};
  return world;
}

/// Kinetic and potential energy of the bodies as they stand; velocities lag by half a step.
double energy(const std::vector<Sphere>& s) {
  double sum = 0;
  for (std::size_t i = 0; i < s.size(); ++i) {
    sum += s[i].mass * s[i].velocity.squaredNorm() / 2;
    for (std::size_t j = 0; j < i; ++j)
      sum -= s[i].mass * s[j].mass / (s[i].position - s[j].position).norm();
  }
  return sum;
}

Vec3 angular_momentum(const std::vector<Sphere>& s) {
  Vec3 sum = Vec3::Zero();
  for (const Sphere& b : s) sum += b.mass * b.position.cross(b.velocity);
  return sum;
}

TEST(Orbits, an_ellipse_keeps_its_shape_for_a_thousand_periods) {
  if (testing_world().size > 1) return;
  const double a = 1, e = 0.5, m1 = 0.7, m2 = 0.3, r = a * (1 + e);
  const double v = std::sqrt((1 - e) / (1 + e) / a), h = 2 * pi / 256;
  Lab world = small_world(
      {{.radius = 1e-3, .mass = m1, .position = {-m2 * r, 0, 0}, .velocity = {0, -m2 * v, 0}},
       {.radius = 1e-3, .mass = m2, .position = {m1 * r, 0, 0}, .velocity = {0, m1 * v, 0}}});
  double least = infinity, most = 0, momentum = 0;
  const Vec3 turning = angular_momentum(spheres_of(world));
  double turned = 0;
  for (int k = 0; k < 256 * 1000; ++k) {
    nonsmooth_step(world, h, {}, 1);
    const auto &x = world.bodies.position, &u = world.bodies.velocity;
    const auto& m = world.bodies.mass;  // rows change places
    const double apart = (x[1] - x[0]).norm();
    least = std::min(least, apart);
    most = std::max(most, apart);
    momentum = std::max(momentum, (m[0] * u[0] + m[1] * u[1]).norm());
    const Vec3 l = m[0] * x[0].cross(u[0]) + m[1] * x[1].cross(u[1]);
    turned = std::max(turned, (l - turning).norm());
  }
  // Leapfrog's error is of second order in the step and does not grow.
  EXPECT_NEAR(least, a * (1 - e), 5e-3);
  EXPECT_NEAR(most, a * (1 + e), 5e-3);
  EXPECT_LT(momentum, 1e-12 * m1 * v);
  EXPECT_LT(turned, 1e-10 * turning.norm());
}

TEST(Orbits, three_bodies_stay_on_their_figure_of_eight_for_a_thousand_periods) {
  if (testing_world().size > 1) return;
  // Chenciner & Montgomery 2000, initial values of Simo.
  const Vec3 x(0.97000436, -0.24308753, 0), v(-0.93240737, -0.86473146, 0);
  const double period = 6.32591398;
  const std::vector<Sphere> start = {{.radius = 1e-3, .position = x, .velocity = -v / 2},
                                     {.radius = 1e-3, .position = -x, .velocity = -v / 2},
                                     {.radius = 1e-3, .velocity = v}};
  Lab world = small_world(start);
  const double before = energy(start);
  double widest = 0, highest = 0, drift = 0, turned = 0;
  for (int k = 0; k < 400 * 1000; ++k) {
    nonsmooth_step(world, period / 400, {}, 1);
    Vec3 sum = Vec3::Zero(), l = Vec3::Zero();
    for (int b = 0; b < 3; ++b) {
      const Vec3& p = world.bodies.position[b];
      widest = std::max(widest, std::abs(p.x()));
      highest = std::max(highest, std::abs(p.y()));
      sum += world.bodies.velocity[b];
      l += p.cross(world.bodies.velocity[b]);
    }
    drift = std::max(drift, sum.norm());
    turned = std::max(turned, l.norm());
  }
  EXPECT_NEAR(widest, 1.0805, 0.02);
  EXPECT_NEAR(highest, 0.3478, 0.03);
  EXPECT_LT(drift, 1e-11);
  EXPECT_LT(turned, 1e-10);
  EXPECT_NEAR(energy(spheres_of(world)), before, 2e-2 * std::abs(before));
}

TEST(Orbits, a_cold_sphere_collapses_in_its_free_fall_time) {
  std::vector<Sphere> spheres;
  const int n = 9;
  for (int x = -n; x <= n; ++x)
    for (int y = -n; y <= n; ++y)
      for (int z = -n; z <= n; ++z)
        if ((x + y + z) % 2 == 0 && x * x + y * y + z * z <= n * n)
          spheres.push_back({.radius = 1e-3, .position = Vec3(x, y, z)});
  double squares = 0;
  for (const Sphere& s : spheres) squares += s.position.squaredNorm();
  const double count = static_cast<double>(spheres.size());
  const double radius = std::sqrt(5 / 3.0 * squares / count);  // of a homogeneous sphere
  const double density = count / (4 * pi / 3 * radius * radius * radius);
  const double free_fall = std::sqrt(3 * pi / (32 * density)), h = free_fall / 150;
  for (const GravityMethod method : {GravityMethod::direct, GravityMethod::tree}) {
    Lab world = make_world(testing_world(), spheres, {});
    world.gravity = {.method = method, .constant = 1};
    const auto size = [&] {
      double sum = 0;
      for (Index b = 0; b < world.bodies.owned; ++b) sum += world.bodies.position[b].squaredNorm();
      return std::sqrt(world.comm.sum(sum));
    };
    // r = r0 cos^2 q at t = t_ff (q + sin q cos q) 2 / pi: half the size at q = pi / 4.
    const double first = size();
    double before = first, now = first;
    int k = 0;
    for (; now > first / 2 && k < 150; ++k) {
      nonsmooth_step(world, h, {}, 1);
      before = now;
      now = size();
    }
    const double halved = (k - (first / 2 - now) / (before - now)) * h;
    EXPECT_NEAR(halved / (2 / pi * (pi / 4 + 0.5)), free_fall, 0.01 * free_fall);
  }
}

TEST(Orbits, a_pebble_bounces_on_a_body_a_million_times_larger) {
  const double large = 1e6, mass = 1e18, drop = 30, e = 0.5, h = 0.01;
  const double v = 20;
  Lab world = make_world(
      testing_world(),
      {{.radius = large, .mass = mass},
       {.radius = 1, .mass = 1, .position = {large + 1 + drop, 0, 0}, .velocity = {-v, 0, 0}},
       {.radius = 1, .mass = 1, .position = {0, large + 1 + drop, 0}},
       {.radius = 1, .mass = 1, .position = {0, 0, large + 1 + drop}}},
      {.friction = 0.5, .restitution = e});
  world.gravity = {.method = GravityMethod::direct, .constant = 1e-6};
  const double g = 1e-6 * mass / (large * large), fast = std::sqrt(v * v + 2 * g * drop);
  double rebound = 0;
  for (int k = 0; k < 400 && rebound <= 0; ++k) {
    nonsmooth_step(world, h, solved_exactly(), 1);
    rebound = spheres_of(world)[1].velocity.x();
  }
  EXPECT_NEAR(rebound, e * fast, 3 * h * g);
}

}  // namespace
}  // namespace spall
