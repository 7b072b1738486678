// Where the code decides one way or the other: each threshold from both of its sides.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "analysis/clumps.hpp"
#include "analysis/deflection.hpp"
#include "contact_problems.hpp"
#include "pair_potentials.hpp"
#include "potential/constitutive.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

const Plane floor_plane{.point = Vec3::Zero(), .normal = Vec3::UnitZ()};

/// Speed up (m/s) of a sphere of 2 kg that lay on the floor and came down at `speed`, a step later.
double rebound(double speed, double h, const ContactLaw& law, double g) {
  Lab world = make_world(
      alone(), {{.radius = 0.5, .mass = 2, .position = {0, 0, 0.5}, .velocity = {0, 0, -speed}}},
      law);
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -g};
  advance(world, h, 1);
  return spheres_of(world)[0].velocity.z();
}

TEST(Threshold, sphere_that_gravity_alone_could_drive_rests_and_a_faster_one_rebounds) {
  // Between kicks a body at rest gains g h, and up to twice that where an overlap was opened.
  const double g = 9.8, e = 0.5;
  for (double h : {1e-3, 4e-3}) {
    const double driven = 2 * g * h, first_kick = g * h / 2;
    EXPECT_NEAR(rebound(0.99 * driven - first_kick, h, {.restitution = e}, g), 0, 1e-9 * driven);
    // The law holds at the floor, half a kick before the middle of the interval on either side.
    EXPECT_NEAR(rebound(1.01 * driven - first_kick, h, {.restitution = e}, g),
                e * (1.01 * driven - g * h / 2) - g * h / 2, 1e-9 * driven);
  }
}

TEST(Threshold, sphere_that_cohesion_alone_could_drive_rests_and_a_faster_one_rebounds) {
  const double m = 2, c = 30, e = 0.5;
  const ContactLaw law{.restitution = e, .cohesion = c, .cohesion_range = 0.1};
  for (double h : {1e-3, 4e-3}) {
    const double driven = 2 * c * h / m;
    EXPECT_NEAR(rebound(0.99 * driven, h, law, 0), 0, 1e-9 * driven);
    EXPECT_NEAR(rebound(1.01 * driven, h, law, 0), e * 1.01 * driven, 1e-9 * driven);
  }
}

TEST(Threshold, sphere_rebounds_in_the_step_in_which_it_would_meet_the_floor_and_not_before) {
  const double v = 3, h = 1e-3, e = 0.5;
  for (const auto& [gap, after] : {std::pair{0.999 * v * h, e * v}, std::pair{1.001 * v * h, -v}}) {
    Lab world = make_world(alone(),
                           {{.radius = 0.5, .position = {0, 0, 0.5 + gap}, .velocity = {0, 0, -v}}},
                           {.restitution = e});
    world.planes = {floor_plane};
    advance(world, h, 1);
    EXPECT_NEAR(spheres_of(world)[0].velocity.z(), after, 1e-9 * v) << gap;
  }
}

TEST(Threshold, warm_start_within_the_tolerance_is_improved_all_the_same) {
  // Or a resting pile would keep its warm start's error in every step, and creep.
  const WholeProblem whole = shaken_block(4, 0.4, 0.05);
  const SolverSettings settings{.tolerance = 0.1, .prox = 0};
  Solved solved = solve_whole(whole, settings);
  for (int step = 0; step < 10; ++step) {
    solved = solve_whole(whole, settings, {}, solved.impulse);
    EXPECT_GE(solved.report.iterations, 12);
  }
  EXPECT_LT(solved.report.residual, 0.1 * settings.tolerance);
}

TEST(Threshold, every_residual_is_within_the_speed_asked_for) {
  const WholeProblem whole = shaken_block(4, 0.4, 0.05);
  for (const SolverMethod method : {SolverMethod::accelerated, SolverMethod::sor})
    for (const double speed : {1e-3, 1e-4}) {
      const Solved solved = solve_whole(
          whole,
          {.method = method, .tolerance = 0.5, .speed_tolerance = speed, .max_iterations = 20000});
      EXPECT_TRUE(solved.report.converged);
      EXPECT_LE(solved.report.residual_max, speed);
      EXPECT_GT(solved.report.residual, 1e-9);  // and not to the last digit
    }
}

