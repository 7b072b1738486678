// Bodies made of several spheres: shapes, free turning, lever arms, contacts, memory.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <random>

#include "clump_cases.hpp"
#include "clump_worlds.hpp"
#include "engine/free_turn.hpp"
#include "output/diagnostics.hpp"
#include "output/restart.hpp"
#include "output/snapshot.hpp"
#include "rigid/narrow_phase.hpp"
#include "run/simulation.hpp"
#include "scene/case.hpp"
#include "scene/impactor.hpp"
#include "scene/scene.hpp"
#include "solver/problem.hpp"
#include "solver/settings.hpp"
#include "spall/spall.hpp"
#include "testing.hpp"

namespace spall {
namespace {

// BodyShapes -------------------------------------------------------------------------------------

TEST(Shape, of_two_overlapping_spheres_has_the_lens_only_once) {
  for (const double d : {0.3, 1.2, 1.999}) {
    const Vec3 along = Vec3(0.3, -0.5, 0.8).normalized();
    const std::array<ShapeSphere, 2> two{{{Vec3(5, 6, 7), 1}, {Vec3(5, 6, 7) + d * along, 1}}};
    const BodyShape shape = make_shape("two", two);
    const double cap = 1 - d / 2, r = 1 + d / 2;
    const double volume = 2 * 4 * pi / 3 - 2 * pi * cap * cap * (3 - cap) / 3;
    EXPECT_NEAR(shape.volume * r * r * r / volume, 1, shape_error) << d;
    // Discs of radius^2 1 - (z - d/2)^2 for z from 0 to r, twice: about the axis and across it.
    const auto integral = [&](auto&& f) {  // Simpson's rule, of polynomials of degree 4: exact
      const int n = 2000;
      double sum = 0;
      for (int k = 0; k <= n; ++k)
        sum += (k == 0 || k == n ? 1 : k % 2 == 1 ? 4 : 2) * f(r * k / n);
      return 2 * sum * r / (3 * n);
    };
    const auto disc = [&](double z) { return pi * (1 - (z - d / 2) * (z - d / 2)); };
    const double about = integral([&](double z) { return disc(z) * disc(z) / (2 * pi); });
    const double across =
        integral([&](double z) { return disc(z) * disc(z) / (4 * pi) + disc(z) * z * z; });
    EXPECT_NEAR(shape.inertia[0] / (about / volume / (r * r)), 1, 2 * shape_error) << d;
    for (int k : {1, 2})
      EXPECT_NEAR(shape.inertia[k] / (across / volume / (r * r)), 1, 2 * shape_error) << d;
  }
}

TEST(Shape, of_two_halves_has_the_volume_and_inertia_of_both) {
  std::mt19937_64 random(5);
  std::vector<ShapeSphere> half{{Vec3::Zero(), 1}};
  for (int k = 0; k < 4; ++k) half.push_back({random_vector(random), 0.6});
  std::vector<ShapeSphere> other = half, both = half;
  double reach = 0;
  for (const ShapeSphere& s : half) reach = std::max(reach, s.at.x() + s.radius);
  for (ShapeSphere& s : other) {  // mirrored: they touch in one point
    s.at.x() = 2 * reach - s.at.x();
    both.push_back(s);
  }
  const BodyShape one = make_shape("half", half), whole = make_shape("whole", both);
  // In units of the list: radius of the shape from a sphere that both have.
  const double r = 1 / one.spheres[0].radius, R = 1 / whole.spheres[0].radius;
  EXPECT_NEAR(whole.volume * R * R * R / (2 * one.volume * r * r * r), 1, 2 * shape_error);
  const auto listed = [](const BodyShape& shape, double radius) -> Mat3 {  // m = volume
    return shape.volume * std::pow(radius, 5) * turned_tensor(shape.as_listed, shape.inertia);
  };
  // Of the half about the point where both touch, by the parallel axes.
  const Vec3 centre = -r * (one.as_listed * one.spheres[0].at);
  const Vec3 to(reach - centre.x(), 0, 0);
  const double mass = one.volume * r * r * r;
  Mat3 sum = Mat3::Zero();
  for (double side : {1.0, -1.0}) {
    Mat3 mirror = Mat3::Identity();
    mirror(0, 0) = side;
    sum += mirror * listed(one, r) * mirror +
           mass * (to.squaredNorm() * Mat3::Identity() - to * to.transpose());
  }
  EXPECT_LE((listed(whole, R) - sum).norm(), 1e-4 * sum.norm());
}

TEST(Shape, ellipsoid_is_filled_from_inside_and_the_better_the_more_spheres_there_are) {
  if (testing_world().size > 1) return;  // one rank does it
  const Vec3 axes(2, std::sqrt(2.0), 1);
  double before = 0;
  for (int count : {1, 3, 7, 15, 30}) {
    const auto spheres = fill_ellipsoid(axes, count);
    ASSERT_EQ(std::ssize(spheres), count);
    std::mt19937_64 random(3);
    for (const ShapeSphere& s : spheres)
      for (int k = 0; k < 200; ++k) {
        const Vec3 x = s.at + s.radius * random_vector(random).normalized();
        EXPECT_LE(x.cwiseQuotient(axes).squaredNorm(), 1 + 1e-12);
      }
    const BodyShape shape = make_shape("boulder", spheres);
    const double r = spheres[0].radius / shape.spheres[0].radius;
    const double filled = shape.volume * r * r * r / (4 * pi / 3 * axes.prod());
    EXPECT_GT(filled, before) << count;
    EXPECT_LT(filled, 1) << count;
    before = filled;
  }
  EXPECT_GT(before, 0.9);
  EXPECT_EQ(fill_ellipsoid(Vec3::Ones(), 5).size(), 1u) << "all of them are the ball";
  const auto small = fill_ellipsoid(axes, 7), large = fill_ellipsoid(8 * axes, 7);
  for (std::size_t k = 0; k < small.size(); ++k) {
    EXPECT_EQ(large[k].at, 8 * small[k].at);
    EXPECT_EQ(large[k].radius, 8 * small[k].radius);
  }
}

TEST(Shape, of_spheres_that_touch_to_round_off_hangs_together) {
  for (const double at : {0.6, 0.1, 1e3}) {
    const std::array<ShapeSphere, 2> two{{{Vec3(at, 0, 0), 0.1}, {Vec3(at + 0.2, 0, 0), 0.1}}};
    EXPECT_EQ(complaint_of([&] { make_shape("chain", two); }), "") << at;
  }
}

TEST(Shape, that_does_not_hang_together_is_refused) {
  const std::array<ShapeSphere, 2> two{{{Vec3::Zero(), 1}, {Vec3(2.01, 0, 0), 1}}};
  EXPECT_EQ(complaint_of([&] { make_shape("pair", two); }),
            "shape pair: its spheres do not hang together");
}

// Free turning -------------------------------------------------------------------------------

Vec3 momentum_of(const Vec3& inertia, const Turn& turn) {
  return turned_tensor(turn.orientation, inertia) * turn.angular_velocity;
}

TEST(FreeTurn, keeps_angular_momentum_to_round_off_and_energy_without_drift) {
  const Vec3 inertia(0.2, 0.35, 0.45);
  Turn turn{Quaternion::Identity(), Vec3(0.02, 1, 0.01)};
  const Vec3 momentum = momentum_of(inertia, turn);
  const double energy = momentum.dot(turn.angular_velocity) / 2;
  const double h = 0.05;
  double first = 0, last = 0;  // largest error of the energy, in each half
  constexpr int steps = 100'000;
  for (int k = 0; k < steps; ++k) {
    turn = turn_freely(inertia, turn, h);
    const double now = momentum_of(inertia, turn).dot(turn.angular_velocity) / 2;
    double& most = k < steps / 2 ? first : last;
    most = std::max(most, std::abs(now / energy - 1));
  }
  // Each step rounds some ten times; the roundings of 1e5 steps add up like a random walk.
  EXPECT_LE((momentum_of(inertia, turn) - momentum).norm(), 1e-11 * momentum.norm());
  EXPECT_LT(first, h * h / 10);
  EXPECT_LT(last, 1.1 * first);
}

/// Euler's equations in body axes, by Runge and Kutta's method of order 4 with short steps.
Vec3 by_euler(const Vec3& inertia, Vec3 omega, double t) {
  const int steps = 40'000;
  const double h = t / steps;
  const auto rate = [&](const Vec3& w) -> Vec3 {
    return -w.cross(inertia.cwiseProduct(w)).cwiseQuotient(inertia);
  };
  for (int k = 0; k < steps; ++k) {
    const Vec3 a = rate(omega), b = rate(omega + h / 2 * a), c = rate(omega + h / 2 * b),
               d = rate(omega + h * c);
    omega += h / 6 * (a + 2 * b + 2 * c + d);
  }
  return omega;
}

TEST(FreeTurn, flips_about_the_middle_axis_as_eulers_equations_do_to_second_order) {
  const Vec3 inertia(0.2, 0.35, 0.45), omega(1e-3, 1, 2e-3);
  const double t = 25;
  const Vec3 exact = by_euler(inertia, omega, t);
  ASSERT_LT(exact.y(), -0.9) << "it has turned over";
  std::vector<double> errors;
  for (int steps : {500, 1000, 2000}) {
    std::mt19937_64 random(1);
    Turn turn{random_turn(random), {}};
    turn.angular_velocity = turn.orientation * omega;
    for (int k = 0; k < steps; ++k) turn = turn_freely(inertia, turn, t / steps);
    errors.push_back((turn.orientation.conjugate() * turn.angular_velocity - exact).norm());
  }
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.2);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 2, 0.1);
  EXPECT_LT(errors[2], 1e-3);
}

