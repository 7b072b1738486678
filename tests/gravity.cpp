// The exact sum of gravity against closed forms, long double and its own invariants.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>

#include "base/reduce.hpp"
#include "gravity/field.hpp"
#include "gravity/map.hpp"
#include "gravity_sets.hpp"
#include "spall/error.hpp"
#include "spall/lanes.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double eps = std::numeric_limits<double>::epsilon();

GravitySettings direct() {
  GravitySettings settings;
  settings.method = GravityMethod::direct;
  return settings;
}

GravityField evaluate(const Comm& comm, const Points& mine) {
  return evaluate_gravity(comm, direct(), mine.mass, mine.position, mine.velocity);
}

/// s that the field may be held.
double holding_time(const Comm& comm, const GravitySettings& settings, const Points& mine,
                    const GravityField& field) {
  const ForceChange own = force_change(mine.mass, field);
  std::array<double, 2> sums{own.squares, own.bodies};
  double fastest = own.fastest;
  reduce(comm, sums, {&fastest, 1});
  return holding_time(settings, {sums[0], sums[1], fastest});
}

/// The bodies `mine` pulled by `all`, pair by pair as the formula stands.
struct Exact {
  std::vector<Vec3> acceleration, jerk;
  std::vector<double> potential, magnitude;  ///< magnitude: sum of |terms| of the acceleration
};
Exact brute_force(const Points& mine, const Points& all) {
  using Real = long double;
  using Real3 = Eigen::Matrix<Real, 3, 1>;
  const Real g = direct().constant;
  Exact exact;
  for (std::size_t i = 0; i < mine.size(); ++i) {
    Real3 a = Real3::Zero(), jerk = Real3::Zero();
    Real phi = 0, magnitude = 0;
    for (std::size_t j = 0; j < all.size(); ++j) {
      const Real3 d = all.position[j].cast<Real>() - mine.position[i].cast<Real>();
      const Real3 dv = all.velocity[j].cast<Real>() - mine.velocity[i].cast<Real>();
      const Real r = d.norm();
      if (r == 0) continue;
      const Real gm = g * all.mass[j];
      a += gm / (r * r * r) * d;
      jerk += gm / (r * r * r) * (dv - 3 * d.dot(dv) / (r * r) * d);
      phi -= gm / r;
      magnitude += gm / (r * r);
    }
    exact.acceleration.push_back(a.cast<double>());
    exact.jerk.push_back(jerk.cast<double>());
    exact.potential.push_back(static_cast<double>(phi));
    exact.magnitude.push_back(static_cast<double>(magnitude));
  }
  return exact;
}

TEST(Gravity, inverse_square_root_is_right_to_two_units_in_the_last_place) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> exponent(-200, 200);
  for (int k = 0; k < 20000; ++k) {
    const double v = std::exp2(exponent(random));
    const long double exact = 1 / std::sqrt(static_cast<long double>(v));
    EXPECT_LE(std::abs(inverse_sqrt(spread(v))[3] - exact), 2 * eps * exact);
    EXPECT_NEAR(estimate_sqrt(spread(v))[5], std::sqrt(v), estimate_error * std::sqrt(v));
  }
  EXPECT_EQ(inverse_sqrt(spread(0.0))[0], 0);
  EXPECT_EQ(estimate_sqrt(spread(0.0))[0], 0);
}

TEST(Gravity, two_bodies_obey_newton) {
  const Comm comm = testing_world();
  Points all;
  all.mass = {4e6, 1e3};
  all.position = {Vec3(0, 0, 0), Vec3(3, 0, 4)};
  all.velocity = {Vec3(0, 0, 0), Vec3(0, 2, 0)};
  const Points mine = share(comm, all);
  const GravityField field = evaluate(comm, mine);
  for (std::size_t b = 0; b < mine.size(); ++b) {
    const bool heavy = mine.mass[b] == 4e6;
    const double gm = direct().constant * (heavy ? 1e3 : 4e6);
    const Vec3 expected = gm / 25 * Vec3(0.6, 0, 0.8) * (heavy ? 1 : -1);
    EXPECT_LE((field.acceleration[b] - expected).norm(), 4 * eps * expected.norm());
    EXPECT_NEAR(field.potential[b], -gm / 5, 4 * eps * gm / 5);
    EXPECT_NEAR(field.rate[b], 2 * gm * 2 / 125, 1e-3 * gm / 125);  // a bound, 2^-12 above
  }
}

