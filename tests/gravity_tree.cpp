// The tree of gravity against the exact sum, and the momentum that it must keep.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>

#include "gravity/direct.hpp"
#include "gravity/multipole.hpp"
#include "gravity/tree.hpp"
#include "gravity_sets.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double constant = 6.67430e-11;

GravityField tree(const Comm& comm, const Points& mine, double accuracy) {
  return evaluate_gravity_tree(comm, constant, tree_settings(accuracy), mine.mass, mine.position,
                               mine.velocity);
}

GravityField direct(const Comm& comm, const Points& mine) {
  const bool rates = comm.any(!mine.velocity.empty());
  return evaluate_gravity_direct(comm, constant, mine.mass, mine.position, mine.velocity, rates);
}

double rms_error(const Comm& comm, const GravityField& field, const GravityField& exact) {
  double squares = 0;
  for (std::size_t b = 0; b < field.acceleration.size(); ++b)
    squares += (field.acceleration[b] - exact.acceleration[b]).squaredNorm() /
               exact.acceleration[b].squaredNorm();
  const auto count = comm.sum(static_cast<double>(field.acceleration.size()));
  return std::sqrt(comm.sum(squares) / count);
}

TEST(GravityTree, a_transposed_block_has_rows_for_columns) {
  Lanes block[lane_count];
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) block[row][column] = 10 * row + column;
  transpose(block);
  for (int row = 0; row < 8; ++row)
    for (int column = 0; column < 8; ++column) EXPECT_EQ(block[row][column], 10 * column + row);
}

TEST(GravityTree, derivatives_of_one_over_r_are_the_known_ones) {
  const double x = 1.5, y = -0.5, z = 2, r = std::sqrt(x * x + y * y + z * z);
  const auto d = derivatives<6>(spread(x), spread(y), spread(z), spread(1 / r));
  const auto at = [&](int i, int j, int k) { return d[MultiIndex{i, j, k}.place()][4]; };
  EXPECT_NEAR(at(1, 0, 0), -x / std::pow(r, 3), 1e-15);
  EXPECT_NEAR(at(1, 0, 1), 3 * x * z / std::pow(r, 5), 1e-15);
  EXPECT_NEAR(at(0, 2, 0), 3 * y * y / std::pow(r, 5) - 1 / std::pow(r, 3), 1e-15);
  EXPECT_NEAR(at(1, 1, 1), -15 * x * y * z / std::pow(r, 7), 1e-15);
  for (int axis : {0, 2}) {
    const double s = axis == 0 ? x : z;
    EXPECT_NEAR(axis == 0 ? at(4, 0, 0) : at(0, 0, 4),
                (105 * std::pow(s / r, 4) - 90 * std::pow(s / r, 2) + 9) / std::pow(r, 5), 1e-14);
  }
  // 1/r is harmonic, and so are its derivatives.
  for (MultiIndex n : multi_indices<4>)
    EXPECT_NEAR(at(n.x + 2, n.y, n.z) + at(n.x, n.y + 2, n.z) + at(n.x, n.y, n.z + 2), 0, 1e-13);
}

TEST(GravityTree, force_error_is_the_one_asked_for) {
  const Comm comm = testing_world();
  for (const auto& [name, all] :
       {std::pair{"ball", random_ball(6000, 3)}, std::pair{"cube", random_cube(6000, 3)},
        std::pair{"Plummer", plummer_sphere(6000, 3)},
        std::pair{"pile", pile_and_ejecta(6000, 5)}}) {
    const Points mine = share(comm, all);
    const GravityField exact = direct(comm, mine);
    for (double accuracy : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
      const double error = rms_error(comm, tree(comm, mine, accuracy), exact);
      EXPECT_LE(error, accuracy) << name;
      EXPECT_GE(error, accuracy / 3) << name << ' ' << accuracy;  // much better would be too slow
    }
  }
}

TEST(GravityTree, net_force_vanishes_to_round_off_and_net_torque_nearly) {
  const Comm comm = testing_world();
  for (const Points& all : {random_ball(5000, 7), pile_and_ejecta(5000, 9)}) {
    const Points mine = share(comm, all);
    const GravityField field = tree(comm, mine, 1e-3);
    const auto [force, torque] = net_force_and_torque(comm, mine, field.acceleration);
    EXPECT_LE(force, 1e-15);
    EXPECT_LE(torque, 1e-5);
  }
}

TEST(GravityTree, ranks_together_find_what_one_rank_finds) {
  const Comm comm = testing_world(), alone(MPI_COMM_SELF);
  const Points all = pile_and_ejecta(4000, 13);
  const Points mine = share(comm, all);
  const GravityField together = tree(comm, mine, 1e-4), by_one = tree(alone, all, 1e-4);
  std::size_t b = 0;
  for (std::size_t k = 0; k < all.size() && b < mine.size(); ++k) {
    if (mine.position[b] != all.position[k]) continue;
    EXPECT_LE((together.acceleration[b] - by_one.acceleration[k]).norm(),
              1e-12 * by_one.acceleration[k].norm());
    EXPECT_NEAR(together.potential[b], by_one.potential[k], -1e-12 * by_one.potential[k]);
    EXPECT_NEAR(together.rate[b], by_one.rate[k], 1e-12 * by_one.rate[k]);
    ++b;
  }
  EXPECT_EQ(b, mine.size());
}