// The contact problem ------------------------------------------------------------------------

/// A contact of two bodies with arms and inertias at random, or of one with the ground.
struct RandomContact {
  std::vector<double> inverse_mass{0.7, 0.2};
  std::vector<Mat3> turning;
  std::vector<Index> i{0}, j;
  std::vector<Vec3> normal, arm_i, arm_j, velocity;
  std::vector<double> kappa{1}, friction, none{0};

  RandomContact(std::mt19937_64& random, bool on_ground, double mu)
      : j{on_ground ? ground : 1}, friction{mu} {
    for (double w : inverse_mass) {
      const Vec3 factor = Vec3(2, 3, 4) + random_vector(random);
      turning.push_back(w * turned_tensor(random_turn(random), factor));
    }
    normal.push_back(random_vector(random).normalized());
    arm_i.push_back(random_vector(random));
    arm_j.push_back(on_ground ? Vec3(Vec3::Zero()) : random_vector(random));
    velocity.push_back(random_vector(random));
    if (velocity[0].dot(normal[0]) > 0) velocity[0] = -velocity[0];
  }
  ContactProblem view() const {
    return {.inverse_mass = inverse_mass,
            .i = i,
            .j = j,
            .normal = normal,
            .kappa = kappa,
            .arm_i = arm_i,
            .arm_j = arm_j,
            .turning = turning,
            .free_velocity = velocity,
            .friction = friction,
            .cohesive_impulse = none};
  }
};

