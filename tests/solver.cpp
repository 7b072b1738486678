// The contact solver: exact solutions, optimality, conservation, the same on any number of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>

#include "contact_problems.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

SolverSettings tight(FrictionModel friction = FrictionModel::coulomb) {
  return {.friction = friction, .tolerance = 1e-9, .max_iterations = 20000, .prox = 0};
}

/// Relative velocities after the solve.
std::vector<Vec3> velocities(const WholeProblem& whole, const Solved& solved) {
  std::vector<Vec3> u(whole.contacts());
  for (Index c = 0; c < whole.contacts(); ++c) {
    const Index i = whole.i[c], j = whole.j[c];
    const Vec3 v_j = j == ground ? Vec3::Zero() : solved.linear[j];
    const Vec3 s_j = j == ground ? Vec3::Zero() : solved.angular[j];
    u[c] = whole.free_velocity[c] + v_j - solved.linear[i] -
           whole.kappa[c] * (solved.angular[i] + s_j).cross(whole.normal[c]);
  }
  return u;
}

TEST(Solver, head_on_equal_spheres_stop) {
  WholeProblem whole;
  whole.inverse_mass = {1, 1};
  whole.add(0, 1, Vec3::UnitX(), Vec3(-2, 0, 0), 0.5);
  for (int dimension : {1, 3}) {
    whole.dimension = dimension;
    const Solved solved = solve_whole(whole, tight());
    EXPECT_TRUE(solved.report.converged);
    EXPECT_NEAR(solved.impulse[0].x(), 1, 1e-8);
    EXPECT_NEAR(solved.linear[0].x(), -1, 1e-8);
    EXPECT_NEAR(solved.linear[1].x(), 1, 1e-8);
  }
}

TEST(Solver, oblique_impact_slips_or_sticks_by_the_friction_bound) {
  // Sphere on ground, normal speed 1: sticks iff u_t <= 3.5 mu u_n; a_t = 3.5 a_n.
  for (double mu : {0.1, 0.5}) {
    WholeProblem whole;
    whole.inverse_mass = {2};
    whole.add(0, ground, -Vec3::UnitZ(), Vec3(1, 0, 1), mu);
    const Solved solved = solve_whole(whole, tight());
    const double p_t = std::min(mu * 0.5, 1 / (3.5 * 2));
    EXPECT_NEAR(solved.impulse[0].z(), -0.5, 1e-8);
    EXPECT_NEAR(solved.impulse[0].x(), -p_t, 1e-8);
    EXPECT_NEAR(velocities(whole, solved)[0].x(), 1 - 3.5 * 2 * p_t, 1e-7);
  }
}

TEST(Solver, cohesive_pair_holds_below_its_bound_and_parts_above) {
  for (double pull : {0.99, 1.01}) {
    WholeProblem whole;
    whole.inverse_mass = {1, 1};
    whole.add(0, 1, Vec3::UnitX(), Vec3(2 * pull, 0, 0), 0.5, 1.0);
    for (int dimension : {1, 3}) {
      whole.dimension = dimension;
      const Solved solved = solve_whole(whole, tight());
      EXPECT_NEAR(solved.impulse[0].x(), -std::min(pull, 1.0), 1e-8);
      EXPECT_NEAR(velocities(whole, solved)[0].x(), std::max(0.0, 2 * pull - 2), 1e-7);
    }
  }
}

TEST(Solver, column_carries_the_weight_above_each_contact) {
  constexpr int n = 100;
  WholeProblem whole;
  whole.inverse_mass.assign(n, 1);
  whole.add(0, ground, -Vec3::UnitZ(), Vec3(0, 0, 1), 0.5);
  for (Index b = 1; b < n; ++b) whole.add(b - 1, b, Vec3::UnitZ(), Vec3::Zero(), 0.5);
  for (int dimension : {1, 3}) {
    whole.dimension = dimension;
    SolverSettings settings = tight(FrictionModel::convex);  // no sliding: Coulomb's as well
    settings.tolerance = 1e-7;
    const Solved solved = solve_whole(whole, settings);
    EXPECT_TRUE(solved.report.converged);
    EXPECT_NEAR(solved.impulse[0].z(), -n, 1e-6 * n);
    for (Index b = 1; b < n; ++b) EXPECT_NEAR(solved.impulse[b].z(), n - b, 1e-6 * n);
  }
}