TEST(GravityTree, potential_and_rate_agree_with_the_exact_sum) {
  const Comm comm = testing_world();
  const Points mine = share(comm, random_ball(4000, 17));
  const GravityField field = tree(comm, mine, 1e-4), exact = direct(comm, mine);
  for (std::size_t b = 0; b < mine.size(); ++b) {
    EXPECT_NEAR(field.potential[b], exact.potential[b], -1e-4 * exact.potential[b]);
    // A bound: never below, and not so far above that fields would be refreshed for nothing.
    EXPECT_GE(field.rate[b], 0.999 * exact.rate[b]);
    EXPECT_LE(field.rate[b], 2.5 * exact.rate[b]);
  }
}

TEST(GravityTree, without_velocities_there_are_no_rates) {
  const Comm comm = testing_world();
  Points mine = share(comm, random_ball(500, 17));
  const GravityField with = tree(comm, mine, 1e-3);
  mine.velocity.clear();
  const GravityField without = tree(comm, mine, 1e-3);
  EXPECT_TRUE(without.rate.empty());
  for (std::size_t b = 0; b < mine.size(); ++b)
    EXPECT_EQ(with.acceleration[b], without.acceleration[b]);
}

TEST(GravityTree, coincident_massless_and_distant_bodies_are_harmless) {
  const Comm comm = testing_world();
  Points all = random_ball(2000, 19);
  for (int k = 100; k < 300; ++k) all.position[k] = all.position[99];  // more than a leaf holds
  for (int k = 300; k < 400; ++k) all.mass[k] = 0;
  for (int k = 400; k < 420; ++k) all.position[k] *= 1e6;
  for (int k = 500; k < 600; ++k) all.position[k] *= 1e-6;
  const Points mine = share(comm, all);
  const double error = rms_error(comm, tree(comm, mine, 1e-3), direct(comm, mine));
  EXPECT_LE(error, 2e-3);
}

TEST(GravityTree, few_bodies_are_summed_exactly) {
  const Comm comm = testing_world();
  EXPECT_TRUE(tree(comm, {}, 1e-3).acceleration.empty());
  for (std::size_t count : {1, 2, 20}) {
    const Points mine = share(comm, random_ball(count, 23));
    const GravityField field = tree(comm, mine, 1e-3), exact = direct(comm, mine);
    for (std::size_t b = 0; b < mine.size(); ++b)
      EXPECT_LE((field.acceleration[b] - exact.acceleration[b]).norm(),
                1e-13 * exact.acceleration[b].norm());
  }
}

TEST(GravityTree, bodies_without_any_mass_feel_nothing) {
  const Comm comm = testing_world();
  Points mine = share(comm, random_ball(300, 27));
  std::ranges::fill(mine.mass, 0.0);
  for (const Vec3& a : tree(comm, mine, 1e-3).acceleration) EXPECT_EQ(a, Vec3::Zero());
}

TEST(GravityTree, other_units_give_the_same_bits) {
  const Comm comm = testing_world();
  const Points mine = share(comm, pile_and_ejecta(2000, 29));
  Points scaled = mine;
  const double length = 0x1p20, time = 0x1p-7, mass = 0x1p-33;
  for (Vec3& x : scaled.position) x *= length;
  for (Vec3& v : scaled.velocity) v *= length / time;
  for (double& m : scaled.mass) m *= mass;
  const GravityField field = tree(comm, mine, 1e-3);
  const GravityField other =
      evaluate_gravity_tree(comm, constant * (length * length * length / (mass * time * time)),
                            tree_settings(1e-3), scaled.mass, scaled.position, scaled.velocity);
  for (std::size_t b = 0; b < mine.size(); ++b) {
    EXPECT_EQ(other.acceleration[b], field.acceleration[b] * (length / (time * time)));
    EXPECT_EQ(other.potential[b], field.potential[b] * (length * length / (time * time)));
    EXPECT_EQ(other.rate[b], field.rate[b] * (length / (time * time * time)));
  }
}

TEST(GravityTree, a_lattice_of_equal_cells_keeps_momentum_too) {
  const Comm comm = testing_world();
  // All decisions between equal radii.
  Points all;
  for (int k = 0; k < 16 * 16 * 16; ++k) {
    all.position.push_back(Vec3(k % 16, k / 16 % 16, k / 256));
    all.velocity.push_back(Vec3::Zero());
    all.mass.push_back(1);
  }
  const Points mine = share(comm, all);
  const GravityField field = tree(comm, mine, 1e-3);
  Vec3 force = Vec3::Zero();
  double forces = 0;
  for (const Vec3& a : field.acceleration) {
    force += a;
    forces += a.norm();
  }
  // Terms that cancel leave round-off several times that of what is left.
  EXPECT_LE(comm.sum(force).norm(), 0x1p-48 * comm.sum(forces));
}

TEST(GravityTree, automatic_takes_the_tree_for_many_bodies) {
  GravitySettings settings;
  settings.method = GravityMethod::automatic;
  EXPECT_EQ(choose_gravity(settings, 100), GravityMethod::direct);
  EXPECT_EQ(choose_gravity(settings, 1000000), GravityMethod::tree);
  settings.accuracy = 1e-12;
  EXPECT_EQ(choose_gravity(settings, 100000), GravityMethod::direct);
  EXPECT_EQ(describe_gravity(settings, 100), "exact sum over the pairs of 100 bodies (automatic)");
}

}  // namespace
}  // namespace spall