TEST(Levers, metric_is_nowhere_below_the_block_and_at_most_twice_it) {
  std::mt19937_64 random(11);
  for (int k = 0; k < 500; ++k) {
    const RandomContact contact(random, k % 3 == 0, 0);
    const Mat3 block = delassus_block(contact.view(), 0);
    EXPECT_LE((block - block.transpose()).norm(), 1e-14 * block.norm());
    const Vec3& n = contact.normal[0];
    const ContactMetric s = bound_of(block, n);
    const Mat3 scale = n * n.transpose() / std::sqrt(s.a_n) +
                       (Mat3::Identity() - n * n.transpose()) / std::sqrt(s.a_t);
    const auto values = Eigen::SelfAdjointEigenSolver<Mat3>(scale * block * scale).eigenvalues();
    EXPECT_LE(values.maxCoeff(), 1 + 1e-12);
    EXPECT_GE(values.maxCoeff(), 0.5);
    EXPECT_GT(values.minCoeff(), 0);
  }
}

TEST(Levers, metric_of_spheres_is_their_block) {
  std::mt19937_64 random(2);
  RandomContact spheres(random, false, 0);
  for (int b : {0, 1})
    spheres.turning[b] = spheres.inverse_mass[b] / sphere_inertia * Mat3::Identity();
  spheres.arm_i[0] = 0.9 * spheres.normal[0];
  spheres.arm_j[0] = -0.9 * spheres.normal[0];
  const ContactMetric s = bound_of(delassus_block(spheres.view(), 0), spheres.normal[0]);
  EXPECT_NEAR(s.a_n, 0.9, 1e-14);
  EXPECT_NEAR(s.a_t, 0.9 * (1 + 0.81 / sphere_inertia), 1e-14);
}

TEST(Levers, one_contact_sticks_or_slips_as_its_block_says_by_every_method) {
  std::mt19937_64 random(4);
  const Ghosts ghosts(alone(), 2, {});
  for (const SolverMethod method :
       {SolverMethod::accelerated, SolverMethod::apgd, SolverMethod::barzilai_borwein})
    for (int k = 0; k < 20; ++k) {
      const RandomContact contact(random, k % 3 == 0, 100);
      const Mat3 block = delassus_block(contact.view(), 0);
      const Vec3 sticks = -block.ldlt().solve(contact.velocity[0]);
      if (sticks.dot(contact.normal[0]) <= 0.02 * sticks.norm()) continue;
      std::vector<Vec3> impulse{Vec3::Zero()};
      const SolverResult result = solve(contact.view(), ghosts,
                                        {.method = method,
                                         .friction = FrictionModel::convex,
                                         .tolerance = 1e-10,
                                         .max_iterations = 20000,
                                         .prox = 0},
                                        impulse);
      EXPECT_LE((impulse[0] - sticks).norm(), 1e-8 * sticks.norm());
      // The changes of the bodies are those that the impulse gives them.
      const Vec3 ds = contact.turning[0] * (-contact.arm_i[0].cross(impulse[0]));
      EXPECT_LE((Eigen::Map<const Vec3>(result.change[0].angular) - ds).norm(), 1e-12 * ds.norm());
      EXPECT_LE(
          (Eigen::Map<const Vec3>(result.change[0].linear) + contact.inverse_mass[0] * impulse[0])
              .norm(),
          1e-12 * impulse[0].norm());
    }
  for (int k = 0; k < 20; ++k) {  // without friction: along the normal alone
    RandomContact contact(random, k % 2 == 0, 0);
    const Vec3& n = contact.normal[0];
    std::vector<Vec3> impulse{Vec3::Zero()};
    solve(contact.view(), ghosts, solved_exactly(), impulse);
    const double p = -contact.velocity[0].dot(n) / n.dot(delassus_block(contact.view(), 0) * n);
    EXPECT_LE((impulse[0] - p * n).norm(), 1e-9 * p);
    contact.velocity[0] = n;  // it parts straight
    for (const FrictionModel model : {FrictionModel::convex, FrictionModel::coulomb}) {
      impulse[0].setZero();
      solve(contact.view(), ghosts, {.friction = model}, impulse);
      EXPECT_TRUE(impulse[0].isZero(0));
    }
  }
}

// Worlds -------------------------------------------------------------------------------------

