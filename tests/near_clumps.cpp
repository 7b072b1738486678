// Gravity of clumps by their parts: shapes' parts, forces and torques, and what a world keeps.
// SPDX-License-Identifier: BSD-3-Clause
#include "clump_cases.hpp"
#include "clump_worlds.hpp"
#include "gravity/kick.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// Spheres that touch and do not overlap: outside they attract as their centres do.
BodyShape bead_pair() {
  const std::array<ShapeSphere, 2> two{{{Vec3(1.2, 0, 0), 0.9}, {Vec3(-0.5, 0, 0), 0.8}}};
  return make_shape("beads", two);
}
BodyShape bead_tripod() {
  std::vector<ShapeSphere> spheres{{Vec3::Zero(), 1}};
  for (int k = 0; k < 3; ++k) spheres.push_back({1.6 * Vec3::Unit(k), 0.6});
  return make_shape("tripod", spheres);
}

Lab attracting(const Comm& comm, const BodyShapes& shapes, const std::vector<ShapedBody>& clumps,
               double near, GravityMethod method = GravityMethod::direct) {
  Lab world = make_world(comm, shapes, clumps, {});
  world.gravity = {.method = method, .constant = 1, .accuracy = 1e-6, .near_clumps = near};
  return world;
}

struct Felt {
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
};

/// Of all bodies by id, on every rank. Collective.
std::vector<Felt> felt(Lab& world) {
  world.kick.evaluated = false;
  evaluate_field(world);
  const Bodies& bodies = world.bodies;
  std::vector<double> rows;
  for (Index b = 0; b < bodies.owned; ++b) {
    rows.push_back(static_cast<double>(bodies.id[b]));
    const Vec3 force = bodies.mass[b] * bodies.acceleration[b];
    const Vec3 torque = momentum_of_spin(world.shapes, bodies, b, bodies.angular_acceleration[b]);
    rows.insert(rows.end(), force.data(), force.data() + 3);
    rows.insert(rows.end(), torque.data(), torque.data() + 3);
  }
  const std::vector<double> all = world.comm.all_gather(rows);
  std::vector<Felt> sums(all.size() / 7);
  for (std::size_t k = 0; k < all.size(); k += 7)
    sums[static_cast<std::size_t>(all[k])] = {Vec3::Map(&all[k + 1]), Vec3::Map(&all[k + 4])};
  return sums;
}

struct Point {
  Vec3 arm;
  double mass;
};
/// The spheres of a clump of beads.
std::vector<Point> beads(const BodyShapes& shapes, const ShapedBody& clump) {
  std::vector<Point> points;
  double cubes = 0;
  for (const ShapeSphere& s : shapes[clump.shape].spheres) cubes += std::pow(s.radius, 3);
  for (const ShapeSphere& s : shapes[clump.shape].spheres)
    points.push_back(
        {clump.radius * (clump.orientation * s.at), clump.mass * std::pow(s.radius, 3) / cubes});
  return points;
}

/// What all spheres do to the clumps, pair by pair.
std::vector<Felt> by_brute_force(const BodyShapes& shapes, const std::vector<ShapedBody>& clumps) {
  std::vector<Felt> sums(clumps.size());
  for (std::size_t i = 0; i < clumps.size(); ++i)
    for (std::size_t j = 0; j < clumps.size(); ++j)
      if (i != j)
        for (const Point& a : beads(shapes, clumps[i]))
          for (const Point& b : beads(shapes, clumps[j])) {
            const Vec3 d = clumps[j].position + b.arm - clumps[i].position - a.arm;
            const Vec3 f = a.mass * b.mass / std::pow(d.norm(), 3) * d;
            sums[i].force += f;
            sums[i].torque += a.arm.cross(f);
          }
  return sums;
}

std::vector<Felt> differences(const std::vector<Felt>& some, const std::vector<Felt>& others) {
  std::vector<Felt> less;
  for (std::size_t b = 0; b < some.size(); ++b)
    less.push_back({some[b].force - others[b].force, some[b].torque - others[b].torque});
  return less;
}