TEST(Gravity, agrees_with_long_double_on_any_count) {
  const Comm comm = testing_world();
  // Around the sizes of a vector and of a tile, and several tiles.
  for (std::size_t count : {1, 2, 7, 8, 9, 255, 256, 257, 700}) {
    const Points all = random_ball(count, 3), mine = share(comm, all);
    const GravityField field = evaluate(comm, mine);
    const Exact exact = brute_force(mine, all);
    for (std::size_t b = 0; b < mine.size(); ++b) {
      // Round-off of a term is a few eps, of the sum sqrt(N) eps.
      EXPECT_LE((field.acceleration[b] - exact.acceleration[b]).norm(),
                16 * eps * exact.magnitude[b]);
      EXPECT_NEAR(field.potential[b], exact.potential[b], 16 * eps * -exact.potential[b]);
    }
  }
}

TEST(Gravity, rate_bounds_the_change_of_the_field_in_any_frame) {
  const Comm comm = testing_world();
  Points all = random_ball(600, 11), mine = share(comm, all);
  const GravityField field = evaluate(comm, mine);
  const Exact exact = brute_force(mine, all);
  for (std::size_t b = 0; b < mine.size(); ++b) EXPECT_GE(field.rate[b], exact.jerk[b].norm());
  for (Vec3& v : mine.velocity) v += Vec3(4000, -300, 20);
  const GravityField moving = evaluate(comm, mine);
  for (std::size_t b = 0; b < mine.size(); ++b)
    EXPECT_NEAR(moving.rate[b], field.rate[b], 1e-3 * field.rate[b]);
}

TEST(Gravity, net_force_and_torque_vanish_to_round_off) {
  const Comm comm = testing_world();
  const Points all = random_ball(3000, 7), mine = share(comm, all);
  const GravityField field = evaluate(comm, mine);
  const auto [force, torque] = net_force_and_torque(comm, mine, field.acceleration);
  EXPECT_LE(force, 1e-15);
  EXPECT_LE(torque, 1e-15);
}

TEST(Gravity, coincident_and_massless_bodies_are_harmless) {
  const Comm comm = testing_world();
  Points all = random_ball(300, 19);
  all.position[10] = all.position[11] = all.position[12];
  all.mass[20] = all.mass[21] = 0;
  all.position[30] = all.position[20];
  const Points mine = share(comm, all);
  const GravityField field = evaluate(comm, mine);
  const Exact exact = brute_force(mine, all);
  for (std::size_t b = 0; b < mine.size(); ++b)
    EXPECT_LE((field.acceleration[b] - exact.acceleration[b]).norm(), 16 * eps * exact.magnitude[b])
        << b;
}

TEST(Gravity, one_body_and_no_body_feel_nothing) {
  const Comm comm = testing_world();
  Points mine;
  EXPECT_TRUE(evaluate(comm, mine).acceleration.empty());
  if (comm.rank == comm.size - 1) mine = random_ball(1, 1);
  const GravityField field = evaluate(comm, mine);
  for (const Vec3& a : field.acceleration) EXPECT_EQ(a, Vec3::Zero());
  EXPECT_EQ(holding_time(comm, direct(), mine, field), infinity);
}