TEST(Clump, rod_that_falls_on_its_end_gets_the_impulse_of_the_closed_form) {
  const std::array<ShapeSphere, 3> spheres{
      {{Vec3(2, 0, 0), 0.5}, {Vec3(0.8, 0, 0), 1.0}, {Vec3(-1, 0, 0), 1.4}}};
  const BodyShape rod = make_shape("rod", spheres);
  const double v = 3, h = 1e-3, m = 2;
  for (double e : {0.0, 0.5})
    for (double tilt : {0.5, 1.0, 1.4}) {
      // The thin end is lowest, by `tilt` from the horizontal.
      ShapedBody clump{.mass = m, .velocity = {0, 0, -v}};
      clump.orientation = turned_by(Vec3(0, tilt, 0), rod.as_listed);
      const ShapeSphere& end = rod.spheres[0];
      const Vec3 arm = clump.orientation * end.at - end.radius * Vec3::UnitZ();
      clump.position = {0, 0, -arm.z() + 0.4 * h * v};
      Lab world = make_world(alone(), with_sphere({rod}), {clump}, {.restitution = e});
      world.planes = {floor_plane};
      const Mat3 inverse = turned_tensor(clump.orientation, rod.inertia.cwiseInverse()) / m;
      const Vec3 n = Vec3::UnitZ();
      // With e = 0 the gap, .4 of the way, closes in this step first.
      const double given = e > 0 ? (1 + e) * v : v - 0.4 * v;
      const double p = given / (1 / m + arm.cross(n).dot(inverse * arm.cross(n)));
      advance(world, h, 1);
      const Sphere after = spheres_of(world)[0];
      EXPECT_NEAR(after.velocity.z(), -v + p / m, 1e-8 * v) << e << " " << tilt;
      // The turn of the first step is free, of a spin that is an axis of the rod.
      EXPECT_LE((after.spin - inverse * arm.cross(p * n)).norm(), 1e-7 * v) << e << " " << tilt;
    }
}

TEST(Clump, tripod_at_rest_on_a_plane_stays) {
  std::vector<ShapeSphere> spheres{{Vec3(0.1, 0.05, 1), 0.9}};
  for (int k = 0; k < 3; ++k)
    spheres.push_back({Vec3(std::cos(2 * pi * k / 3), std::sin(2 * pi * k / 3), 0), 0.7});
  const BodyShape tripod = make_shape("tripod", spheres);
  ShapedBody clump{.radius = 0.7 / tripod.spheres[1].radius, .orientation = tripod.as_listed};
  const Vec3 foot = clump.radius * (clump.orientation * tripod.spheres[1].at);
  clump.position = {0, 0, 0.7 - foot.z()};
  Lab world = make_world(alone(), with_sphere({tripod}), {clump}, {.friction = 0.4});
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -9.8};
  const double h = 1e-3;
  advance(world, h, 500);
  const Sphere after = spheres_of(world)[0];
  EXPECT_LE(after.velocity.norm() + after.spin.norm(), 1e-7 * 9.8 * h);
  EXPECT_LE((after.position - clump.position).norm(), 1e-7);
  EXPECT_NEAR(world.bodies.orientation[0].angularDistance(clump.orientation), 0, 1e-6);
}

TEST(Clump, box_of_eight_spheres_slides_beyond_the_angle_of_friction_and_stays_below) {
  std::vector<ShapeSphere> spheres;
  for (int k = 0; k < 8; ++k)
    spheres.push_back({Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1), 1});
  const BodyShape box = make_shape("box", spheres);
  const double mu = 0.3, g = 9.8, h = 1e-3;
  const int steps = 100;
  for (double slope : {0.2, 0.29, 0.31, 0.45}) {
    ShapedBody clump{.radius = 1 / box.spheres[0].radius, .position = {0, 0, 2}};
    clump.orientation = box.as_listed;
    Lab world = make_world(alone(), with_sphere({box}), {clump}, {.friction = mu});
    world.planes = {floor_plane};
    const double theta = std::atan(slope);
    world.uniform_gravity = {g * std::sin(theta), 0, -g * std::cos(theta)};
    advance(world, h, steps);
    const Sphere after = spheres_of(world)[0];
    const double a = std::max(0.0, g * (std::sin(theta) - mu * std::cos(theta)));
    const double t = (steps - 0.5) * h;  // leapfrog: between kicks
    EXPECT_NEAR(after.velocity.x(), a * t, 1e-6 * g * t) << slope;
    EXPECT_LE(after.spin.norm(), 1e-5 * g * t) << slope;
    EXPECT_NEAR(after.position.z(), 2, 1e-3) << slope;
  }
}

TEST(Clump, energy_that_an_eccentric_hit_gives_is_counted) {
  std::vector<ShapeSphere> spheres;
  for (int k = 0; k < 7; ++k) spheres.push_back({Vec3(1.5 * k, 0, 0), 1});
  const BodyShape rod = make_shape("rod", spheres);
  struct Hit {
    double gained, change;  ///< J, as it is counted, and of the kinetic energy
  };
  const auto hit = [&](double mu, double e, bool gravity) {
    ShapedBody clump{.radius = 1 / rod.spheres[0].radius, .velocity = {-1, 0, -1}};
    clump.orientation = turned_by(Vec3(0, 1, 0), rod.as_listed);
    double lowest = 0;
    for (const ShapeSphere& one : rod.spheres)
      lowest = std::min(lowest, clump.radius * (clump.orientation * one.at).z());
    clump.position = {0, 0, 1.0005 - lowest};
    Lab world = make_world(testing_world(), with_sphere({rod}),
                           {clump,
                            {.shape = 0, .position = {50, 0, 50}},
                            {.shape = 0, .position = {60, 0, 50}},
                            {.shape = 0, .position = {70, 0, 50}}},
                           {.friction = mu, .restitution = e});
    world.planes = {floor_plane};
    if (gravity) world.uniform_gravity = {0, 0, -1e-3};
    const double before = diagnose(world).kinetic;
    advance(world, 1e-3, 3);
    const Diagnostics after = diagnose(world);
    return Hit{after.gained, after.kinetic - before};
  };
  // The tip slips backwards after the hit, not forwards as before: friction then works along its
  // mean motion.
  const Hit gains = hit(0.1, 1, false);
  EXPECT_GT(gains.change, 0.01);
  EXPECT_NEAR(gains.gained / gains.change, 1, 1e-9);
  for (const bool gravity : {false, true}) {
    EXPECT_GT(hit(0.1, 1, gravity).gained, 0.01);
    EXPECT_EQ(hit(0.1, 0, gravity).gained, 0) << "without restitution";
    EXPECT_EQ(hit(0, 1, gravity).gained, 0) << "without friction";
  }
}

