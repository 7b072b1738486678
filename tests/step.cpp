// The step against formulas: impacts, friction, gravity, cohesion.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "gravity/kick.hpp"
#include "output/diagnostics.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

const Plane floor_plane{.point = Vec3::Zero(), .normal = Vec3::UnitZ()};

// Impacts ------------------------------------------------------------------------------------

TEST(Impact, equal_spheres_head_on_part_as_restitution_says) {
  const double v = 3, h = 0.01;
  for (double e : {0.0, 0.3, 1.0})
    for (double gap : {0.0, 0.29 * v * h, 2.5 * v * h}) {
      Lab world =
          make_world(testing_world(), {{.velocity = {v, 0, 0}}, {.position = {2 + gap, 0, 0}}},
                     {.friction = 0.5, .restitution = e});
      advance(world, h, 5);
      const auto after = spheres_of(world);
      // One contact: the solver is exact to round-off; e = 0 closes the gap first, then sticks.
      EXPECT_NEAR(after[0].velocity.x(), v * (1 - e) / 2, 1e-12 * v) << "e " << e << " gap " << gap;
      EXPECT_NEAR(after[1].velocity.x(), v * (1 + e) / 2, 1e-12 * v) << "e " << e << " gap " << gap;
      EXPECT_NEAR(after[0].velocity.x() + after[1].velocity.x(), v, 1e-15 * v);
      EXPECT_EQ(after[0].spin.norm(), 0);
    }
}

/// A sphere that meets the floor at `theta` from the normal, one step later.
Sphere after_oblique_impact(double theta, double v, double radius, const ContactLaw& law) {
  const double h = 1e-3, height = radius + 0.4 * h * v * std::cos(theta);
  Lab world = make_world(alone(),
                         {{.radius = radius,
                           .mass = 2,
                           .position = {0, 0, height},
                           .velocity = {v * std::sin(theta), 0, -v * std::cos(theta)}}},
                         law);
  world.planes = {floor_plane};
  advance(world, h, 1);
  return spheres_of(world)[0];
}

TEST(Impact, oblique_on_a_plane_slips_or_sticks) {
  const double v = 5, r = 0.7;
  int slipped = 0, stuck = 0;
  for (double mu : {0.1, 0.3})
    for (double e : {0.3, 1.0})
      for (double theta : {0.2, 0.5, 0.8, 1.1, 1.4}) {
        const Sphere after = after_oblique_impact(theta, v, r, {.friction = mu, .restitution = e});
        const double slip = mu * (1 + e) / std::tan(theta);
        const bool slips = std::tan(theta) > 3.5 * mu * (1 + e);
        ++(slips ? slipped : stuck);
        const double e_t = slips ? 1 - slip : 5.0 / 7;
        const double spin =
            (slips ? 2.5 * mu * (1 + e) * v * std::cos(theta) : 5.0 / 7 * v * std::sin(theta)) / r;
        // The solver's tolerance, 1e-10, on one contact.
        EXPECT_NEAR(after.velocity.z(), e * v * std::cos(theta), 1e-9 * v) << mu << " " << theta;
        EXPECT_NEAR(after.velocity.x(), e_t * v * std::sin(theta), 1e-9 * v) << mu << " " << theta;
        EXPECT_NEAR(after.spin.y(), spin, 1e-9 * v / r) << mu << " " << theta;
      }
  EXPECT_GE(slipped, 5);
  EXPECT_GE(stuck, 5);
}

TEST(Impact, cradle_follows_the_simultaneous_law) {
  const int n = 7;
  const double v = 2, h = 0.01;
  for (double e : {0.0, 0.3, 1.0}) {
    std::vector<Sphere> balls(n);
    for (int k = 0; k < n; ++k) balls[k].position = {2.0 * k, 0, 0};
    balls[0].velocity = {v, 0, 0};
    Lab world = make_world(testing_world(), balls, {.restitution = e});
    advance(world, h, 1);
    const auto after = spheres_of(world);
    // A chain of n contacts multiplies the solver's 1e-10 by about n^2.
    EXPECT_NEAR(after[0].velocity.x(), v * ((1 + e) / n - e), 1e-8 * v);
    for (int k = 1; k < n; ++k)
      EXPECT_NEAR(after[k].velocity.x(), v * (1 + e) / n, 1e-8 * v) << "ball " << k;
  }
}

