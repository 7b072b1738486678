// Pair potentials in space that repeats itself and between walls, and the energy that rows tell.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include "pair_potentials.hpp"
#include "spall/error.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

Lab potential_world(const Comm& comm, const std::vector<Sphere>& spheres,
                    const PairPotential& potential) {
  Lab world = make_world(comm, spheres, {});
  world.potential.law = potential;
  return world;
}

/// So many bodies a side on a cubic lattice about the origin, with random velocities.
std::vector<Sphere> cube(int side, double spacing, double speed) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> motion(-speed, speed);
  std::vector<Sphere> spheres;
  for (int k = 0; k < side * side * side; ++k) {
    const Vec3 place(k % side, k / side % side, k / side / side);
    const double x = motion(random), y = motion(random), z = motion(random);
    spheres.push_back({.radius = 0.5,
                       .mass = 1 + 0.25 * (k % 2),
                       .position = spacing * (place - Vec3::Constant((side - 1) / 2.0)),
                       .velocity = {x, y, z}});
  }
  return spheres;
}

double kinetic_of(const std::vector<Sphere>& spheres) {
  double kinetic = 0;
  for (const Sphere& s : spheres)
    if (std::isfinite(s.mass)) kinetic += s.mass * s.velocity.squaredNorm() / 2;
  return kinetic;
}

TEST(Melt, a_crystal_across_the_boundary_is_the_crystal) {
  const auto spheres = cube(5, 1.08, 0.4);
  const Period period{.low = {-9, -9, -9}, .size = {18, 18, 18}};
  auto moved = spheres;
  for (Sphere& s : moved) s.position = period.wrapped(s.position + Vec3(9, 8.2, 7.5));
  PairPotential bonded = morse;
  bonded.breaking_strain = 0.2;
  bonded.cutoff = 1.4 * bonded.distance;
  for (PairPotential p : {lennard_jones, crowded, bonded}) {
    p.damping = 0.1;
    Lab here = potential_world(testing_world(), spheres, p);
    Lab there = potential_world(testing_world(), moved, p);
    there.period = period;
    EXPECT_NEAR(potential_energy(here), potential_energy(there), 1e-11);
    potential_steps(here, 0.01, 300);
    potential_steps(there, 0.01, 300);
    EXPECT_GT(there.potential.near.searches, 1);
    const auto a = spheres_of(here), b = spheres_of(there);
    for (std::size_t k = 0; k < a.size(); ++k)
      EXPECT_LE((a[k].velocity - b[k].velocity).norm(), 1e-9) << k;
  }
}

/// The force on each body by the sum over all pairs and images.
std::vector<Vec3> forces_of(const std::vector<Sphere>& at, const PairPotential& p, double edge) {
  std::vector<Vec3> force(at.size(), Vec3::Zero());
  for (std::size_t i = 0; i < at.size(); ++i)
    for (std::size_t j = 0; j < at.size(); ++j) {
      Vec3 x = at[j].position - at[i].position;
      for (double& c : x) c = std::remainder(c, edge);
      if (i != j) force[i] -= pair_force(p, x.norm()) * x.normalized();
    }
  return force;
}

TEST(Melt, steps_equal_the_sum_over_all_pairs_and_images) {
  // A body crosses the box several times, so that searches and wraps are part of it.
  const int side = 4;
  const double edge = side * 1.2, h = 0.004;
  Lab world = potential_world(testing_world(), cube(side, 1.2, 3), lennard_jones);
  world.period = {.low = Vec3::Constant(-edge / 2), .size = Vec3::Constant(edge)};
  for (int step = 0; step < 300; ++step) {
    auto middle = spheres_of(world);
    for (Sphere& s : middle) s.position += h / 2 * s.velocity;
    const auto force = forces_of(middle, lennard_jones, edge);
    potential_steps(world, h, 1);
    const auto after = spheres_of(world);
    for (std::size_t k = 0; k < after.size(); ++k) {
      const Vec3 expected = middle[k].velocity + h / middle[k].mass * force[k];
      ASSERT_LE((after[k].velocity - expected).norm(), 1e-11) << step << " " << k;
    }
  }
  EXPECT_GT(world.potential.near.searches, 5);
  EXPECT_LT(world.potential.near.searches, 150);
}