/// The same contacts a step later: what closed of them still closes, and nothing loads them anew.
WholeProblem step_after(const WholeProblem& whole, const Solved& solved) {
  WholeProblem next = whole;
  for (Index c = 0; c < whole.contacts(); ++c) {
    const Index i = whole.i[c], j = whole.j[c];
    Vec3 dv = -solved.linear[i], ds = solved.angular[i];
    if (j != ground) {
      dv += solved.linear[j];
      ds += solved.angular[j];
    }
    next.free_velocity[c] += dv - whole.kappa[c] * ds.cross(whole.normal[c]);
  }
  return next;
}

TEST(Threshold, what_a_loaded_step_left_is_not_solved_to_the_last_digit) {
  const WholeProblem whole = shaken_block(5, 0.4, 0);
  SolverSettings settings;
  const Solved loaded = solve_whole(whole, settings);
  const WholeProblem next = step_after(whole, loaded);
  const Solved alone = solve_whole(next, settings);
  EXPECT_LT(alone.report.scale, 2e-2 * loaded.report.scale);
  EXPECT_GT(alone.report.products, 40);
  settings.impact = false;
  settings.least_scale = loaded.report.scale;
  const Solved judged = solve_whole(next, settings);
  EXPECT_TRUE(judged.report.converged);
  EXPECT_LE(judged.report.products, 20);
  EXPECT_LE(judged.report.residual, settings.tolerance);
  EXPECT_EQ(judged.report.scale, loaded.report.scale);
}

TEST(Threshold, steps_between_kicks_are_judged_by_the_last_kick_unless_something_meets) {
  // Three balls rest on each other by their own gravity. One is thrown at the others, or comes
  // more slowly than gravity between two kicks would make it.
  const double h = 1e-3;
  for (double speed : {1e-6, 1.0}) {
    Lab world = make_world(testing_world(),
                           {{.mass = 1e9, .position = {-1, 0, 0}},
                            {.mass = 1e9, .position = {1, 0, 0}},
                            {.mass = 1e9, .position = {0, std::sqrt(3.0), 0}}},
                           {.friction = 0.5, .restitution = 0.3});
    world.gravity = {.method = GravityMethod::direct};
    for (int k = 0; k < 20; ++k) nonsmooth_step(world, h, SolverSettings{}, 1);
    const double scale = nonsmooth_step(world, h, SolverSettings{}, 10).solver.scale;
    ASSERT_GT(scale, 0);
    ASSERT_GT(world.kick.steps_left, 0);
    for (Index b = 0; b < world.bodies.owned; ++b)
      if (world.bodies.id[b] == 2) world.bodies.velocity[b].y() -= speed;
    const StepReport report = nonsmooth_step(world, h, SolverSettings{}, 10);
    if (speed < 1) {
      EXPECT_EQ(report.solver.scale, scale);
      EXPECT_LE(report.solver.products, 20);
    } else {
      EXPECT_GT(report.solver.scale, 100 * scale);
      EXPECT_GT(report.solver.products, 40);
    }
  }
}

/// A light body in the middle of others that all come in at 1 m/s, from every side.
WholeProblem besieged() {
  WholeProblem whole;
  whole.inverse_mass = {10};
  for (int x = -1; x <= 1; ++x)
    for (int y = -1; y <= 1; ++y)
      for (int z = -1; z <= 1; ++z) {
        const Vec3 from(x, y, z);
        if (from.isZero(0)) continue;
        const double shift = 0.1 * x + 0.05 * y * z;
        whole.inverse_mass.push_back(1);
        whole.add(0, whole.bodies() - 1, from.normalized(),
                  -(1 + shift) * from.normalized() + Vec3(0.1 * y, 0.1 * z, 0.2 * x), 0.3);
      }
  return whole;
}

TEST(Threshold, contacts_that_ranks_relax_at_once_do_not_overshoot) {
  // The light body is on one rank, all that press on it on the others: undamped, 26 impulses at
  // once would throw it out ten times over.
  const WholeProblem whole = besieged();
  const Comm comm = testing_world();
  std::vector<int> owner(whole.bodies(), 0);
  for (Index b = 1; b < whole.bodies(); ++b)
    owner[b] = comm.size == 1 ? 0 : 1 + b % (comm.size - 1);
  for (int dimension : {1, 3}) {
    WholeProblem posed = whole;
    posed.dimension = dimension;
    SolverSettings settings{.tolerance = 1e-4, .max_iterations = 3000, .prox = 0};
    const Solved exact = solve_whole(posed, settings);
    settings.method = SolverMethod::sor;
    const Solved relaxed = solve_whole(posed, settings, owner);
    EXPECT_TRUE(relaxed.report.converged) << relaxed.report.residual;
    for (Index b = 0; b < whole.bodies(); ++b)
      EXPECT_LT((relaxed.linear[b] - exact.linear[b]).norm(), 1e-2);
  }
}