struct Size {
  double force, torque;  ///< rms
};
Size size_of(const std::vector<Felt>& some) {
  Size squares{};
  for (const Felt& one : some) {
    squares.force += one.force.squaredNorm();
    squares.torque += one.torque.squaredNorm();
  }
  const auto count = static_cast<double>(some.size());
  return {std::sqrt(squares.force / count), std::sqrt(squares.torque / count)};
}

TEST(ShapeParts, add_up_to_the_clump_and_are_cut_where_spheres_meet) {
  for (const BodyShape& shape : {dumbbell(), boulder(), bead_pair(), bead_tripod()}) {
    double share = 0;
    Vec3 first = Vec3::Zero();
    for (const ShapePart& part : shape.parts) {
      share += part.share;
      first += part.share * part.centre;
    }
    EXPECT_NEAR(share, 1, 1e-13) << shape.name;
    EXPECT_LE(first.norm(), 1e-13) << shape.name;
  }
  // Beads have what their spheres have.
  const BodyShape beads = bead_tripod();
  ASSERT_EQ(beads.parts.size(), 4u);
  for (std::size_t k = 0; k < 4; ++k) {
    EXPECT_NEAR(beads.parts[k].share, (k == 0 ? 1 : 0.216) / 1.648, 2e-5);
    EXPECT_LE((beads.parts[k].centre - beads.spheres[k].at).norm(), 2e-5);
  }
  // Two balls with 1 and 0.8 that are 1.7 apart: caps of heights a - p and b - q are the other's.
  const double a = 1, b = 0.8, d = 1.7, p = (d * d + a * a - b * b) / (2 * d), q = d - p;
  const auto less_cap = [](double r, double plane) {
    const double height = r - plane;
    return 4 * pi / 3 * r * r * r - pi * height * height * (3 * r - height) / 3;
  };
  // Its first moment along the axis, of the ball less its cap: -pi (r^2 - plane^2)^2/4.
  const auto centre = [&](double r, double plane) {
    return -pi / 4 * std::pow(r * r - plane * plane, 2) / less_cap(r, plane);
  };
  const BodyShape two = dumbbell();
  const double unit = two.spheres[0].radius;  // of the ball of 1
  EXPECT_NEAR(two.parts[0].share, less_cap(a, p) / (less_cap(a, p) + less_cap(b, q)), 5e-5);
  const double apart = (two.parts[0].centre - two.parts[1].centre).norm() / unit;
  EXPECT_NEAR(apart, d - centre(a, p) - centre(b, q), 5e-5);
  // A sphere within another has no part.
  const std::array<ShapeSphere, 2> hidden{{{Vec3::Zero(), 1}, {Vec3(0.2, 0, 0), 0.5}}};
  EXPECT_EQ(make_shape("hidden", hidden).parts.size(), 1u);
}

TEST(NearClumps, attract_as_their_spheres_do) {
  const BodyShapes shapes = with_sphere({bead_pair(), bead_tripod()});
  const std::vector<ShapedBody> clumps = cloud_of_clumps(60, 12, 2, 0);
  const std::vector<Felt> exact = by_brute_force(shapes, clumps);
  const Size size = size_of(exact);
  for (const GravityMethod method : {GravityMethod::direct, GravityMethod::tree}) {
    Lab world = attracting(testing_world(), shapes, clumps, 1e3, method);
    for (const Felt& error : differences(felt(world), exact)) {
      // Of the shape's volume and places, beside the tree's error.
      EXPECT_LE(error.force.norm(), 2e-5 * size.force);
      EXPECT_LE(error.torque.norm(), 1e-4 * size.torque);
    }
  }
}

TEST(NearClumps, forces_that_are_left_out_fall_with_the_reach) {
  const BodyShapes shapes = with_sphere({bead_pair(), bead_tripod()});
  const std::vector<ShapedBody> clumps = cloud_of_clumps(200, 18, 2, 0);
  const std::vector<Felt> exact = by_brute_force(shapes, clumps);
  const Size size = size_of(exact);
  std::vector<Size> errors;  // relative
  for (const double near : {0.0, 1.0, 2.0, 4.0}) {
    Lab world = attracting(testing_world(), shapes, clumps, near);
    const Size error = size_of(differences(felt(world), exact));
    errors.push_back({error.force / size.force, error.torque / size.torque});
  }
  EXPECT_GT(errors[0].force, 0.01);
  EXPECT_NEAR(errors[0].torque, 1, 1e-12);  // centres make no torque
  for (std::size_t n = 1; n < errors.size(); ++n) {
    EXPECT_LT(errors[n].force, errors[n - 1].force);
    EXPECT_LT(errors[n].torque, errors[n - 1].torque);
  }
  EXPECT_LT(errors[2].force, errors[0].force / 5);
}

