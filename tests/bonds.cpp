// Bonds that break for good, against sums over all pairs with a list of those that hold.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>
#include <set>

#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

const PairPotential law{.law = PairLaw::morse,
                        .depth = 0.7,
                        .distance = 1.1,
                        .steepness = 3.36,
                        .cutoff = 1.1 * 1.1,
                        .breaking_strain = 0.05};

Lab world_of(const Comm& comm, const std::vector<Sphere>& spheres) {
  Lab world = make_world(comm, spheres, {});
  world.potential.law = law;
  return world;
}

/// A ball of an fcc crystal.
std::vector<Sphere> crystal(double radius, const Vec3& centre, const Vec3& velocity) {
  std::vector<Sphere> spheres;
  const int n = static_cast<int>(radius / law.distance * 1.5) + 1;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k) {
        const Vec3 x = law.distance / std::sqrt(2.0) * Vec3(i, j, k);
        if ((i + j + k) % 2 == 0 && x.norm() <= radius)
          spheres.push_back({.position = centre + x, .velocity = velocity});
      }
  return spheres;
}

/// Two crystals that hit each other, thermal motion in both.
std::vector<Sphere> impact() {
  auto spheres = crystal(2.9, Vec3::Zero(), Vec3::Zero());
  for (const Sphere& s : crystal(1.7, {5.1, 0.4, 0.3}, {-3, 0, 0})) spheres.push_back(s);
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> motion(-0.3, 0.3);
  for (Sphere& s : spheres) s.velocity += Vec3(motion(random), motion(random), motion(random));
  return spheres;
}

using BondSet = std::set<std::pair<std::size_t, std::size_t>>;

/// Drift, kick, drift, every pair looked at.
void reference_step(std::vector<Sphere>& spheres, BondSet& bonds, bool first, double h) {
  std::vector<Vec3> force(spheres.size(), Vec3::Zero());
  for (Sphere& s : spheres) s.position += h / 2 * s.velocity;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t j = i + 1; j < spheres.size(); ++j) {
      const Vec3 x = spheres[j].position - spheres[i].position;
      const double r = x.norm();
      if (r < law.cutoff && first) bonds.insert({i, j});
      if (r >= law.cutoff) bonds.erase({i, j});
      if (!bonds.contains({i, j}) && r >= law.distance) continue;
      force[j] += pair_force(law, r) / r * x;
      force[i] -= pair_force(law, r) / r * x;
    }
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    spheres[i].velocity += h / spheres[i].mass * force[i];
    spheres[i].position += h / 2 * spheres[i].velocity;
  }
}

double count_bonds(const Lab& world) {
  const auto bonds = bonds_of(world.bodies, world.potential.near);
  return world.comm.sum(static_cast<double>(bonds->other.size())) / 2;
}

double energy_of(Lab& world) {
  double kinetic = 0;
  for (const Sphere& s : spheres_of(world)) kinetic += s.mass * s.velocity.squaredNorm() / 2;
  return kinetic + potential_energy(world);
}

TEST(Bonds, break_for_good_as_in_a_sum_over_all_pairs) {
  auto spheres = impact();
  Lab world = world_of(testing_world(), spheres);
  BondSet bonds;
  constexpr double h = 0.02;
  constexpr int steps = 120;
  std::size_t made = 0;
  for (int k = 0; k < steps; ++k) {
    reference_step(spheres, bonds, k == 0, h);
    if (k == 0) made = bonds.size();
  }
  for (int k = 0; k < steps; k += 10) potential_steps(world, h, 10);
  EXPECT_GT(world.potential.near.searches, 4);
  EXPECT_LT(bonds.size(), made * 3 / 4);
  EXPECT_GT(bonds.size(), made / 10);
  EXPECT_EQ(count_bonds(world), static_cast<double>(bonds.size()));
  const auto after = spheres_of(world);
  for (std::size_t k = 0; k < spheres.size(); ++k)
    EXPECT_LE((after[k].position - spheres[k].position).norm(), 1e-9 * law.distance) << k;
  // Damage by body, from the list.
  measure_damage(world.bodies, world.potential.near);
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const auto id = static_cast<std::size_t>(world.bodies.id[b]);
    const auto now = std::count_if(bonds.begin(), bonds.end(), [&](const auto& bond) {
      return bond.first == id || bond.second == id;
    });
    const double before = world.bodies.bonds[b];
    EXPECT_NEAR(world.bodies.damage[b], 1 - static_cast<double>(now) / before, 1e-15);
  }
}