TEST(Threshold, longest_step_of_pairs_is_set_by_their_stiffness_or_by_their_damping) {
  // As the README gives it: a tenth of sqrt(m/k), or 0.06 of it over the damping.
  const double m = 3;
  for (PairPotential p : {lennard_jones, mie, morse, steinhauser}) {
    const double swing = std::sqrt(m / stiffness(p));
    for (double damping : {0.0, 0.3, 0.599, 0.601, 1.2}) {
      p.damping = damping;
      EXPECT_DOUBLE_EQ(longest_step(p, m), damping < 0.6 ? 0.1 * swing : 0.06 / damping * swing);
    }
    p.damping = 1.2;
    const double h = longest_step(p, m);
    EXPECT_EQ(complaint_of([&] { check_step(p, h * (1 - 1e-9), {m, m / 2, 0}, "here"); }), "");
    EXPECT_NE(complaint_of([&] { check_step(p, h * (1 + 1e-9), {m, m / 2, 0}, "here"); }), "");
    const double speed = 0.1 * p.distance / h;  // a tenth of the distance, flown in a step
    EXPECT_EQ(complaint_of([&] { check_step(p, h * 0.999, {m, m / 2, speed}, "here"); }), "");
    EXPECT_NE(complaint_of([&] {
                check_step(p, h * 0.999, {m, m / 2, 1.002 * speed}, "here");
              }),
              "");
  }
}

TEST(Threshold, what_is_slower_than_the_escape_speed_is_bound_wherever_the_clump_is) {
  Clump clump{.mass = 1e9, .velocity = {0, 3, 0}};
  const double mass = 2e8, distance = 50, constant = 6.7e-11;
  const double escape = std::sqrt(2 * constant * (clump.mass + mass) / distance);
  for (double away : {0.0, 400.0}) {
    clump.position = {away, -2 * away, 0};
    const Vec3 place = clump.position + Vec3(0, 0, distance);
    const auto bound = [&](double share) {
      return is_bound(place, clump.velocity + Vec3(share * escape, 0, 0), mass, clump, constant);
    };
    EXPECT_TRUE(bound(0.999));
    EXPECT_FALSE(bound(1.001));
  }
}

TEST(Threshold, ejecta_cones_end_where_half_and_nine_tenths_of_the_momentum_are_in) {
  // Rings about the flight's reverse: 40, 20, 25 and 15 % of sum m |v|.
  struct Ring {
    double angle, share;
  };
  Bodies bodies;
  const auto add = [&](double mass, const Vec3& velocity) {
    const Index row = append_row(bodies);
    bodies.id[row] = row;
    bodies.mass[row] = mass;
    bodies.radius[row] = 1;
    bodies.position[row] = Vec3(10.0 * row, 0, 0);
    bodies.velocity[row] = velocity;
  };
  add(1e6, Vec3::Zero());  // the pile
  const BodyId impactor = 1;
  add(1, Vec3(0, 0, -1000));
  for (const Ring& ring : {Ring{10, 0.40}, Ring{30, 0.20}, Ring{50, 0.25}, Ring{110, 0.15}})
    for (int k = 0; k < 8; ++k) {
      const double theta = ring.angle * pi / 180, phi = k * pi / 4, mass = 1 + k / 4 % 2;
      add(mass, ring.share / mass *
                    Vec3(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi),
                         std::cos(theta)));
    }
  bodies.owned = bodies.size();
  const BeforeImpact before{.impactor = impactor,
                            .impactor_mass = 1,
                            .target_mass = 1e6,
                            .relative_velocity = Vec3(0, 0, -1000)};
  const Comm self = alone();
  const Deflection result =
      measure_deflection(self, Ghosts(self, bodies.owned, {}), bodies, {}, 0, before);
  EXPECT_EQ(result.ejecta.count, 32);
  EXPECT_NEAR(result.ejecta.momentum.normalized().z(), 1, 1e-14);
  EXPECT_NEAR(result.ejecta.cone_half, 30, 0.11);  // upwards to 0.1 degrees
  EXPECT_NEAR(result.ejecta.cone_most, 110, 0.11);
}

}  // namespace
}  // namespace spall