TEST(Clump, clouds_that_overlap_keep_their_momenta_as_they_part) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  Lab world = make_world(testing_world(), shapes, cloud_of_clumps(60, 5.5, 1.1, 1),
                         {.friction = 0.5, .restitution = 0.3});
  world.gravity = {.method = GravityMethod::direct, .constant = 1e-2};
  world.rigid.solver = {.tolerance = 1e-6, .max_iterations = 1000};
  const Diagnostics before = diagnose(world);
  std::int64_t contacts = 0;
  double first_overlap = 0, last_overlap = 0;
  for (int k = 0; k < 40; ++k) {
    const StepReport report = nonsmooth_step(world, world.rigid, {.h = 0.01, .most_steps = 4});
    contacts += report.contacts;
    last_overlap = world.comm.max(report.overlap);
    if (k == 0) first_overlap = last_overlap;
    const Diagnostics now = diagnose(world);
    EXPECT_LE((now.momentum - before.momentum).norm(), 1e-12 * now.momentum_scale) << k;
    EXPECT_LE((now.angular_momentum - before.angular_momentum).norm(),
              1e-12 * before.angular_momentum_scale)
        << k;
  }
  EXPECT_GT(world.comm.sum(contacts), 1000);
  EXPECT_GT(first_overlap, 0.3);
  EXPECT_LT(last_overlap, 0.1 * first_overlap);
}

TEST(Clump, clouds_move_alike_on_any_number_of_ranks) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  const auto clumps = cloud_of_clumps(40, 9, 2.65, 4);
  const auto run = [&](const Comm& comm) {
    Lab world = make_world(comm, shapes, clumps, {.friction = 0.5, .restitution = 0.3});
    advance(world, 0.02, 40);
    return spheres_of(world);
  };
  const auto together = run(testing_world()), by_one = run(alone());
  double most = 0, hit = 0;
  for (std::size_t k = 0; k < together.size(); ++k) {
    most = std::max(most, (together[k].velocity - by_one[k].velocity).norm());
    hit += (by_one[k].velocity - clumps[k].velocity).norm() > 0.1 ? 1 : 0;
  }
  EXPECT_GT(hit, 10);
  EXPECT_LT(most, 4e-6);  // the solver's 1e-10, that later hits magnify
}

TEST(Clump, without_friction_every_method_moves_them_alike) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  const auto clumps = cloud_of_clumps(20, 7, 2.65, 4);
  std::vector<std::vector<Sphere>> after;
  for (const SolverMethod method :
       {SolverMethod::accelerated, SolverMethod::apgd, SolverMethod::barzilai_borwein}) {
    Lab world = make_world(testing_world(), shapes, clumps, {.restitution = 0.5});
    SolverSettings solver = solved_exactly();
    solver.method = method;
    advance(world, 0.02, 20, solver);
    after.push_back(spheres_of(world));
  }
  double hit = 0;
  for (std::size_t k = 0; k < clumps.size(); ++k) {
    hit += (after[0][k].velocity - clumps[k].velocity).norm() > 0.1 ? 1 : 0;
    for (int method : {1, 2})
      EXPECT_LE((after[method][k].velocity - after[0][k].velocity).norm(), 1e-5) << k;
  }
  EXPECT_GT(hit, 3);
}

TEST(Clump, general_contacts_of_spheres_move_them_as_contacts_of_spheres_do) {
  auto clumps = cloud_of_clumps(30, 9, 2.7, 1);
  for (ShapedBody& clump : clumps) clump.shape = 0;
  const auto run = [&](const BodyShapes& shapes) {
    Lab world = make_world(alone(), shapes, clumps, {.friction = 0.5, .restitution = 0.3});
    advance(world, 0.05, 20);
    return std::pair(spheres_of(world), diagnose(world).kinetic);
  };
  const auto [spheres, kinetic] = run({});
  const auto [general, other] = run(with_sphere({dumbbell()}));
  EXPECT_NEAR(other, kinetic, 1e-6 * kinetic);
  double fastest = 0;
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    fastest = std::max(fastest, (spheres[k].velocity - clumps[k].velocity).norm());
    EXPECT_LE((general[k].velocity - spheres[k].velocity).norm(), 1e-6) << k;
    EXPECT_LE((general[k].spin - spheres[k].spin).norm(), 1e-6) << k;
  }
  EXPECT_GT(fastest, 0.1) << "some have met";
}

// Memory -------------------------------------------------------------------------------------

const std::string heap = heap_of_clumps({.restitution = "0", .step = "3 ms"});

Simulation simulation_of(const std::string& text) {
  return Simulation(testing_world(), Scene(std::make_shared<Case>(parse_case(text, "heap.toml"))));
}

/// Where contacts are and what they carried, of all ranks, each once.
std::vector<std::array<double, 7>> remembered(const ContactMemory& memory) {
  std::vector<double> rows;
  for (std::size_t m = 0; m < memory.size(); ++m) {
    const auto [of_i, of_j] = memory.spheres_of(m);
    const Vec3& p = memory.impulse[m];
    rows.insert(rows.end(), {double(memory.i[m]), double(memory.j[m]), double(of_i), double(of_j),
                             p.x(), p.y(), p.z()});
  }
  const auto all = testing_world().all_gather(rows);
  std::vector<std::array<double, 7>> sorted(all.size() / 7);
  for (std::size_t k = 0; k < all.size(); ++k) sorted[k / 7][k % 7] = all[k];
  std::ranges::sort(sorted);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  return sorted;
}