TEST(NearClumps, force_and_torque_are_the_slope_of_the_energy_where_they_fade_out) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  std::mt19937_64 random(3);
  const double near = 3, step = 1e-5;
  for (const double share : {0.4, 0.55, 0.7, 0.85, 0.97, 1.05}) {
    std::vector<ShapedBody> two(2);
    for (ShapedBody& one : two) one.orientation = random_turn(random);
    two[0].mass = 2;
    two[1].shape = share > 0.8 ? 2 : 0;
    two[1].radius = 1.5;
    two[1].position = share * near * 2.5 * random_vector(random).normalized();
    const auto energy = [&](const std::vector<ShapedBody>& bodies) {
      Lab world = attracting(alone(), shapes, bodies, near);
      evaluate_field(world);
      return world.kick.potential;
    };
    Lab world = attracting(alone(), shapes, two, near);
    const std::vector<Felt> got = felt(world);
    const double scale = got[0].force.norm();
    for (int k = 0; k < 3; ++k)
      for (std::size_t b = 0; b < 2; ++b) {
        std::vector<ShapedBody> low = two, high = two;
        low[b].position[k] -= step;
        high[b].position[k] += step;
        EXPECT_NEAR(got[b].force[k], -(energy(high) - energy(low)) / (2 * step), 1e-8 * scale)
            << share;
        low = high = two;
        low[b].orientation = turned_by(-step * Vec3::Unit(k), two[b].orientation);
        high[b].orientation = turned_by(step * Vec3::Unit(k), two[b].orientation);
        EXPECT_NEAR(got[b].torque[k], -(energy(high) - energy(low)) / (2 * step), 1e-8 * scale)
            << share;
      }
    const Vec3& apart = two[1].position;
    const double shaped = (got[0].force - 2 / std::pow(apart.norm(), 3) * apart).norm();
    if (share < 1) {
      EXPECT_GT(shaped, 1e-7 * scale) << share;
    } else {
      EXPECT_TRUE(got[0].torque.isZero(0));
      EXPECT_LE(shaped, 1e-12 * scale);
    }
  }
}

struct Kept {
  double energy;
  Vec3 momentum, angular;
  double unbooked;  ///< J: what bodies gained beyond the work that is told of kicks
};

/// Of a cloud after it has flown for `lasts` in so many steps.
Kept flown(const std::vector<ShapedBody>& clumps, double lasts, int steps) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  Lab world = attracting(testing_world(), shapes, clumps, 2);
  const double before = diagnose(world).kinetic;
  double work = 0;
  for (int k = 0; k < steps; ++k)
    work += nonsmooth_step(world, lasts / steps, solved_exactly(), 1).gravity_work;
  close_kick(world);
  work = world.comm.sum(work + work_of_kick(world));
  const Diagnostics sums = diagnose(world);
  return {sums.kinetic + world.kick.potential, sums.momentum, sums.angular_momentum,
          sums.kinetic - before - work};
}

TEST(NearClumps, that_fly_past_each_other_keep_energy_and_momenta) {
  std::vector<ShapedBody> clumps = cloud_of_clumps(24, 16, 3.5, 0.3);
  const Kept before = flown(clumps, 1e-9, 1);
  std::vector<double> errors;
  for (const int steps : {200, 400}) {
    const Kept after = flown(clumps, 1, steps);
    errors.push_back(after.energy - before.energy);
    EXPECT_LE((after.momentum - before.momentum).norm(), 1e-12);
    EXPECT_LE((after.angular - before.angular).norm(), 1e-11);
    EXPECT_LE(std::abs(after.unbooked), 1e-10 * std::abs(before.energy));
  }
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.3) << errors[0] << " " << errors[1];
  EXPECT_LE(std::abs(errors[1]), 1e-5 * std::abs(before.energy));
}