TEST(Bonds, hold_back_no_more_once_broken) {
  // Parted, sent back, and parted again at less than a bond would let go.
  const std::vector<Sphere> spheres{{}, {.position = {1.1, 0, 0}}};
  Lab world = world_of(testing_world(), spheres);
  const auto set_speed = [&](double relative) {
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.velocity[b] = {world.bodies.id[b] == 0 ? -relative / 2 : relative / 2, 0, 0};
  };
  constexpr double h = 0.005;
  set_speed(1);
  potential_steps(world, h, 200);
  const auto apart = [&] {
    const auto now = spheres_of(world);
    return (now[1].position - now[0].position).norm();
  };
  ASSERT_GT(apart(), law.cutoff);
  set_speed(-0.2);
  const auto go_while = [&](auto&& condition) {
    for (int k = 0; k < 1000 && condition(); ++k) potential_steps(world, h, 50);
  };
  go_while([&] { return apart() > 1.1; });
  ASSERT_LT(apart(), 1.1);
  go_while([&] { return apart() < 1.3; });
  const auto now = spheres_of(world);
  EXPECT_NEAR(now[1].velocity.x() - now[0].velocity.x(), 0.2, 1e-4);
  EXPECT_EQ(count_bonds(world), 0);
}

TEST(Bonds, join_bodies_of_one_group_only) {
  for (int group : {0, 1}) {
    Lab world = world_of(testing_world(), {{}, {.position = {1.12, 0, 0}}});
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.group[b] = world.bodies.id[b] == 0 ? 0 : group;
    potential_steps(world, 0.01, 1);
    EXPECT_EQ(count_bonds(world), group == 0 ? 1 : 0);
    const double pull = spheres_of(world)[0].velocity.x();
    if (group == 0)
      EXPECT_GT(pull, 0);
    else
      EXPECT_EQ(pull, 0);
  }
}

TEST(Bonds, breaking_costs_no_energy_beyond_second_order) {
  std::vector<double> errors;
  for (int halvings = 0; halvings < 4; ++halvings) {
    Lab world = world_of(testing_world(), impact());
    const int steps = 240 << halvings;
    const double before = energy_of(world), bonds = count_bonds(world);
    double worst = 0;
    for (int k = 0; k < 12; ++k) {
      potential_steps(world, 2.4 / steps, steps / 12);
      worst = std::max(worst, std::abs(energy_of(world) / before - 1));
    }
    EXPECT_LT(count_bonds(world), bonds * 3 / 4);
    errors.push_back(worst);
  }
  EXPECT_LT(errors[0], 1e-3);
  EXPECT_LT(errors[3], errors[0] / 32);  // 64 at second order
}

TEST(Bonds, go_on_where_pairs_were_forgotten) {
  Lab world = world_of(testing_world(), impact());
  potential_steps(world, 0.02, 60);
  const double before = count_bonds(world), energy = energy_of(world);
  auto bonds = bonds_of(world.bodies, world.potential.near);
  resize(world.bodies, world.bodies.owned);
  world.potential.near = NearPairs{};
  world.potential.near.bonds = std::move(bonds);
  EXPECT_EQ(count_bonds(world), before);
  EXPECT_NEAR(energy_of(world), energy, 1e-13 * std::abs(energy));
  EXPECT_EQ(count_bonds(world), before);
}

}  // namespace
}  // namespace spall