TEST(Memory, impulses_of_spheres_stay_through_a_new_cut_and_a_search) {
  Simulation simulation = simulation_of(heap);
  simulation.run_until(1.5);
  World world = simulation.world();
  auto rigid = dynamic_cast<const Rigid*>(&simulation.engine());
  ASSERT_NE(rigid, nullptr);
  const PairMemory memory = rigid->remember(world);
  const auto before = remembered(memory.contacts);
  ASSERT_GT(before.size(), 12u);
  const auto several = std::ranges::adjacent_find(
      before, [](const auto& a, const auto& b) { return a[0] == b[0] && a[1] == b[1]; });
  ASSERT_NE(several, before.end()) << "some pairs have several contacts";
  Rigid anew;
  anew.restart_pairs(world, memory);
  EXPECT_EQ(&*anew.neighbours.carried, &*memory.contacts) << "one copy";
  update_neighbours(world.comm, world.bodies, world.planes, 3e-3, 0, anew.neighbours);
  const auto after = remembered(anew.remember(world).contacts);
  EXPECT_EQ(before, after);
}

TEST(Memory, a_run_of_clumps_that_is_stopped_goes_on_with_the_same_bits) {
  expect_the_same_bits_after_a_stop(heap, "clumps", 0.6, 0.75);
}

TEST(Memory, of_shapes_that_the_case_does_not_have_is_refused) {
  const Scene scene(std::make_shared<Case>(parse_case(heap, "heap.toml")));
  RestartState state = Simulation(testing_world(), scene).save();
  const auto complaint = [&] {
    return complaint_of([&] { Simulation(testing_world(), scene, state); });
  };
  EXPECT_EQ(complaint(), "");
  const std::string told =
      "heap.toml: bodies of the restart file have other shapes than [shapes] and packings tell";
  const std::int32_t own = state.bodies.shape[0];
  for (const int wrong : {-1, 3}) {
    if (testing_world().rank == 0) state.bodies.shape[0] = wrong;
    EXPECT_EQ(complaint(), told) << wrong;
  }
  state.bodies.shape[0] = own;
  set_fields(state.bodies, FieldSet{Field::angular_velocity, Field::acceleration});
  EXPECT_EQ(complaint(), told);
}

// Cases --------------------------------------------------------------------------------------

TEST(Case, orientations_are_the_same_on_any_number_of_ranks) {
  const Case scene = parse_case(heap, "heap.toml");
  const auto by_id = [&](const Comm& comm) {
    const Bodies bodies = make_bodies(scene, comm);
    std::vector<double> rows;
    for (Index b = 0; b < bodies.owned; ++b) {
      const auto q = bodies.orientation[b].coeffs();
      rows.insert(rows.end(), {double(bodies.id[b]), double(bodies.shape[b]), bodies.mass[b], q[0],
                               q[1], q[2], q[3]});
    }
    return comm.all_gather(rows);
  };
  const auto all = by_id(testing_world());
  EXPECT_EQ(all, by_id(alone()));
  double turned = 0;
  for (std::size_t k = 7; k < 12 * 7; k += 7) turned += std::abs(all[k + 3] - all[3]);
  EXPECT_GT(turned, 1) << "each has its own";
}

TEST(Case, mass_is_that_of_the_union) {
  const Case scene = parse_case(heap, "heap.toml");
  ASSERT_EQ(scene.shapes.size(), 3u);
  const Bodies bodies = make_bodies(scene, alone());
  EXPECT_EQ(bodies.shape[0], 1);
  EXPECT_NEAR(bodies.mass[0], 2000 * scene.shapes[1].volume * 0.125, 1e-9);
  EXPECT_NEAR(bodies.mass[23], 2000 * 4 * pi / 3 * 0.064, 1e-9);
}

TEST(Case, bodies_draw_one_of_several_shapes_the_same_on_any_number_of_ranks) {
  std::string text = heap;
  const std::string one = "radius = 0.5, count = 12, shape = \"boulder\"";
  const auto at = text.find(one);
  const auto with = [&](const std::string& keys) {
    return std::string(text).replace(at, one.size(), keys);
  };
  const std::string several = "shapes = [\"boulder\", \"boulder\", \"dumbbell\"]";
  const Case scene = parse_case(with("radius = 0.1, count = 900, " + several), "heap.toml");
  const auto by_id = [&](const Comm& comm) {
    const Bodies bodies = make_bodies(scene, comm);
    std::vector<double> rows;
    for (Index b = 0; b < bodies.owned; ++b)
      rows.insert(rows.end(), {double(bodies.id[b]), double(bodies.shape[b]), bodies.mass[b],
                               bodies.orientation[b].x()});
    return comm.all_gather(rows);
  };
  const auto all = by_id(testing_world());
  EXPECT_EQ(all, by_id(alone()));
  double mass = 0;
  std::array<int, 3> count{};
  for (std::size_t k = 0; k < 900; ++k) {
    const auto shape = static_cast<std::size_t>(all[4 * k + 1]);
    ++count.at(shape);
    EXPECT_NEAR(all[4 * k + 2] / (2000 * scene.shapes[shape].volume * 1e-3), 1, 1e-12) << k;
    mass += all[4 * k + 2];
  }
  EXPECT_EQ(count[0], 0);
  EXPECT_NEAR(count[1], 600, 3 * std::sqrt(900 * 2 / 9.0));
  EXPECT_NEAR(measure_groups(scene)[0].mass / mass, 1, 1e-12);
  const auto complaint = [&](const std::string& keys) {
    return complaint_of([&] { parse_case(with("radius = 0.1, count = 9, " + keys), "heap.toml"); });
  };
  EXPECT_NE(complaint(several + ", shape = \"boulder\"").find("is given beside shapes"),
            std::string::npos);
  EXPECT_NE(complaint("shapes = [\"boulder\", \"rock\"]").find("\"rock\" is not in [shapes]"),
            std::string::npos);
}