TEST(NearClumps, that_fall_together_close_their_books) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  std::vector<double> open;
  for (const int parts : {1, 2}) {
    Lab world = attracting(testing_world(), shapes, cloud_of_clumps(40, 9, 2.1, 0.1), 2);
    world.contact = ContactLaw{.friction = 0.5, .restitution = 0.3};
    evaluate_field(world);
    const double before = diagnose(world).kinetic + world.kick.potential;
    advance(world, 2e-3 / parts, 1500 * parts);
    close_kick(world);
    const Diagnostics sums = diagnose(world);
    EXPECT_GT(sums.dissipated, 0.5 * std::abs(before));
    open.push_back(std::abs(sums.kinetic + world.kick.potential + sums.dissipated -
                            sums.corrections - before) /
                   sums.dissipated);
  }
  for (const double share : open) EXPECT_LT(share, 1e-4);
}

TEST(NearClumps, go_on_with_the_same_bits) {
  for (const bool springs : {false, true}) {
    std::string text =
        springs ? heap_of_clumps({.material = "youngs_modulus = \"2 GPa\"\npoisson_ratio = 0.25\n",
                                  .restitution = "0.5",
                                  .tables = "[penalty]\nmodel = \"hertz\"\n",
                                  .phase = "method = \"penalty\"\n",
                                  .step = "50 us"})
                : heap_of_clumps({.restitution = "0", .step = "3 ms"});
    const std::size_t first = text.find("[gravity]"), end = text.find("[[groups]]");
    text.replace(first, end - first, "[gravity]\nmethod = \"direct\"\nconstant = 1e-4\n");
    expect_the_same_bits_after_a_stop(text, springs ? "near_springs" : "near_clumps",
                                      springs ? 0.3 : 0.9, springs ? 0.35 : 1.05);
  }
}

TEST(NearClumps, moon_librates_about_its_planet_as_the_closed_form_says) {
  std::vector<ShapeSphere> spheres;
  for (int k = -1; k <= 1; ++k) spheres.push_back({Vec3(2.0 * k, 0, 0), 1});
  const BodyShape rod = make_shape("rod", spheres);
  const double swing = 0.05, distance = 100;  // rad; m, with a moon of 1 m
  std::vector<ShapedBody> two(2);
  two[0] = {.shape = 0, .radius = 50, .mass = 1e6};
  two[1] = {.mass = 1e-6, .position = {distance, 0, 0}};
  const double n = std::sqrt(two[0].mass / std::pow(distance, 3));
  two[1].velocity = {0, n * distance, 0};
  two[1].spin = {0, 0, n};
  two[1].orientation = turned_by(Vec3(0, 0, swing), rod.as_listed);
  // Least moment along the rod, which points to the planet: omega^2 = 3 n^2 (B - A)/C.
  Vec3 moments = rod.inertia;
  std::sort(moments.data(), moments.data() + 3);
  const double omega = n * std::sqrt(3 * (moments[1] - moments[0]) / moments[2]);
  Lab world = attracting(testing_world(), with_sphere({rod}), two, 4);
  const auto angle = [&] {
    std::array<double, 6> at{};
    for (Index b = 0; b < world.bodies.owned; ++b) {
      if (world.bodies.id[b] == 1)
        Vec3::Map(&at[0]) =
            world.bodies.orientation[b] * (rod.as_listed.conjugate() * Vec3::UnitX());
      Vec3::Map(&at[3]) += (world.bodies.id[b] == 1 ? 1 : -1) * world.bodies.position[b];
    }
    world.comm.sum(at);
    return std::atan2(at[1], at[0]) - std::atan2(at[4], at[3]);
  };
  const int quarter = 200;
  const double h = pi / 2 / omega / quarter;
  EXPECT_NEAR(angle(), swing, 1e-12);
  advance(world, h, quarter);
  EXPECT_NEAR(angle(), 0, 0.01 * swing);
  advance(world, h, quarter);
  EXPECT_NEAR(angle(), -swing, 0.01 * swing);
}

}  // namespace
}  // namespace spall
