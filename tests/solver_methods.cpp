// Every method on the same problems; the operator and the projections by brute force.
// SPDX-License-Identifier: BSD-3-Clause
#include "contact_problems.hpp"
#include "solver/methods.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr SolverMethod all_methods[] = {SolverMethod::accelerated, SolverMethod::apgd,
                                        SolverMethod::barzilai_borwein, SolverMethod::sor};

/// Random points of the cone |p_t| <= mu (p_n + s), in coordinates (n, t1, t2).
Vec3 random_in_cone(std::mt19937_64& random, double mu, double s) {
  std::uniform_real_distribution<double> uniform(0, 1);
  const double height = 3 * uniform(random), angle = 2 * pi * uniform(random);
  const double radius = mu * height * std::sqrt(uniform(random));
  return {height - s, radius * std::cos(angle), radius * std::sin(angle)};
}

TEST(Projection, is_the_nearest_point_of_the_cone) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-2, 2);
  for (double mu : {0.0, 0.3, 2.0})
    for (double s : {0.0, 0.7})
      for (double theta2 : {1.0, 3.5})
        for (int sample = 0; sample < 50; ++sample) {
          const Vec3 z(uniform(random), uniform(random), uniform(random));
          const double tangent = z.tail<2>().norm();
          const auto to = project_cone(z[0], tangent, mu, s, theta2);
          const Vec3 p(to.normal, to.tangent_factor * z[1], to.tangent_factor * z[2]);
          const auto distance2 = [&](const Vec3& q) {
            return (z[0] - q[0]) * (z[0] - q[0]) + theta2 * (z - q).tail<2>().squaredNorm();
          };
          EXPECT_GE(p[0], -s);
          EXPECT_LE(p.tail<2>().norm(), mu * (p[0] + s) + 1e-15);
          for (int other = 0; other < 200; ++other)
            EXPECT_LE(distance2(p), distance2(random_in_cone(random, mu, s)) + 1e-14);
        }
}

TEST(Projection, of_coulomb_solves_a_single_contact_exactly) {
  // u = b + diag(1, theta2, theta2) p: one projection of -S^-1 b must meet Coulomb's law.
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-2, 2);
  const double theta2 = 3.5, mu = 0.4, s = 0.1;
  for (int sample = 0; sample < 200; ++sample) {
    const Vec3 b(uniform(random), uniform(random), uniform(random));
    const Vec3 z(-b[0], -b[1] / theta2, -b[2] / theta2);
    const auto to = project_coulomb(z[0], z.tail<2>().norm(), mu, s);
    const Vec3 p(to.normal, to.tangent_factor * z[1], to.tangent_factor * z[2]);
    const Vec3 u = b + Vec3(p[0], theta2 * p[1], theta2 * p[2]);
    const double p_n = p[0] + s;
    EXPECT_GE(p_n, 0);
    EXPECT_GE(u[0], -1e-15);
    EXPECT_NEAR(p_n * u[0], 0, 1e-14);
    EXPECT_LE(p.tail<2>().norm(), mu * p_n + 1e-15);
    EXPECT_NEAR(p.tail<2>().dot(u.tail<2>()), -mu * p_n * u.tail<2>().norm(), 1e-14);
  }
}

TEST(Projection, treats_eight_contacts_as_it_treats_one) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-2, 2);
  Lanes z, tangent, mu, s;
  for (std::size_t l = 0; l < lane_count; ++l) {
    z[l] = uniform(random);
    tangent[l] = std::abs(uniform(random));
    mu[l] = std::abs(uniform(random));
    s[l] = l % 2;
  }
  const auto cone = project_cone(z, tangent, mu, s, Lanes{} + 3.5);
  const auto coulomb = project_coulomb(z, tangent, mu, s);
  for (std::size_t l = 0; l < lane_count; ++l) {
    const auto one = project_cone<double>(z[l], tangent[l], mu[l], s[l], 3.5);
    EXPECT_DOUBLE_EQ(cone.normal[l], one.normal);
    EXPECT_DOUBLE_EQ(cone.tangent_factor[l], one.tangent_factor);
    const auto two = project_coulomb<double>(z[l], tangent[l], mu[l], s[l]);
    EXPECT_DOUBLE_EQ(coulomb.normal[l], two.normal);
    EXPECT_DOUBLE_EQ(coulomb.tangent_factor[l], two.tangent_factor);
  }
}