TEST(Case, a_shape_of_one_sphere_gives_the_bits_of_spheres) {
  const auto run = [](const std::string& shape) {
    std::string text = heap;
    for (const std::string name : {"\"boulder\"", "\"dumbbell\""}) {
      const auto at = text.find(", shape = " + name);
      text.replace(at, 10 + name.size(), shape);
    }
    text += "[shapes.ball]\nspheres = [{at = [1, 2, 3], radius = 4}]\n";
    Simulation simulation = simulation_of(text);
    simulation.run_until(0.8);
    EXPECT_FALSE(simulation.bodies().has(Field::orientation));
    return std::pair(simulation.bodies().position, simulation.bodies().angular_velocity);
  };
  EXPECT_EQ(run(", shape = \"ball\""), run(""));
}

TEST(Case, a_shape_of_a_file_needs_the_file_no_more_after_a_restart) {
  const Comm comm = testing_world();
  const std::filesystem::path folder =
      std::filesystem::path(::testing::TempDir()) / ("shape_" + std::to_string(comm.size));
  if (comm.rank == 0) {
    std::filesystem::create_directories(folder);
    std::ofstream(folder / "rock.obj") << "v 2 0 0\nv -2 0 0\nv 0 1 0\nv 0 -1 0\nv 0 0 1\n"
                                          "v 0 0 -1\nf 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\n"
                                          "f 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";
    std::string text = heap;
    const std::string axes = "axes = [2, 1.414, 1]";
    text.replace(text.find(axes), axes.size(), "file = \"rock.obj\"");
    std::ofstream(folder / "case.toml") << text;
  }
  comm.any(true);
  const std::string file = (folder / "case.toml").string();
  const Case scene = read_case(file, {}, InputFiles(comm));
  ASSERT_EQ(scene.shapes[1].spheres.size(), 5u);
  EXPECT_GT(scene.shapes[1].inertia.maxCoeff(), 1.5 * scene.shapes[1].inertia.minCoeff());
  const auto complaint = [&](const std::string& change) {
    return complaint_of([&] { read_case(file, {change}, InputFiles(comm)); });
  };
  const std::string both = "shapes.boulder.spheres=[{at = [0, 0, 0], radius = 1}]";
  EXPECT_NE(complaint(both).find("case.toml:6: shapes.boulder.file: spheres are listed too"),
            std::string::npos)
      << complaint(both);
  EXPECT_NE(complaint("shapes.boulder.axes=[1, 1, 1]").find("shapes.boulder.axes"),
            std::string::npos);
  EXPECT_NE(complaint("shapes.boulder.count=0").find("shapes.boulder.count"), std::string::npos);
  EXPECT_NE(complaint("shapes.boulder.file=\"no.obj\"").find("no.obj"), std::string::npos);
  comm.any(true);
  if (comm.rank == 0) std::filesystem::remove(folder / "rock.obj");
  comm.any(true);
  const Case again = parse_case(scene.text, file, {}, Groups::needed, {}, scene.constants);
  ASSERT_EQ(again.shapes.size(), scene.shapes.size());
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_EQ(again.shapes[1].spheres[k].at, scene.shapes[1].spheres[k].at);
    EXPECT_EQ(again.shapes[1].spheres[k].radius, scene.shapes[1].spheres[k].radius);
  }
  // Nor does it where an override has named the file.
  const std::vector<std::string> named = {"shapes.boulder.file=\"rock.obj\""};
  const Case once_more = parse_case(scene.text, file, named, Groups::needed, {}, scene.constants);
  EXPECT_EQ(once_more.shapes[1].spheres.size(), 5u);
}

TEST(Case, a_single_clump_lies_as_it_is_asked_to) {
  const std::string text = R"(
[materials.rock]
density = 1000
[shapes.rod]
spheres = [{at = [0, 0, 0], radius = 1}, {at = [1, 0, 0], radius = 1}, {at = [2, 0, 0], radius = 1}]
[[groups]]
name = "rod"
material = "rock"
volume = {radius = 2, center = [0, 0, 5]}
packing = {kind = "single", shape = "rod", rotation = [0, "90 deg", 0]}
[[phases]]
name = "rest"
step = 1
duration = 1
)";
  const Case scene = parse_case(text, "rod.toml");
  const Bodies bodies = make_bodies(scene, alone());
  const Vec3 end = 2 * (bodies.orientation[0] * scene.shapes[1].spheres[2].at);
  EXPECT_LE((end - Vec3(0, 0, -1)).norm(), 1e-5) << end.transpose();
}