TEST(Solver, solution_is_optimal_in_every_contact) {
  const WholeProblem whole = shaken_block(4, 0.4, 0.05);
  SolverSettings settings = tight();
  settings.tolerance = 1e-7;
  const Solved solved = solve_whole(whole, settings);
  EXPECT_TRUE(solved.report.converged) << solved.report.residual;
  const std::vector<Vec3> u = velocities(whole, solved);
  for (Index c = 0; c < whole.contacts(); ++c) {
    const Vec3 n = whole.normal[c], p = solved.impulse[c];
    const double p_n = n.dot(p) + whole.cohesive_impulse[c], u_n = n.dot(u[c]);
    const Vec3 p_t = p - n.dot(p) * n, u_t = u[c] - u_n * n;
    const double mu = whole.friction[c], tolerance = 1e-5;
    EXPECT_GE(p_n, -1e-12);
    EXPECT_GE(u_n, -tolerance);
    EXPECT_LE(p_t.norm(), mu * p_n + 1e-15);  // round-off at the apex
    EXPECT_NEAR(p_n * u_n, 0, tolerance);
    EXPECT_NEAR(p_t.dot(u_t), -mu * p_n * u_t.norm(), tolerance);  // slip opposes friction
  }
}

TEST(Solver, convex_solution_is_optimal_in_every_contact) {
  const WholeProblem whole = shaken_block(4, 0.4, 0.05);
  SolverSettings settings = tight(FrictionModel::convex);
  settings.tolerance = 1e-7;
  const Solved solved = solve_whole(whole, settings);
  EXPECT_TRUE(solved.report.converged) << solved.report.residual;
  const std::vector<Vec3> u = velocities(whole, solved);
  for (Index c = 0; c < whole.contacts(); ++c) {
    const Vec3 n = whole.normal[c];
    const Vec3 p = solved.impulse[c] + whole.cohesive_impulse[c] * n;
    const double u_n = n.dot(u[c]);
    EXPECT_GE(u_n - whole.friction[c] * (u[c] - u_n * n).norm(), -1e-5);  // in the dual cone
    EXPECT_NEAR(p.dot(u[c]), 0, 1e-5);
  }
}

TEST(Solver, any_number_of_ranks_finds_the_same) {
  const Comm comm = testing_world();
  for (int dimension : {1, 3})
    for (FrictionModel friction : {FrictionModel::convex, FrictionModel::coulomb}) {
      WholeProblem whole = shaken_block(5, 0.4, 0.02);
      whole.dimension = dimension;
      SolverSettings settings = tight(friction);
      settings.prox = 1e-2;  // the solution is unique
      const Solved one = solve_whole(whole, settings);
      const Solved many = solve_whole(whole, settings, random_owners(whole.bodies(), comm.size));
      EXPECT_TRUE(many.report.converged);
      EXPECT_TRUE(many.same_on_both_ranks);
      for (Index c = 0; c < whole.contacts(); ++c)
        EXPECT_LT((one.impulse[c] - many.impulse[c]).norm(), 1e-6);
    }
}

TEST(Solver, free_system_keeps_momentum_to_round_off) {
  const Comm comm = testing_world();
  std::vector<Vec3> x;
  std::vector<double> r;
  const WholeProblem whole = shaken_block(5, 0.6, 0.05, &x, &r);
  WholeProblem free;
  free.inverse_mass = whole.inverse_mass;
  for (Index c = 0; c < whole.contacts(); ++c)
    if (whole.j[c] != ground)
      free.add(whole.i[c], whole.j[c], whole.normal[c], whole.free_velocity[c], 0.6, 0.05,
               whole.kappa[c]);
  SolverSettings settings;  // as in a run: far from exact, momentum exact all the same
  const Solved solved = solve_whole(free, settings, random_owners(free.bodies(), comm.size));
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double exchanged = 0;
  for (Index b = 0; b < free.bodies(); ++b) {
    const Vec3 p = solved.linear[b] / free.inverse_mass[b];
    linear += p;
    angular += x[b].cross(p) + 0.4 * r[b] / free.inverse_mass[b] * solved.angular[b];
    exchanged += p.norm();
  }
  EXPECT_LT(linear.norm(), 1e-14 * exchanged);
  EXPECT_LT(angular.norm(), 1e-13 * exchanged);
}