TEST(Gravity, other_units_give_the_same_bits) {
  const Comm comm = testing_world();
  const Points mine = share(comm, random_ball(500, 23));
  const GravityField field = evaluate(comm, mine);
  Points scaled = mine;
  const double length = 0x1p20, time = 0x1p-7, mass = 0x1p-33;
  for (Vec3& x : scaled.position) x *= length;
  for (Vec3& v : scaled.velocity) v *= length / time;
  for (double& m : scaled.mass) m *= mass;
  GravitySettings settings = direct();
  settings.constant *= length * length * length / (mass * time * time);
  const GravityField other =
      evaluate_gravity(comm, settings, scaled.mass, scaled.position, scaled.velocity);
  for (std::size_t b = 0; b < mine.size(); ++b) {
    EXPECT_EQ(other.acceleration[b], field.acceleration[b] * (length / (time * time)));
    EXPECT_EQ(other.potential[b], field.potential[b] * (length * length / (time * time)));
    EXPECT_EQ(other.rate[b], field.rate[b] * (length / (time * time * time)));
  }
  EXPECT_EQ(holding_time(comm, settings, scaled, other),
            holding_time(comm, direct(), mine, field) * time);
}

TEST(Gravity, bodies_without_a_finite_mass_are_refused_on_every_rank) {
  const Comm comm = testing_world();
  Points mine = share(comm, random_ball(40, 2));
  if (comm.rank == 0) mine.mass[0] = infinity;
  EXPECT_THROW(evaluate(comm, mine), Error);
  GravitySettings off;
  for (const Vec3& a :
       evaluate_gravity(comm, off, mine.mass, mine.position, mine.velocity).acceleration)
    EXPECT_EQ(a, Vec3::Zero());
}

TEST(Gravity, outside_a_shell_is_a_point_mass_and_inside_is_nothing) {
  const Comm comm = testing_world();
  // Directions on a golden spiral: the sum differs from the sphere's by about 1/N.
  const std::size_t count = 4000;
  Points shell;
  for (std::size_t k = 0; k < count; ++k) {
    const double z = 1 - (2 * k + 1.0) / count, angle = k * pi * (3 - std::sqrt(5.0));
    const double rho = std::sqrt(1 - z * z);
    shell.position.push_back(50 * Vec3(rho * std::cos(angle), rho * std::sin(angle), z));
    shell.mass.push_back(1e6);
    shell.velocity.push_back(Vec3::Zero());
  }
  const Points mine = share(comm, shell);
  const std::vector<Vec3> places = {{100, 0, 0}, {0, -20, 10}, shell.position[7]};
  const GravityField field = evaluate_gravity_at(comm, direct(), mine.mass, mine.position, places);
  const double gm = direct().constant * 1e6 * count;
  EXPECT_LE((field.acceleration[0] + gm / 1e4 * Vec3::UnitX()).norm(), 1e-3 * gm / 1e4);
  EXPECT_NEAR(field.potential[0], -gm / 100, 1e-3 * gm / 100);
  EXPECT_LE(field.acceleration[1].norm(), 1e-3 * gm / 2500);
  EXPECT_NEAR(field.potential[1], -gm / 50, 1e-3 * gm / 50);
  // On the shell half of the outside pull; a body that lies there adds nothing.
  EXPECT_NEAR(field.acceleration[2].norm(), gm / 5000, 0.05 * gm / 5000);
}