TEST(Melt, a_box_smaller_than_two_ranges_is_refused) {
  Lab world = potential_world(testing_world(), cube(3, 1.1, 0), lennard_jones);
  world.period.size = Vec3(20, 3.4, 20);  // less than twice 1.75 m
  EXPECT_THROW(potential_steps(world, 0.01, 1), Error);
}

TEST(Melt, a_row_tells_the_energy_of_velocity_verlet) {
  const auto spheres = cube(3, 1.05, 0.5);
  const double h = 0.02;
  for (const Vec3& gravity : {Vec3(0, 0, 0), Vec3(0.3, 0, -0.7)}) {
    Lab world = potential_world(testing_world(), spheres, lennard_jones);
    world.uniform_gravity = gravity;
    const double before = kinetic_of(spheres);
    const double told = world.comm.sum(
        potential_steps(world, world.potential, {.h = h, .most_steps = 3, .energy = true}).energy);
    // Half a step of drift and kick is half a step of velocity Verlet, about the middle.
    auto middle = spheres;
    for (Sphere& s : middle) s.position += h / 2 * s.velocity;
    const auto force = forces_of(middle, lennard_jones, 1e3);
    double pairs = 0, height = 0;
    for (std::size_t i = 0; i < middle.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j)
        pairs += pair_energy(lennard_jones, (middle[i].position - middle[j].position).norm());
      height -= spheres[i].mass * gravity.dot(h / 2 * spheres[i].velocity);
      middle[i].velocity += h / 2 * (force[i] / middle[i].mass + gravity);
    }
    const double expected = kinetic_of(middle) + pairs + height - before;
    EXPECT_NEAR(told, expected, 1e-12 * std::abs(expected));
  }
}

TEST(Melt, a_body_is_thrown_back_by_a_wall_from_the_height_that_its_energy_tells) {
  const double speed = 0.8, mass = 2, h = 1e-3;
  Lab world = potential_world(
      testing_world(), {{.mass = mass, .position = {0, 0, 1.5}, .velocity = {0.3, 0, -speed}}},
      lennard_jones);
  world.planes = {{.point = {0, 0, 0.2}}};
  double lowest = 10;
  for (int k = 0; k < 3000; ++k) {
    potential_steps(world, h, 1);
    lowest = std::min(lowest, spheres_of(world)[0].position.z());
  }
  const Sphere after = spheres_of(world)[0];
  EXPECT_NEAR(after.velocity.z(), speed, 1e-5);
  EXPECT_NEAR(after.velocity.x(), 0.3, 1e-14);
  const double r = lowest - 0.2 + lennard_jones.distance / 2;
  EXPECT_LT(r, lennard_jones.distance);
  EXPECT_NEAR(pair_energy(lennard_jones, r) - pair_energy(lennard_jones, lennard_jones.distance),
              mass * speed * speed / 2, 1e-4);
}

TEST(Melt, bodies_in_a_box_and_a_field_keep_their_energy) {
  // They fall, melt and boil between six planes.
  auto spheres = cube(4, 1.15, 0.5);
  Lab world = potential_world(testing_world(), spheres, lennard_jones);
  world.uniform_gravity = {0, 0, -0.2};
  for (int k = 0; k < 3; ++k)
    for (double side : {-1.0, 1.0})
      world.planes.push_back(
          {.point = side * 3.5 * Vec3::Unit(k), .normal = -side * Vec3::Unit(k)});
  std::vector<double> energy;
  double least = infinity, most = -infinity;
  for (int row = 0; row < 40; ++row) {
    const auto now = spheres_of(world);
    double total = kinetic_of(now);
    for (const Sphere& s : now) {
      total += 0.2 * s.mass * s.position.z();
      EXPECT_LT(s.position.cwiseAbs().maxCoeff(), 3.5);
    }
    total += world.comm.sum(
        potential_steps(world, world.potential, {.h = 0.004, .most_steps = 100, .energy = true})
            .energy);
    least = std::min(least, total);
    most = std::max(most, total);
  }
  EXPECT_GT(world.potential.at_walls.size() + world.potential.near.searches, 5);
  EXPECT_LT(most - least, 2e-3 * kinetic_of(spheres_of(world)));
}

}  // namespace
}  // namespace spall
