// Steps of solids in parts that last as their bodies allow.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "copper_pieces.hpp"
#include "testing.hpp"

namespace spall {
namespace {

Lab parted(Lab world, double courant = usual_courant) {
  world.solid.courant = courant;
  return world;
}
/// s: how long sound takes across a spacing.
const double crossing = d / ductile.sound_speed();
/// kg, of a body in a lattice.
const double mass = copper.density * volume_of_lattice(d);
/// As pressed as the cold curve says, and failed.
void press_and_break(Bodies& bodies, double compression) {
  for (Index b = 0; b < bodies.owned; ++b) {
    bodies.damage[b] = 1;
    bodies.compression[b] = compression;
    bodies.internal_energy[b] = mass / ductile.density * ductile.cold.at(compression).energy;
  }
}

TEST(PartedSteps, energy_error_is_of_second_order) {
  std::vector<double> errors;
  for (const double courant : {0.2, 0.1, 0.05}) {
    Lab world = parted(world_of(alone(), stirred_ball(), elastic), courant);
    const double before = sums_of(world).kinetic;
    solid_steps(world, 4 * d / elastic.sound_speed(), 1);
    const Sums after = sums_of(world);
    errors.push_back(std::abs(after.kinetic + after.internal - before) / before);
  }
  EXPECT_LT(errors[0], 0.01);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.5);
}

TEST(PartedSteps, momenta_and_energy_are_kept_where_pieces_meet_and_yield) {
  const double speed = 1500;
  Lab world = parted(world_of_two(testing_world(), speed, ductile));
  const Sums before = sums_of(world);
  for (int k = 0; k < 4; ++k) solid_steps(world, crossing, 3);
  expect_kept(world, before, speed);
}

TEST(PartedSteps, are_as_long_as_the_fastest_that_is_near_allows) {
  const double rest = usual_courant * crossing, speed = 3000;
  const double met = usual_courant * d / (ductile.sound_speed() + 4 * ductile.slope * speed);
  const auto parts = [&](double distance, double closing, double lasts, bool one_piece) {
    std::vector<Sphere> two(2, {.radius = d / 2, .mass = mass});
    two[1].position = {distance, 0, 0};
    for (Sphere& s : two) s.velocity = {0, 0, 5 * speed};  // a common motion counts for nothing
    two[0].velocity.x() = closing;
    Lab world = parted(world_of(testing_world(), two, ductile));
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.group[b] = one_piece ? 0 : static_cast<int>(world.bodies.id[b]);
    solid_steps(world, lasts, 1);
    return world.solid.parts;
  };
  for (const bool one_piece : {true, false}) {
    // In one piece they press each other, and sound is faster then; so it is in warmer ones.
    EXPECT_GE(parts(1.6 * d, speed, 3 * met, one_piece), 3);
    EXPECT_EQ(parts(1.3 * d, -speed, 2.9 * met, one_piece), 3);
    EXPECT_EQ(parts(1.8 * d, -speed, 2.5 * rest, one_piece), 3);  // even parts
    EXPECT_EQ(parts(1.6 * d, 0, 10.5 * rest, one_piece), 11);
  }
}

TEST(PartedSteps, are_not_made_shorter_by_who_is_hot_and_alone) {
  const auto parts = [&](double distance) {
    std::vector<Sphere> two(2, {.radius = d / 2, .mass = mass});
    two[1].position = {distance, 0, 0};
    Lab world = parted(world_of(testing_world(), two, ductile));
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.heat[b] = world.bodies.internal_energy[b] = 1e7 * mass;
    solid_steps(world, 10.5 * usual_courant * crossing, 1);
    return world.solid.parts;
  };
  EXPECT_EQ(parts(1.8 * d), 11);
  EXPECT_GT(parts(1.6 * d), 14);
}

TEST(PartedSteps, see_who_comes_before_it_is_there) {
  // Sound alone would let them fly two spacings and more in a part.
  const double speed = 12 * ductile.sound_speed();
  auto spheres = two_balls(speed);
  for (Sphere& s : spheres) s.position.x() += 4.3 * d * (s.velocity.x() < 0 ? 1 : -1);
  Lab world = parted(of_two(testing_world(), spheres, ductile));
  const Sums before = sums_of(world);
  solid_steps(world, 10 * d / speed, 2);
  const Sums after = sums_of(world);
  EXPECT_GT(after.heat, 0.05 * before.kinetic);
  EXPECT_NEAR(after.kinetic + after.internal, before.kinetic, 0.02 * before.kinetic);
}

/// Bodies of one piece that have failed press each other: by how much their energy changes until
/// they have parted, of what they held.
double gained_by_failed(const std::vector<Vec3>& places, double compression, double courant) {
  std::vector<Sphere> spheres;
  for (const Vec3& place : places)
    spheres.push_back({.radius = d / 2, .mass = mass, .position = place});
  Lab world = parted(world_of(alone(), spheres, ductile), courant);
  press_and_break(world.bodies, compression);
  const double before = sums_of(world).internal;
  solid_steps(world, 2 * crossing, 5);
  const Sums after = sums_of(world);
  return (after.kinetic + after.internal) / before - 1;
}

TEST(PartedSteps, failed_bodies_make_no_energy_however_near_they_are) {
  const Vec3 x = Vec3(2, 1, -2) / 3, y = Vec3(1, 2, 2) / 3, z = Vec3(2, -2, 1) / 3;
  for (const double compression : {1.05, 1.2, 1.5}) {
    const auto gained_by_two = [&](double distance, double courant) {
      return gained_by_failed({{0, 0, 0}, distance * x}, compression, courant);
    };
    for (double distance = 0.001 * d; distance < 0.2 * d; distance *= 1.3)
      EXPECT_EQ(gained_by_two(distance, usual_courant), 0) << distance;
    // Where they begin to be resolved, or are no longer so, the error is of first order.
    for (const double distance : {0.28 * d, 0.325 * d, 0.4 * d, 1.54 * d})
      for (const double courant : {usual_courant, usual_courant / 2, usual_courant / 4})
        EXPECT_LE(std::abs(gained_by_two(distance, courant)), 0.8 * courant)
            << distance << " " << courant;
    for (double distance = 0.7 * d; distance < 1.1 * d; distance *= 1.1)
      EXPECT_LE(std::abs(gained_by_two(distance, usual_courant)), 1e-3) << distance;
    // One in the middle, which sees as much in all directions.
    for (double distance = 0.001 * d; distance < 0.08 * d; distance *= 1.5) {
      std::vector<Vec3> places{{0, 0, 0}};
      for (const Vec3& axis : {x, y, z})
        for (const double side : {-distance, distance}) places.push_back(side * axis);
      EXPECT_EQ(gained_by_failed(places, compression, usual_courant), 0) << distance;
    }
  }
}

TEST(PartedSteps, who_is_whole_among_failed_bodies_fails_and_lets_its_pressure_go) {
  const double compression = 1.2;
  std::vector<Sphere> spheres(1, {.radius = d / 2, .mass = mass});
  for (int k = 0; k < 3; ++k)
    for (const double side : {-1, 1})
      spheres.push_back({.radius = d / 2, .mass = mass, .position = side * d * Vec3::Unit(k)});
  for (const bool yields : {true, false}) {
    Lab world = parted(world_of(testing_world(), spheres, yields ? ductile : elastic));
    Bodies& bodies = world.bodies;
    press_and_break(bodies, compression);
    for (Index b = 0; b < bodies.owned; ++b)
      if (bodies.id[b] == 0) bodies.damage[b] = 0;
    const Sums before = sums_of(world);
    solid_steps(world, crossing, 5);
    const Sums after = sums_of(world);
    EXPECT_NEAR(after.kinetic + after.internal, before.internal, 0.02 * before.internal);
    for (Index b = 0; b < bodies.owned; ++b)
      if (bodies.id[b] == 0) {
        EXPECT_EQ(bodies.damage[b], yields ? 1 : 0);
        EXPECT_NEAR(bodies.pressure[b] / ductile.cold.at(compression).pressure, yields ? 0 : 1,
                    0.01);
      }
  }
}

TEST(PartedSteps, are_no_longer_than_what_they_are_parts_of) {
  Lab world = parted(world_of_two(testing_world(), 10, ductile));
  solid_steps(world, 0.01 * crossing, 30);
  EXPECT_EQ(world.solid.parts, 30);
}

TEST(PartedSteps, motion_is_the_same_on_any_number_of_ranks) {
  Lab one = parted(world_of_two(alone(), 1500, ductile)),
      many = parted(world_of_two(testing_world(), 1500, ductile));
  for (int part = 0; part < 3; ++part) {
    solid_steps(one, 2 * crossing, 1);
    solid_steps(many, 2 * crossing, 1);
  }
  EXPECT_EQ(one.solid.parts, many.solid.parts);
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-9 * d) << k;
}

TEST(PartedSteps, go_on_from_bodies_alone_with_the_same_bits) {
  Lab first = parted(world_of_two(testing_world(), 1500, ductile));
  solid_steps(first, 2 * crossing, 2);
  first.solid.restart_pairs(first, {});
  Lab resumed = parted(World(first));
  resumed.solid.laws = {ductile};
  for (Lab* world : {&first, &resumed}) solid_steps(*world, 2 * crossing, 2);
  const auto p = spheres_of(first), q = spheres_of(resumed);
  for (std::size_t k = 0; k < p.size(); ++k) {
    EXPECT_EQ(p[k].position, q[k].position);
    EXPECT_EQ(p[k].velocity, q[k].velocity);
  }
}

}  // namespace
}  // namespace spall