TEST(Solver, units_do_not_matter_to_a_single_bit) {
  const WholeProblem whole = shaken_block(4, 0.4, 0.05);
  WholeProblem scaled = whole;
  const double mass = 1024, speed = 1.0 / 4096;
  for (double& w : scaled.inverse_mass) w /= mass;
  for (Vec3& u : scaled.free_velocity) u *= speed;
  for (double& s : scaled.cohesive_impulse) s *= mass * speed;
  const Solved a = solve_whole(whole, {}), b = solve_whole(scaled, {});
  EXPECT_EQ(a.report.iterations, b.report.iterations);
  EXPECT_EQ(a.report.residual, b.report.residual);
  for (Index c = 0; c < whole.contacts(); ++c) EXPECT_EQ(mass * speed * a.impulse[c], b.impulse[c]);
}

TEST(Solver, warm_start_from_the_solution_saves_iterations) {
  const WholeProblem whole = shaken_block(4, 0.4, 0.05);
  const Solved cold = solve_whole(whole, {});
  const Solved warm = solve_whole(whole, {}, {}, cold.impulse);
  EXPECT_GT(cold.report.iterations, 0);
  EXPECT_LT(warm.report.iterations, cold.report.iterations);
}

TEST(Solver, one_fast_collision_does_not_cost_all_others_their_warm_start) {
  WholeProblem whole = shaken_block(4, 0.4, 0.05);
  const Solved before = solve_whole(whole, {});
  std::vector<Vec3> start = before.impulse;
  whole.inverse_mass.resize(whole.bodies() + 2, 1);
  whole.add(whole.bodies() - 2, whole.bodies() - 1, Vec3::UnitX(), Vec3(-1e9, 0, 0), 0.4);
  start.push_back(Vec3::Zero());
  const Solved after = solve_whole(whole, {}, {}, start);
  for (Index c = 0; c + 1 < whole.contacts(); ++c)
    EXPECT_LT((after.impulse[c] - start[c]).norm(), 0.1);
  EXPECT_NEAR(after.impulse.back().x(), 5e8, 1e7);
}

TEST(Solver, dense_lattice_of_redundant_contacts_holds) {
  // Simple cubic, all contacts closed, pressed from above: many impulses solve it.
  constexpr Index n = 12;
  WholeProblem whole;
  whole.dimension = 1;
  whole.inverse_mass.assign(n * n * n, 1);
  for (Index z = 0; z < n; ++z)
    for (Index y = 0; y < n; ++y)
      for (Index x = 0; x < n; ++x) {
        const Index at = (z * n + y) * n + x;
        if (x + 1 < n) whole.add(at, at + 1, Vec3::UnitX(), Vec3::Zero());
        if (y + 1 < n) whole.add(at, at + n, Vec3::UnitY(), Vec3::Zero());
        const double fall = z + 2 == n ? 1 : 0;  // the topmost layer alone comes down
        if (z + 1 < n) whole.add(at, at + n * n, Vec3::UnitZ(), Vec3(0, 0, -fall));
        if (z == 0) whole.add(at, ground, -Vec3::UnitZ(), Vec3::Zero());
      }
  const Solved solved = solve_whole(whole, {.tolerance = 1e-6, .max_iterations = 5000, .prox = 0});
  EXPECT_TRUE(solved.report.converged);
  for (Index c = 0; c < whole.contacts(); ++c)
    EXPECT_NEAR(solved.impulse[c].norm(), whole.normal[c].z() != 0 ? 1 : 0, 1e-3);
}