TEST(Impact, a_fast_sphere_is_never_missed_however_long_the_step) {
  const double v = 4000, r = 0.25;
  for (double along : {0.1, 0.7, 3.0, 10.0, 100.0}) {
    for (double start : {0.3, 1.85}) {  // of the way that it flies in a step
      const double h = along * r / v;
      std::vector<Sphere> spheres = {{.radius = r, .velocity = {v, 0, 0}}};
      const double first = r + 1 + std::max(start * v * h, 0.01 * r);
      for (int y = -2; y <= 2; ++y)
        for (int z = -2; z <= 2; ++z)
          spheres.push_back({.mass = 100, .position = {first, 2.0 * y, 2.0 * z}});
      spheres[0].position = {0, 0.1, -0.05};  // not head-on
      Lab world = make_world(testing_world(), spheres, {.friction = 0.3, .restitution = 0.3});
      const int steps = static_cast<int>(std::ceil(start)) + 2;
      advance(world, h, steps);
      const auto after = spheres_of(world);
      EXPECT_LT(after[0].velocity.x(), 0) << along << " " << start;
      double given = 0;
      for (int k = 1; k <= 25; ++k) {
        given += after[k].mass * after[k].velocity.x();
        // The 13th is struck; the others are passed, though they stand behind a tangent plane.
        if (k == 13) continue;
        EXPECT_LT(after[k].velocity.x(), after[13].velocity.x() / 2) << along << " " << start;
      }
      EXPECT_GT(given, v) << along << " " << start;
      EXPECT_LT(after[0].position.x(), first) << along << " " << start;
    }
  }
}

// Friction -----------------------------------------------------------------------------------

TEST(Friction, a_sliding_sphere_starts_to_roll) {
  const double v0 = 1, mu = 0.2, g = 9.8, r = 0.3;
  const double rolls_at = 2 * v0 / (7 * mu * g), h = rolls_at / 100.3;
  Lab world =
      make_world(testing_world(), {{.radius = r, .position = {0, 0, r}, .velocity = {v0, 0, 0}}},
                 {.friction = mu});
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -g};
  for (int k = 1; k <= 110; ++k) {
    advance(world, h, 1);
    const Sphere s = spheres_of(world)[0];
    const double t = (k - 0.5) * h;  // leapfrog: velocities belong to the middle between kicks
    if (t < rolls_at) {
      EXPECT_NEAR(s.velocity.x(), v0 - mu * g * t, 1e-9 * v0) << "step " << k;
      EXPECT_NEAR(s.spin.y(), 2.5 * mu * g * t / r, 1e-9 * v0 / r) << "step " << k;
    } else if (t > rolls_at + h) {
      EXPECT_NEAR(s.velocity.x(), 5 * v0 / 7, 1e-9 * v0) << "step " << k;
      EXPECT_NEAR(s.spin.y(), 5 * v0 / (7 * r), 1e-9 * v0 / r) << "step " << k;
    }
  }
}

TEST(Friction, a_sphere_on_an_incline_rolls_up_to_three_and_a_half_mu) {
  const double g = 9.8, h = 1e-3, r = 0.4;
  const int steps = 20;
  for (double mu : {0.0, 0.1, 0.3})
    for (double slope : {0.2, 0.34, 0.36, 1.0}) {
      Lab world = make_world(alone(), {{.radius = r, .position = {0, 0, r}}}, {.friction = mu});
      const double theta = std::atan(slope);
      world.planes = {floor_plane};
      world.uniform_gravity = {g * std::sin(theta), 0, -g * std::cos(theta)};
      advance(world, h, steps);
      const Sphere s = spheres_of(world)[0];
      const bool rolls = slope <= 3.5 * mu;
      const double a =
          rolls ? 5.0 / 7 * g * std::sin(theta) : g * (std::sin(theta) - mu * std::cos(theta));
      const double turn = (rolls ? a : 2.5 * mu * g * std::cos(theta)) / r;
      const double t = (steps - 0.5) * h;
      EXPECT_NEAR(s.velocity.x(), a * t, 1e-8 * g * t) << mu << " " << slope;
      EXPECT_NEAR(s.spin.y(), turn * t, 1e-8 * g * t / r) << mu << " " << slope;
      EXPECT_NEAR(s.position.z(), r, 1e-9 * r);
    }
}

// Gravity ------------------------------------------------------------------------------------