TEST(Product, is_the_dense_delassus_matrix_times_the_impulses) {
  const Comm comm = testing_world();
  const WholeProblem whole = shaken_block(3, 0.4, 0.05);
  std::mt19937_64 random(9);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> p(whole.contacts()), expected(whole.contacts(), Vec3::Zero());
  for (Vec3& each : p) each = Vec3(uniform(random), uniform(random), uniform(random));
  for (Index c = 0; c < whole.contacts(); ++c)
    for (Index e = 0; e < whole.contacts(); ++e) expected[c] += delassus_block(whole, c, e) * p[e];

  const Piece piece(whole, comm, random_owners(whole.bodies(), comm.size));
  const ContactProblem problem = piece.problem();
  std::vector<Vec3> own;
  for (Index c : piece.contact) own.push_back(p[c]);
  const ContactSystem<3> system{.ghosts = piece.ghosts,
                                .friction = FrictionModel::convex,
                                .units = {},
                                .contacts = pack<3>(problem, {}, piece.owned),
                                .centre = {}};
  const auto velocity = system.product(pack_impulses<3>(problem, {}, own));
  const auto part = [&](Index row, int from) -> Vec3 {
    if (row == ground) return Vec3::Zero();
    const auto& at = velocity[row].at;
    return {at[from], at[from + 1], at[from + 2]};
  };
  for (std::size_t c = 0; c < piece.contact.size(); ++c) {
    const Index i = piece.own.i[c], j = piece.own.j[c];
    const Vec3 u = part(j, 0) - part(i, 0) -
                   piece.own.kappa[c] * (part(i, 4) + part(j, 4)).cross(piece.own.normal[c]);
    EXPECT_LT((u - expected[piece.contact[c]]).norm(), 1e-13);
  }

  // Symmetric over all ranks: q . N p = p . N q.
  for (Vec3& each : own) each = each.cwiseAbs().eval();
  const auto a = pack_impulses<3>(problem, {}, own);
  for (std::size_t c = 0; c < own.size(); ++c) own[c] = p[piece.contact[c]];
  const auto b = pack_impulses<3>(problem, {}, own);
  const double a_b = system.metric_product(a, system.gradient_change(system.product(b)));
  const double b_a = system.metric_product(b, system.gradient_change(system.product(a)));
  EXPECT_NEAR(a_b, b_a, 1e-5 * std::abs(a_b));  // the metric is float
}

TEST(Product, has_the_metric_as_its_diagonal_blocks) {
  const WholeProblem whole = shaken_block(2, 0.4, 0);
  for (Index c = 0; c < whole.contacts(); ++c) {
    const double a_n = whole.inverse_mass[whole.i[c]] +
                       (whole.j[c] == ground ? 0 : whole.inverse_mass[whole.j[c]]);
    const double a_t = (1 + 2.5 * whole.kappa[c] * whole.kappa[c]) * a_n;
    const Vec3 n = whole.normal[c];
    const Eigen::Matrix3d expected =
        a_t * Eigen::Matrix3d::Identity() + (a_n - a_t) * n * n.transpose();
    EXPECT_LT((delassus_block(whole, c, c) - expected).norm(), 1e-13);
  }
}

TEST(Methods, agree_on_a_convex_problem) {
  const Comm comm = testing_world();
  for (int dimension : {1, 3}) {
    WholeProblem whole = shaken_block(3, 0.4, 0.02);
    whole.dimension = dimension;
    std::vector<Solved> solved;
    for (SolverMethod method : all_methods) {
      const SolverSettings settings{.method = method,
                                    .friction = FrictionModel::convex,
                                    .tolerance = 1e-6,
                                    .max_iterations = 100000,
                                    .prox = 0};
      solved.push_back(solve_whole(whole, settings, random_owners(whole.bodies(), comm.size)));
      EXPECT_TRUE(solved.back().report.converged) << static_cast<int>(method);
      EXPECT_TRUE(solved.back().same_on_both_ranks) << static_cast<int>(method);
    }
    // Velocities are unique, impulses need not be.
    for (const Solved& other : solved)
      for (Index b = 0; b < whole.bodies(); ++b)
        EXPECT_LT((other.linear[b] - solved[0].linear[b]).norm(), 1e-4);
  }
}

TEST(Methods, that_know_coulomb_friction_agree) {
  const Comm comm = testing_world();
  const WholeProblem whole = shaken_block(3, 0.3, 0.02);
  SolverSettings settings{.tolerance = 1e-8, .max_iterations = 100000, .prox = 0};
  const Solved one = solve_whole(whole, settings, random_owners(whole.bodies(), comm.size));
  settings.method = SolverMethod::sor;
  const Solved other = solve_whole(whole, settings, random_owners(whole.bodies(), comm.size));
  EXPECT_TRUE(one.report.converged);
  EXPECT_TRUE(other.report.converged);
  for (Index b = 0; b < whole.bodies(); ++b)
    EXPECT_LT((other.linear[b] - one.linear[b]).norm(), 1e-5);
}

TEST(Methods, that_only_minimise_refuse_coulomb_friction) {
  const WholeProblem whole = shaken_block(2, 0.4, 0);
  for (SolverMethod method : {SolverMethod::apgd, SolverMethod::barzilai_borwein})
    EXPECT_THROW(solve_whole(whole, {.method = method}), Error);
}

}  // namespace
}  // namespace spall