TEST(Case, an_impactor_is_aimed_at_the_spheres_of_a_clump) {
  const std::array<ShapeSphere, 3> three{
      {{Vec3(-4, 0, 0), 1}, {Vec3(0, 0, 0), 3.5}, {Vec3(4, 0, 0), 1}}};
  const BodyShape shape = make_shape("rod", three);
  ShapedBody clump{.radius = 5, .position = {1, 2, 3}, .orientation = shape.as_listed};
  clump.orientation = turned_by(Vec3(0, 0, pi / 2), clump.orientation);  // along y now
  const Lab world = make_world(testing_world(), with_sphere({shape}),
                               {clump,
                                {.shape = 0, .mass = 1e-9, .position = {1, 2, -300}},
                                {.shape = 0, .mass = 1e-9, .position = {1, 2, -400}},
                                {.shape = 0, .mass = 1e-9, .position = {1, 2, -500}}},
                               {});
  Impactor impactor{.mass = 1,
                    .radius = 0.5,
                    .place = "it",
                    .speed = 10,
                    .direction = -Vec3::UnitZ(),
                    .distance = 2,
                    .offset = Vec3(4.2, 0, 0),
                    .aim = Aiming::line};
  const auto aim = [&] { return aim_impactor(world.comm, impactor, world.bodies, world.shapes); };
  // Within the sphere around the clump, 4.2 m from its middle across it, there is nothing of it.
  EXPECT_NE(complaint_of(aim).find("the impactor misses"), std::string::npos);
  EXPECT_FALSE(would_hit(world.comm, impactor, world.bodies, world.shapes));
  const double round_off =
      1e-4;  // of the moments by which a shape finds its centre, and of 1e-9 kg
  for (const double y : {-4.0, 4.0}) {
    impactor.offset = Vec3(0, y, 0);
    EXPECT_LE((aim().position - Vec3(1, 2 + y, 3 + 1 + 0.5 + 2)).norm(), round_off) << y;
    EXPECT_EQ(aim().struck, 0);
  }
  impactor.offset = Vec3(0.9, 4, 0);
  EXPECT_NEAR(aim().position.z(), 5 + std::sqrt(1.5 * 1.5 - 0.81), round_off);
  impactor.aim = Aiming::head_on;
  EXPECT_LE((aim().position - Vec3(1, 6, 6.5)).norm(), round_off);
}

TEST(Case, clumps_may_lie_within_the_spheres_around_each_other_but_not_in_each_other) {
  if (testing_world().size > 1) return;  // one rank does it
  const auto complaint = [](const std::string& center, const std::string& rotation) {
    const std::string text = R"(
[materials.rock]
density = 1000
[shapes.rod]
spheres = [{at = [0, 0, 0], radius = 1}, {at = [1.5, 0, 0], radius = 1}, {at = [3, 0, 0], radius = 1}, {at = [4.5, 0, 0], radius = 1}, {at = [6, 0, 0], radius = 1}]
[[groups]]
name = "a"
material = "rock"
volume = {radius = 4}
packing = {kind = "single", shape = "rod"}
[[groups]]
name = "b"
material = "rock"
volume = {radius = 4, center = )" +
                             center +
                             R"(}
packing = {kind = "single", shape = "rod", rotation = )" +
                             rotation + R"(}
[[phases]]
name = "rest"
step = 1
duration = 1
)";
    return complaint_of([&] { make_bodies(parse_case(text, "rods.toml"), alone()); });
  };
  EXPECT_EQ(complaint("[0, 0, 2.01]", "[0, 0, 0]"), "") << "side by side, 2 m apart";
  EXPECT_EQ(complaint("[0, 0, 2.01]", "[0, 0, 1.5708]"), "") << "crosswise";
  const std::string told = complaint("[0, 0, 1.9]", "[0, 0, 1.5708]");
  EXPECT_NE(told.find("groups.b: body 1 at ("), std::string::npos) << told;
  EXPECT_NE(told.find("overlaps body 0 of groups.a at ("), std::string::npos) << told;
  EXPECT_NE(told.find("by 0.1 m"), std::string::npos) << told;
  EXPECT_NE(complaint("[0, 0, 1.5]", "[0, 1.5708, 0]"), "") << "end on";
  EXPECT_EQ(complaint("[5.01, 0, 3]", "[0, 1.5708, 0]"), "") << "beside its end";
}

TEST(Case, what_shapes_are_not_modelled_with_is_refused) {
  const auto complaint = [](const std::string& from, const std::string& to) {
    std::string text = heap;
    text.replace(text.find(from), from.size(), to);
    return complaint_of([&] { parse_case(text, "heap.toml"); });
  };
  const std::string step = "step = \"3 ms\"";
  for (const std::string method : {"potential", "solid"})
    EXPECT_NE(
        complaint(step, "method = \"" + method + "\"\n" + step)
            .find("packing.shape: phases.fall.method = \"" + method + "\" knows spheres alone"),
        std::string::npos)
        << complaint(step, "method = \"" + method + "\"\n" + step);
  EXPECT_NE(complaint(step, "solver = {method = \"sor\"}\n" + step).find("no [shapes]"),
            std::string::npos);
  EXPECT_NE(complaint("shape = \"boulder\"", "shape = \"rock\"")
                .find("groups.boulders: packing.shape: \"rock\" is not in [shapes]"),
            std::string::npos);
  EXPECT_NE(complaint("at = [1.4, 0, 0]", "at = [1.9, 0, 0]")
                .find("shapes.dumbbell: shape dumbbell: its spheres do not hang together"),
            std::string::npos);
  EXPECT_NE(complaint("count = 5", "").find("count"), std::string::npos);
}

}  // namespace
}  // namespace spall