TEST(Gravity, a_map_is_the_field_of_uniform_spheres) {
  const Comm comm = testing_world();
  Bodies bodies;  // two that overlap and one far away, dealt over the ranks
  const std::vector<Vec3> centers = {{0, 0, 0}, {1.5, 0.25, 0}, {-3, 2, 0.5}};
  const std::vector<double> radii = {1, 0.75, 0.5}, masses = {3e9, 1e9, 5e8};
  for (std::size_t k = 0; k < centers.size(); ++k) {
    if (static_cast<int>(k) % comm.size != comm.rank) continue;
    const Index b = append_row(bodies);
    bodies.position[b] = centers[k];
    bodies.radius[b] = radii[k];
    bodies.mass[b] = masses[k];
  }
  bodies.owned = bodies.size();
  const Grid grid = Grid::in_box({0.25, 0, 0}, {9, 6, 2}, 0.25);
  EXPECT_EQ(grid.counts, (std::array<std::int64_t, 3>{37, 25, 9}));
  EXPECT_LE((grid.place(grid.total() - 1) - Vec3(4.75, 3, 1)).norm(), 1e-14);
  const GravityMap map = map_gravity(comm, direct(), bodies, grid);
  const auto points = static_cast<std::int64_t>(map.potential.size());
  EXPECT_EQ(comm.sum(points), grid.total());
  EXPECT_EQ(map.first, comm.sum_before(points));
  double worst_pull = 0, worst_potential = 0;
  for (std::int64_t k = 0; k < points; ++k) {
    Vec3 pull = Vec3::Zero();
    double potential = 0, largest = 0;
    for (std::size_t s = 0; s < centers.size(); ++s) {
      const Vec3 d = centers[s] - grid.place(map.first + k);
      const double gm = direct().constant * masses[s], r = std::max(d.norm(), radii[s]);
      pull += gm / (r * r * r) * d;
      potential -= d.norm() > radii[s] ? gm / r : gm * (3 - d.squaredNorm() / (r * r)) / (2 * r);
      largest += gm / (radii[s] * radii[s]);
    }
    // Points next to a centre subtract a large pull from itself.
    worst_pull = std::max(worst_pull, (map.acceleration[k] - pull).norm() / largest);
    worst_potential = std::max(worst_potential, std::abs(map.potential[k] / potential - 1));
  }
  EXPECT_LE(comm.max(worst_pull), 1e-13);
  EXPECT_LE(comm.max(worst_potential), 1e-13);
}

TEST(Gravity, a_held_field_changes_by_no_more_than_was_allowed) {
  const Comm comm = testing_world();
  Points mine = share(comm, random_ball(400, 29));
  GravitySettings settings = direct();
  const GravityField before = evaluate(comm, mine);
  const double held = holding_time(comm, settings, mine, before);
  double squares = 0;
  for (std::size_t b = 0; b < mine.size(); ++b)
    squares += (mine.mass[b] * before.acceleration[b]).squaredNorm();
  const double rms = std::sqrt(comm.sum(squares) / 400);
  for (std::size_t b = 0; b < mine.size(); ++b) mine.position[b] += held * mine.velocity[b];
  const GravityField after = evaluate(comm, mine);
  double change = 0;
  for (std::size_t b = 0; b < mine.size(); ++b)
    change = std::max(change,
                      mine.mass[b] * (after.acceleration[b] - before.acceleration[b]).norm() / rms);
  change = comm.max(change);
  // 2 % for the rate's own change; a bound that is hundreds of times too careful would be useless.
  EXPECT_LE(change, 1.02 * settings.refresh);
  EXPECT_GE(change, settings.refresh / 20);
}

TEST(Gravity, a_leapfrog_orbit_closes) {
  const Comm comm = testing_world();
  // Equal masses on circles about each other; the error of leapfrog's period is (omega h)^2 / 24.
  const double mass = 1e9, distance = 10;
  const double omega = std::sqrt(2 * direct().constant * mass / (distance * distance * distance));
  Points all;
  all.mass = {mass, mass};
  all.position = {Vec3(distance / 2, 0, 0), Vec3(-distance / 2, 0, 0)};
  all.velocity = {Vec3(0, omega * distance / 2, 0), Vec3(0, -omega * distance / 2, 0)};
  const Points start = share(comm, all);
  Points mine = start;
  const int steps = 1000;
  const double h = 2 * pi / omega / steps;
  for (int step = 0; step < steps; ++step) {
    for (std::size_t b = 0; b < mine.size(); ++b) mine.position[b] += h / 2 * mine.velocity[b];
    const GravityField field = evaluate(comm, mine);
    for (std::size_t b = 0; b < mine.size(); ++b) {
      mine.velocity[b] += h * field.acceleration[b];
      mine.position[b] += h / 2 * mine.velocity[b];
    }
  }
  for (std::size_t b = 0; b < mine.size(); ++b)
    EXPECT_LE((mine.position[b] - start.position[b]).norm(),
              distance * 10 * std::pow(2 * pi / steps, 2));
}

}  // namespace
}  // namespace spall