TEST(Gravity, each_contact_of_a_column_carries_what_is_above_it) {
  const int n = 100;
  const double r = 0.5, m = 3, g = 9.8, h = 1e-3;
  std::vector<Sphere> column(n);
  for (int k = 0; k < n; ++k)
    column[k] = {.radius = r, .mass = m, .position = {0, 0, r + 2 * r * k}};
  Lab world = make_world(alone(), column, {.friction = 0.5});
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -g};
  advance(world, h, 3);  // the first kick is of half a step
  const Pairs& pairs = world.rigid.neighbours.pairs;
  std::int64_t seen = 0;
  for (const CarriedImpulse& last : pairs.carried) {
    const Index i = pairs.i[last.pair], j = pairs.j[last.pair];
    if (i >= world.bodies.owned) continue;
    const BodyId upper = j == ground ? world.bodies.id[i] : world.bodies.id[j];
    const double carried = static_cast<double>(n - upper) * m * g * h;
    EXPECT_NEAR(last.impulse.norm(), carried, 1e-6 * carried) << "contact below body " << upper;
    ++seen;
  }
  EXPECT_EQ(world.comm.sum(seen), n);
}

TEST(Gravity, two_bodies_fall_together_and_bounce_as_kepler_and_restitution_say) {
  const double m = 1e6, r = 1, x0 = 4, e = 0.5;
  const GravitySettings gravity{.method = GravityMethod::direct};
  const double mu = 2 * m * gravity.constant, ratio = 2 * r / x0;
  const double falls = std::sqrt(x0 * x0 * x0 / (2 * mu)) *
                       (std::acos(std::sqrt(ratio)) + std::sqrt(ratio * (1 - ratio)));
  const double impact = std::sqrt(2 * mu * (1 / (2 * r) - 1 / x0));  // relative speed
  for (double h : {falls / 200.4, falls / 400.4}) {
    Lab world = make_world(
        alone(),
        {{.mass = m, .position = {-x0 / 2, 0, 0}}, {.mass = m, .position = {x0 / 2, 0, 0}}},
        {.friction = 0.5, .restitution = e});
    world.gravity = gravity;
    double met = 0, speed = 0, rebound = 0;
    evaluate_field(world);
    const double before = world.kick.potential;
    for (int k = 1; met == 0 && k < 1000; ++k) {
      advance(world, h, 1);
      const auto s = spheres_of(world);
      const double closing = s[0].velocity.x() - s[1].velocity.x();
      if (closing < 0) {
        met = k * h;
        rebound = -closing;
      } else {
        speed = closing;
      }
    }
    // Contact is met at an end of a step, speeds belong to the middle: off by a step and a half.
    const double a = mu / (4 * r * r);
    EXPECT_NEAR(met, falls, 1.5 * h);
    EXPECT_NEAR(speed, impact, 2 * h * a);
    EXPECT_NEAR(rebound, e * impact, 2 * h * a);
    evaluate_field(world);
    const Diagnostics sums = diagnose(world);
    const double lost = m / 4 * impact * impact * (1 - e * e);
    EXPECT_NEAR(sums.dissipated, lost, m / 2 * impact * 2 * h * a);
    EXPECT_NEAR(sums.kinetic + world.kick.potential + sums.dissipated, before,
                m / 2 * impact * 3 * h * a);
    EXPECT_LE(sums.momentum.norm(), 1e-14 * sums.momentum_scale);
  }
}

// Cohesion -----------------------------------------------------------------------------------

/// Pulls a cohesive pair apart with the force `pull` on each; returns the gap and the speed at
/// which it opens.
std::pair<double, double> pulled_apart(double pull, double h, int steps, double range) {
  const double m = 2;
  Lab world = make_world(alone(), {{.mass = m}, {.mass = m, .position = {2, 0, 0}}},
                         {.friction = 0.5, .cohesion = 10, .cohesion_range = range});
  for (int k = 0; k < steps; ++k) {
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.velocity[b].x() += (world.bodies.id[b] == 0 ? -1 : 1) * pull * h / m;
    advance(world, h, 1);
  }
  const auto s = spheres_of(world);
  return {s[1].position.x() - s[0].position.x() - 2, s[1].velocity.x() - s[0].velocity.x()};
}

TEST(Cohesion, a_bond_holds_below_its_force_and_parts_above) {
  const double range = 0.01;
  for (double h : {1e-4, 1e-2, 0.03}) {  // a pull that leaves the range in one step is an impact
    const auto [gap, speed] = pulled_apart(9.99, h, 500, range);
    EXPECT_NEAR(gap, 0, 1e-6 * range) << "h " << h;
    EXPECT_NEAR(speed, 0, 1e-6 * range / h) << "h " << h;
    EXPECT_GT(pulled_apart(10.01, h, 2000, range).first, h < 1e-3 ? 1e-9 : range) << "h " << h;
  }
}