TEST(Solver, impulses_of_another_state_of_motion_are_dropped) {
  // What held bodies together before they rebound is neither where to start nor what to stay near.
  WholeProblem whole = shaken_block(4, 0.4, 0.05);
  const Solved before = solve_whole(whole, {});
  for (Index c = 0; c < whole.contacts(); ++c)
    whole.free_velocity[c] += 10 * whole.normal[c] + Vec3(0.3, 0, 0);
  for (Index c = 0; c < 20; ++c) whole.free_velocity[c] *= -1;
  const Solved cold = solve_whole(whole, {}), warm = solve_whole(whole, {}, {}, before.impulse);
  EXPECT_GT(cold.report.iterations, 0);
  EXPECT_EQ(cold.impulse, warm.impulse);
}

TEST(Solver, nothing_to_do_takes_no_iteration) {
  WholeProblem nobody;
  EXPECT_EQ(solve_whole(nobody, {}).report.iterations, 0);
  WholeProblem lonely;
  lonely.inverse_mass = {1};
  EXPECT_TRUE(solve_whole(lonely, {}).report.converged);
  WholeProblem parting;
  parting.inverse_mass = {1, 1};
  parting.add(0, 1, Vec3::UnitX(), Vec3(1, 2, 0), 0.5);
  const Solved solved = solve_whole(parting, {}, {}, {Vec3(3, 0, 0)});
  EXPECT_EQ(solved.report.iterations, 0);
  EXPECT_EQ(solved.impulse[0], Vec3::Zero());
}

TEST(Solver, bad_numbers_are_refused_on_all_ranks) {
  WholeProblem whole = shaken_block(2, 0.4, 0);
  whole.free_velocity[3].y() = std::nan("");
  EXPECT_THROW(solve_whole(whole, {}), Error);
}

TEST(Solver, mass_ratios_do_not_limit_accuracy) {
  // One on the other on the ground, both falling. A heavy one on a light one makes the problem as
  // ill-conditioned as the ratio.
  const double below_over_above[] = {1e9, 1e6, 1e3, 1e-3};
  for (double ratio : below_over_above) {
    WholeProblem whole;
    whole.inverse_mass = {1 / ratio, 1};
    whole.add(0, ground, -Vec3::UnitZ(), Vec3(0, 0, 1), 0.5);
    whole.add(0, 1, Vec3::UnitZ(), Vec3::Zero(), 0.5);
    const Solved solved = solve_whole(whole, tight());
    EXPECT_TRUE(solved.report.converged);
    EXPECT_NEAR(solved.impulse[0].z(), -(ratio + 1), 1e-7 * (ratio + 1));
  }
}

TEST(Solver, ranks_without_bodies_take_part) {
  const WholeProblem whole = shaken_block(3, 0.4, 0);
  const int last = testing_world().size - 1;
  const Solved solved = solve_whole(whole, {}, std::vector<int>(whole.bodies(), last));
  EXPECT_TRUE(solved.report.converged);
  EXPECT_EQ(solved.impulse, solve_whole(whole, {}).impulse);
}

TEST(Solver, never_ends_worse_than_it_started) {
  const WholeProblem whole = shaken_block(5, 1.5, 0.02);
  for (int iterations : {0, 1, 3, 10}) {
    const Solved solved =
        solve_whole(whole, {.tolerance = 1e-12, .max_iterations = iterations, .prox = 0});
    EXPECT_LE(solved.report.residual, 1);
    EXPECT_FALSE(solved.report.converged);
    EXPECT_EQ(solved.report.iterations, iterations);
  }
}

TEST(Solver, proximal_solution_stays_near_the_warm_start) {
  // Two contacts share a load in any way: the proximal term keeps the way of the start.
  WholeProblem whole;
  whole.inverse_mass = {1};
  for (double x : {-0.6, 0.6}) whole.add(0, ground, Vec3(x, 0, -0.8), Vec3(0, 0, 1), 0.8);
  const Solved free = solve_whole(whole, {.tolerance = 1e-8, .prox = 1e-2});
  std::vector<Vec3> squeezed = free.impulse;
  squeezed[0].x() += 0.1;
  squeezed[1].x() -= 0.1;
  const Solved kept = solve_whole(whole, {.tolerance = 1e-8, .prox = 1e-2}, {}, squeezed);
  EXPECT_NEAR(kept.impulse[0].x(), squeezed[0].x(), 0.02);
}

}  // namespace
}  // namespace spall