TEST(Cohesion, breaking_a_bond_takes_force_times_range) {
  // (F - c) range = 1/2 (m/2) u^2 where the pair leaves the range; then F alone drives it.
  const double range = 0.01, pull = 15, c = 10, reduced = 1;
  const double leaves = std::sqrt(2 * (pull - c) * range / reduced);
  const double t = leaves * reduced / (pull - c);
  double before = 1;
  for (int n : {50, 100, 200}) {
    const double h = t / n;
    const auto [gap, speed] = pulled_apart(pull, h, n, range);
    const double error = std::abs(speed - leaves) / leaves;
    EXPECT_NEAR(gap, range, 3 * range / n);
    EXPECT_LT(error, 3.0 / n);
    EXPECT_LE(error, before);
    before = std::max(error, 1e-12);
  }
}

TEST(Cohesion, of_a_wall_acts_over_its_whole_range) {
  // As that of a fixed body does: a body reaches for it alone.
  const double range = 0.3, force = 1000, m = 5, h = 1e-3;
  for (const double gap : {0.1, 0.16, 0.2, 0.29, 0.31}) {
    Lab world = make_world(alone(), {{.radius = 0.5, .mass = m, .position = {0, 0, 0.5 + gap}}},
                           {.cohesion = force, .cohesion_range = range});
    world.planes = {floor_plane};
    EXPECT_NEAR(world.rigid.energy(world), -force * std::max(range - gap, 0.0), 1e-12 * force);
    advance(world, h, 1);
    EXPECT_NEAR(spheres_of(world)[0].velocity.z(), gap < range ? -h * force / m : 0, 1e-12) << gap;
  }
}

TEST(Cohesion, what_flies_past_within_its_range_is_attracted_and_not_hit) {
  const double speed = 1000, h = 1e-3, range = 0.5, gap = 0.25;
  for (const double cohesion : {0.0, 1.0}) {
    Lab world = make_world(
        testing_world(),
        {{.radius = 1, .mass = 30},
         {.radius = 0.25, .mass = 1, .position = {-2.3, 1.25 + gap, 0}, .velocity = {speed, 0, 0}}},
        {.restitution = 1, .cohesion = cohesion, .cohesion_range = range});
    for (int step = 0; step < 5; ++step) nonsmooth_step(world, h, {.tolerance = 1e-9}, 1);
    for (const Sphere& s : spheres_of(world)) {
      const Vec3 before = s.radius < 1 ? Vec3(speed, 0, 0) : Vec3::Zero();
      EXPECT_LE((s.velocity - before).norm() * s.mass, cohesion * 5 * h + 1e-9) << cohesion;
    }
  }
}

TEST(Cohesion, as_an_impulse_takes_its_bound_in_every_step) {
  const double m = 2, reduced = 1, bound = 3, h = 0.01;
  for (double speed : {2.9, 3.1, 7.0}) {
    Lab world =
        make_world(alone(),
                   {{.mass = m, .velocity = {-speed / 2, 0, 0}},
                    {.mass = m, .position = {2, 0, 0}, .velocity = {speed / 2, 0, 0}}},
                   {.cohesion = bound, .cohesion_range = 1, .cohesion_law = CohesionLaw::impulse});
    double expected = speed, gap = 0;  // it may close a gap, but no further
    for (int step = 1; step <= 3; ++step) {
      advance(world, h, 1);
      expected = std::max(expected - bound / reduced, -gap / h);
      gap += h * expected;
      const auto s = spheres_of(world);
      EXPECT_NEAR(s[1].velocity.x() - s[0].velocity.x(), expected, 1e-9 * speed) << step;
    }
  }
}

TEST(Cohesion, as_an_impulse_without_a_range_holds_what_touches) {
  Lab world = make_world(alone(),
                         {{.mass = 2, .velocity = {-1, 0, 0}},
                          {.mass = 2, .position = {2, 0, 0}, .velocity = {1, 0, 0}}},
                         {.cohesion = 3, .cohesion_law = CohesionLaw::impulse});
  advance(world, 0.01, 1);
  for (const Sphere& s : spheres_of(world)) EXPECT_NEAR(s.velocity.x(), 0, 1e-12);
}

}  // namespace
}  // namespace spall
