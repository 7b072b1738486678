// Clumps in penalty contact: exact impacts, sums over their spheres, books, memory, other ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <memory>

#include "clump_cases.hpp"
#include "clump_worlds.hpp"
#include "engine/prescribed.hpp"
#include "output/diagnostics.hpp"
#include "penalty_worlds.hpp"
#include "run/simulation.hpp"
#include "scene/case.hpp"
#include "spall/spall.hpp"

namespace spall {
namespace {

const PenaltySettings hertz{.model = PenaltyModel::hertz, .rolling_friction = 0.1};
PenaltySettings hooke(double stiffness) {
  return {.model = PenaltyModel::hooke, .stiffness = stiffness};
}

Lab clump_world(const Comm& comm, const BodyShapes& shapes, const std::vector<ShapedBody>& clumps,
                const PenaltySettings& settings, const ContactLaw& contact) {
  Lab world = make_world(comm, shapes, clumps, contact);
  for (Index b = 0; b < world.bodies.owned; ++b) world.bodies.heat[b] = 0;
  world.materials = {soft_rock};
  world.penalty.settings = settings;
  return world;
}

/// A cloud that falls in, of bodies as heavy as rock.
std::vector<ShapedBody> rocks(int count, double edge, double speed) {
  auto clumps = cloud_of_clumps(count, edge, 2.65, speed);
  for (ShapedBody& clump : clumps) {
    clump.mass *= 2000;
    clump.velocity -= 2 * speed / edge * clump.position;
  }
  return clumps;
}

/// Restitution of a spring and a dashpot of `zeta` times the critical damping.
double restitution_of(double zeta) {
  return std::exp(-pi * zeta / std::sqrt(1 - zeta * zeta));
}
/// That of a pair with this restitution.
double damping_of(double restitution) {
  const double log_e = std::log(restitution);
  return -log_e / std::sqrt(pi * pi + log_e * log_e);
}

TEST(PenaltyClump, spheres_beside_shapes_move_by_the_bits_of_spheres) {
  auto clumps = rocks(60, 10.5, 1);
  for (ShapedBody& clump : clumps) clump.shape = 0;
  const auto run = [&](const BodyShapes& shapes) {
    Lab world =
        clump_world(testing_world(), shapes, clumps, hertz, {.friction = 0.5, .restitution = 0.6});
    world.planes = {{.point = {0, 0, -7}, .normal = Vec3::UnitZ()}};
    world.uniform_gravity = {0, 0, -1};
    for (int k = 0; k < 20; ++k) penalty_steps(world, 1e-3, 50);
    EXPECT_GT(world.penalty.touch.searches, 1);
    return spheres_of(world);
  };
  const auto spheres = run({}), members = run(with_sphere({dumbbell(), boulder()}));
  double turned = 0;
  for (std::size_t k = 0; k < spheres.size(); ++k) {
    EXPECT_EQ(members[k].position, spheres[k].position) << k;
    EXPECT_EQ(members[k].velocity, spheres[k].velocity) << k;
    EXPECT_EQ(members[k].spin, spheres[k].spin) << k;
    turned = std::max(turned, (spheres[k].spin - clumps[k].spin).norm());
  }
  EXPECT_GT(turned, 0.1) << "some have met";
}

/// Of a clump that falls on the floor at `v`: its motion once it has left it.
Sphere after_hit(const BodyShape& shape, ShapedBody clump, double stiffness, double e, double v) {
  clump.velocity = {0, 0, -v};
  double lowest = infinity;
  for (const ShapeSphere& sphere : shape.spheres) {
    const ShapeSphere placed =
        placed_sphere(sphere, clump.position, clump.radius, clump.orientation);
    lowest = std::min(lowest, placed.at.z() - placed.radius);
  }
  // It begins to touch in the middle of a step.
  const double h = 0.002 * pi * std::sqrt(clump.mass / stiffness);
  clump.position.z() += v * h / 2 - lowest;
  Lab world = clump_world(alone(), with_sphere({shape}), {clump}, hooke(stiffness),
                          {.friction = 0, .restitution = e});
  world.planes = {floor_plane};
  for (bool touched = false;;) {
    const bool touches = world.penalty.advance(world, {.h = h}).contacts > 0;
    if (touched && !touches) return spheres_of(world)[0];
    touched = touched || touches;
  }
}

TEST(PenaltyClump, that_falls_on_two_spheres_at_once_has_both_springs_and_dashpots) {
  const std::array<ShapeSphere, 2> spheres{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape rod = make_shape("rod", spheres);
  for (double e : {0.9, 0.6, 0.3}) {
    // Twice the spring, twice the dashpot: sqrt(2) of the damping.
    const double kept = restitution_of(std::sqrt(2.0) * damping_of(e));
    const Sphere after = after_hit(rod, {.mass = 700}, 1e6, e, 0.1);
    EXPECT_NEAR(after.velocity.z() / 0.1, kept, 3e-3) << e;
    EXPECT_LE(after.spin.norm(), 1e-12) << e;
  }
}

TEST(PenaltyClump, rod_that_falls_on_its_end_tends_to_the_impulse_of_the_closed_form) {
  const std::array<ShapeSphere, 3> spheres{
      {{Vec3(2, 0, 0), 0.5}, {Vec3(0.8, 0, 0), 1.0}, {Vec3(-1, 0, 0), 1.4}}};
  const BodyShape rod = make_shape("rod", spheres);
  const double v = 0.3, m = 700;
  for (double e : {1.0, 0.7})
    for (double tilt : {0.5, 1.0, 1.4}) {
      ShapedBody clump{.mass = m};
      clump.orientation = turned_by(Vec3(0, tilt, 0), rod.as_listed);
      const ShapeSphere& end = rod.spheres[0];
      const Vec3 arm = clump.orientation * end.at, n = Vec3::UnitZ();
      const Mat3 inverse = turned_tensor(clump.orientation, rod.inertia.cwiseInverse()) / m;
      // The end moves as `share` of the mass would; the dashpot knows the whole.
      const double share = 1 / (1 + m * arm.cross(n).dot(inverse * arm.cross(n)));
      const double kept = restitution_of(damping_of(e) / std::sqrt(share));
      const double p = (1 + kept) * v * share * m;
      std::vector<double> errors;
      for (double stiffness : {1e6, 1e8}) {
        const Sphere after = after_hit(rod, clump, stiffness, e, v);
        errors.push_back(std::abs(after.velocity.z() - (p / m - v)) / v +
                         (after.spin - inverse * arm.cross(p * n)).norm() / v);
      }
      // The rod turns while it touches, ten times as long on the softer spring.
      EXPECT_LT(errors[1], 0.02) << e << " " << tilt;
      EXPECT_LT(errors[1], 0.3 * errors[0] + 4e-3) << e << " " << tilt;
    }
}

TEST(PenaltyClump, at_rest_sinks_by_the_weight_over_the_springs_under_it) {
  const std::array<ShapeSphere, 3> spheres{
      {{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}, {Vec3(0, 1.5, 0), 1}}};
  const BodyShape tripod = make_shape("tripod", spheres);
  ShapedBody clump{.mass = 700, .position = {0.1, 0.2, tripod.spheres[0].radius}};
  clump.orientation = tripod.as_listed.conjugate();
  Lab world = clump_world(testing_world(), with_sphere({tripod}), {clump}, hooke(1e6),
                          {.friction = 0.5, .restitution = 0.1});
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -2};
  penalty_steps(world, 1e-4, 1);
  for (int k = 0; k < 40; ++k) penalty_steps(world, 1e-3, 100);
  // Its centre of mass is in the middle of its feet, as near as quadrature has it.
  const double sunk = 700 * 2 / (3 * 1e6);
  const Sphere now = spheres_of(world)[0];
  EXPECT_NEAR(tripod.spheres[0].radius - now.position.z(), sunk, 1e-4 * sunk);
  EXPECT_LE(now.velocity.norm(), 1e-9);
  EXPECT_LE(now.spin.norm(), 1e-9);
}

TEST(PenaltyClump, is_kicked_by_the_sum_over_its_spheres) {
  // Dumbbells of spheres that touch, beside such spheres each with the mass of a dumbbell: free to
  // go, they feel the same forces.
  const std::array<ShapeSphere, 2> touching{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape pair = make_shape("pair", touching);
  auto clumps = rocks(60, 10.5, 1);
  std::vector<Sphere> spheres;
  for (ShapedBody& clump : clumps) {
    clump = {.mass = clump.mass,
             .position = 0.6 * clump.position,
             .velocity = clump.velocity,
             .orientation = clump.orientation};
    for (const ShapeSphere& one : pair.spheres) {
      const ShapeSphere placed =
          placed_sphere(one, clump.position, clump.radius, clump.orientation);
      spheres.push_back({placed.radius, clump.mass, placed.at, clump.velocity, Vec3::Zero()});
    }
  }
  const double h = 1e-6;
  const ContactLaw law{.friction = 0.4, .restitution = 0.5};
  Lab world = clump_world(testing_world(), with_sphere({pair}), clumps, hertz, law);
  Lab apart = penalty_world(testing_world(), spheres, hertz, law);
  penalty_steps(world, h, 1);
  penalty_steps(apart, h, 1);
  const auto now = spheres_of(world), free = spheres_of(apart);
  double most = 0, turned = 0, wrong = 0, wrong_turn = 0;
  for (std::size_t k = 0; k < now.size(); ++k) {
    const double m = clumps[k].mass;
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    for (std::size_t s = 2 * k; s < 2 * k + 2; ++s) {
      const Vec3 kick = m * (free[s].velocity - spheres[s].velocity);
      force += kick;
      torque += (spheres[s].position - clumps[k].position).cross(kick) +
                moment_of_inertia(m, spheres[s].radius) * free[s].spin;
    }
    const Mat3 inverse = turned_tensor(clumps[k].orientation, pair.inertia.cwiseInverse()) / m;
    wrong = std::max(wrong, (now[k].velocity - clumps[k].velocity - force / m).norm());
    wrong_turn = std::max(wrong_turn, (now[k].spin - inverse * torque).norm());
    most = std::max(most, (force / m).norm());
    turned = std::max(turned, (inverse * torque).norm());
  }
  EXPECT_GT(most, 1e-6);
  EXPECT_LE(wrong, 1e-6 * most);
  EXPECT_LE(wrong_turn, 1e-6 * turned);
}

TEST(PenaltyClump, clouds_keep_their_momenta_to_round_off) {
  PenaltySettings settings = hertz;
  settings.adhesion = Adhesion::jkr;
  settings.adhesion_strength = 200;
  Lab world = clump_world(testing_world(), with_sphere({dumbbell(), boulder()}), rocks(80, 12, 0.5),
                          settings, {.friction = 0.5, .restitution = 0.6});
  const Diagnostics before = diagnose(world);
  penalty_steps(world, 4e-4, 4000);
  const Diagnostics now = diagnose(world);
  EXPECT_LE((now.momentum - before.momentum).norm(), 1e-13 * before.momentum_scale);
  EXPECT_LE((now.angular_momentum - before.angular_momentum).norm(),
            1e-12 * before.angular_momentum_scale);
  EXPECT_GT(now.dissipated, 0.05 * before.kinetic);
  EXPECT_GT(world.penalty.touch.searches, 1);
}

TEST(PenaltyClump, books_close_to_first_order) {
  for (const ContactLaw& contact : {ContactLaw{.friction = 0, .restitution = 0.6},
                                    ContactLaw{.friction = 0.5, .restitution = 1}}) {
    const auto clumps = rocks(60, 10.5, 0.5);
    std::vector<double> errors;
    double lost = 0, kinetic = 0;
    for (int halvings = 0; halvings < 2; ++halvings) {
      Lab world = clump_world(testing_world(), with_sphere({dumbbell(), boulder()}), clumps,
                              {.model = PenaltyModel::hertz}, contact);
      const int steps = 4000 << halvings;
      kinetic = diagnose(world).kinetic;
      const double before = kinetic + contact_energy(world);
      penalty_steps(world, 2.0 / steps, steps);
      const Diagnostics now = diagnose(world);
      lost = now.dissipated;
      errors.push_back(std::abs(now.kinetic + contact_energy(world) + lost - before));
    }
    EXPECT_GT(lost, 0.03 * kinetic);
    EXPECT_LT(errors[1], 0.03 * lost);
    EXPECT_LT(errors[1], 0.7 * errors[0]);
  }
}

/// Elastic clumps for 2 s in so many steps: the largest error of their energy, of all of it.
/// `energy(world, h)` makes a step and tells it.
template <class Energy>
double worst_error(int steps, Energy&& energy) {
  Lab world = clump_world(testing_world(), with_sphere({dumbbell(), boulder()}), rocks(40, 9, 0.5),
                          {.model = PenaltyModel::hertz}, {.friction = 0, .restitution = 1});
  const double all = diagnose(world).kinetic + contact_energy(world);
  double worst = 0, pressed = 0;
  for (int k = 0; k < steps; ++k) {
    const auto [now, of_contacts] = energy(world, 2.0 / steps);
    worst = std::max(worst, std::abs(now - all) / all);
    pressed = std::max(pressed, of_contacts / all);
  }
  EXPECT_GT(pressed, 0.01) << "some have met";
  return worst;
}

TEST(PenaltyClump, energy_of_elastic_clumps_is_kept_to_second_order) {
  std::vector<double> errors;
  for (int steps : {3000, 6000})
    errors.push_back(worst_error(steps, [](Lab& world, double h) {
      penalty_steps(world, h, 1);
      const double of_contacts = contact_energy(world);
      return std::pair(diagnose(world).kinetic + of_contacts, of_contacts);
    }));
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.3);
}

TEST(PenaltyClump, energy_read_in_the_middle_of_a_kick_is_good_to_second_order) {
  std::vector<double> errors;
  for (int steps : {3000, 6000})
    errors.push_back(worst_error(steps, [](Lab& world, double h) {
      const double kinetic = diagnose(world).kinetic;
      const StepReport report = world.penalty.advance(world, {.h = h, .energy = true});
      const double of_contacts = world.comm.sum(report.energy);
      return std::pair(kinetic + of_contacts, of_contacts);
    }));
  EXPECT_LT(errors[1], 1e-3);
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 2, 0.3);
}

TEST(PenaltyClump, clouds_move_alike_on_any_number_of_ranks) {
  const auto clumps = rocks(60, 10.5, 0.5);
  const auto run = [&](const Comm& comm) {
    Lab world = clump_world(comm, with_sphere({dumbbell(), boulder()}), clumps, hertz,
                            {.friction = 0.5, .restitution = 0.6});
    for (int k = 0; k < 40; ++k) penalty_steps(world, 5e-4, 100);
    return spheres_of(world);
  };
  const auto together = run(testing_world()), by_one = run(alone());
  double hit = 0;
  for (std::size_t k = 0; k < together.size(); ++k) {
    EXPECT_LE((together[k].position - by_one[k].position).norm(), 1e-9) << k;
    EXPECT_LE((together[k].spin - by_one[k].spin).norm(), 1e-8) << k;
    hit += (by_one[k].velocity - clumps[k].velocity).norm() > 0.1 ? 1 : 0;
  }
  EXPECT_GT(hit, 10);
}

TEST(PenaltyClump, springs_of_its_spheres_survive_searches_and_migration) {
  const auto clumps = rocks(60, 10.5, 0.5);
  std::int64_t touching = 0;
  const auto run = [&](auto&& disturb) {
    Lab world = clump_world(testing_world(), with_sphere({dumbbell(), boulder()}), clumps, hertz,
                            {.friction = 0.5, .restitution = 0.6});
    for (int k = 0; k < 3000; ++k) {
      touching += world.penalty.advance(world, {.h = 5e-4}).contacts;
      disturb(world);
    }
    return spheres_of(world);
  };
  const auto expected = run([](Lab&) {});
  EXPECT_GT(testing_world().sum(touching), 400);
  const auto expect_same = [&](const std::vector<Sphere>& now) {
    for (std::size_t k = 0; k < now.size(); ++k)
      EXPECT_LE((now[k].spin - expected[k].spin).norm(), 1e-9) << k;
  };
  expect_same(run([](Lab& world) {
    world.penalty.touch.skin = 0;
    world.penalty.touch.last_cut = {};  // never cut: the next search cuts
  }));
  expect_same(run([](Lab& world) {
    PairMemory memory = world.penalty.remember(world);
    world.penalty.restart_pairs(world, std::move(memory));
  }));
}

TEST(PenaltyClump, across_the_boundary_is_as_in_the_middle) {
  // A ball falls on the end of a rod, then on its other end; the rod may reach over the boundary.
  const std::array<ShapeSphere, 2> touching{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape pair = make_shape("pair", touching);
  const auto run = [&](double shift) {
    ShapedBody rod{.radius = 2, .mass = 2000, .position = {shift, 0, 0}};
    rod.orientation = pair.as_listed.conjugate();
    std::vector<ShapedBody> bodies{rod};
    for (double side : {1.0, -1.0})
      bodies.push_back({.shape = 0,
                        .mass = 1000,
                        .position = {shift + side, 3.2 + side, 0},
                        .velocity = {0.1 * side, -2, 0}});
    Lab world = clump_world(testing_world(), with_sphere({pair}), bodies, hertz,
                            {.friction = 0.5, .restitution = 0.6});
    world.period.size = Vec3::Constant(9);
    penalty_steps(world, 5e-4, 2500);
    EXPECT_GT(world.penalty.touch.searches, 1);
    return spheres_of(world);
  };
  const auto in_the_middle = run(0);
  EXPECT_GT(in_the_middle[0].spin.norm(), 0.1);
  for (double shift : {4.0, 4.5, -4.2}) {
    const auto across = run(shift);
    for (std::size_t k = 0; k < across.size(); ++k) {
      EXPECT_LE((across[k].velocity - in_the_middle[k].velocity).norm(), 1e-9) << k;
      EXPECT_LE((across[k].spin - in_the_middle[k].spin).norm(), 1e-9) << k;
    }
  }
}

TEST(PenaltyClump, links_are_of_bodies_whose_spheres_touch) {
  const std::array<ShapeSphere, 2> touching{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape pair = make_shape("pair", touching);
  const double r = pair.spheres[0].radius;
  // Two lie side by side and touch twice; a third lies within the spheres around them, apart.
  ShapedBody lying;
  lying.orientation = pair.as_listed.conjugate();
  std::vector<ShapedBody> clumps(3, lying);
  clumps[1].position = {0, 1.999 * r, 0};
  clumps[2].position = {0, 0, 2.01 * r};
  for (ShapedBody& clump : clumps) clump.mass = 2000;
  Lab world = clump_world(testing_world(), with_sphere({pair}), clumps, hertz,
                          {.friction = 0.5, .restitution = 0.6});
  const auto count = [&] {
    const LinkedBodies linked = world.penalty.links(world);
    std::vector<double> rows;
    for (std::size_t k = 0; k < linked.links.i.size(); ++k)
      for (const Index row : {linked.links.i[k], linked.links.j[k]})
        rows.push_back(static_cast<double>(linked.bodies.id[row]));
    std::vector<double> all = world.comm.all_gather(rows);
    std::ranges::sort(all);
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  };
  EXPECT_EQ(count(), (std::vector<double>{0, 1}));
  EXPECT_GT(world.penalty.energy(world), 0);
  EXPECT_EQ(world.comm.sum(world.penalty.advance(world, {.h = 1e-4}).contacts), 2);
  EXPECT_EQ(count(), (std::vector<double>{0, 1}));
}

TEST(PenaltyClump, gap_is_that_of_the_nearest_spheres_of_both_shapes) {
  const std::array<ShapeSphere, 2> touching{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape pair = make_shape("pair", touching);
  ShapedBody lying;
  lying.orientation = pair.as_listed.conjugate();
  const ShapedBody ball{.shape = 0, .radius = 0.3, .position = {0.5, 0, 1.2}};
  const Lab world = clump_world(alone(), with_sphere({pair}), {lying, ball}, hertz, {});
  const double r = pair.spheres[0].radius;  // of a sphere of the pair, at (r, 0, 0)
  const double gap = std::hypot(0.5 - r, 1.2) - r - 0.3;
  EXPECT_NEAR(gap_between(world.shapes, world.bodies, 0, 1), gap, 1e-12);
  EXPECT_NEAR(gap_between(world.shapes, world.bodies, 1, 0), gap, 1e-12);
}

TEST(PenaltyClump, that_spins_may_meet_another_at_the_speed_of_both_ends) {
  const std::array<ShapeSphere, 2> touching{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape pair = make_shape("pair", touching);
  std::vector<ShapedBody> clumps(2, {.radius = 3, .spin = {0, 0, 2}});
  clumps[1].position = {9, 0, 0};
  const Lab world = clump_world(alone(), with_sphere({pair}), clumps, hertz, {});
  EXPECT_NEAR(largest_meeting_speed(world, 1), 2 * 2 * 3 * pair.spheres[0].at.norm(), 1e-12);
}

TEST(PenaltyClump, step_is_limited_by_the_mass_that_its_end_feels) {
  const std::array<ShapeSphere, 2> touching{{{Vec3(-1, 0, 0), 1}, {Vec3(1, 0, 0), 1}}};
  const BodyShape pair = make_shape("pair", touching);
  std::vector<ShapedBody> clumps(2, {.mass = 800});
  clumps[1].position = {9, 0, 0};
  const Lab world = clump_world(alone(), with_sphere({pair}), clumps, hooke(1e6),
                                {.friction = 0.5, .restitution = 0.5});
  // Across its axis each end moves as this share of the mass would.
  const double share = 1 / (1 + pair.spheres[0].at.squaredNorm() / pair.inertia.maxCoeff());
  const double longest = 0.15 * std::sqrt(share * 400 / 1e6);
  const auto complaint = [&](double h) {
    return complaint_of(
        [&] { world.penalty.check_steps(world, {.h = h, .lasts = 1, .place = "x"}); });
  };
  EXPECT_EQ(complaint(0.999 * longest), "");
  EXPECT_NE(complaint(1.001 * longest).find("is too long for penalty contact"), std::string::npos);
}

// Cases --------------------------------------------------------------------------------------

const std::string heap =
    heap_of_clumps({.material = "youngs_modulus = \"2 GPa\"\npoisson_ratio = 0.25\n",
                    .restitution = "0.5",
                    .tables = "[penalty]\nmodel = \"hertz\"\n",
                    .phase = "method = \"penalty\"\n",
                    .step = "50 us"});

TEST(PenaltyClump, a_run_that_is_stopped_goes_on_with_the_same_bits) {
  const double contacts = expect_the_same_bits_after_a_stop(heap, "penalty_clumps", 1, 1.1);
  EXPECT_GT(contacts, 5);
}

TEST(PenaltyClump, what_cannot_be_resolved_is_refused_with_what_would_do) {
  const auto complaint = [](const std::string& from, const std::string& to) {
    std::string text = heap;
    text.replace(text.find(from), from.size(), to);
    return complaint_of([&] {
      Simulation simulation(alone(), Scene(std::make_shared<Case>(parse_case(text, "heap.toml"))));
      simulation.run_until(1e-3);
    });
  };
  EXPECT_EQ(complaint("50 us", "50 us"), "");
  const std::string told = complaint("50 us", "1 ms");
  EXPECT_NE(told.find("is too long for penalty contact"), std::string::npos) << told;
  EXPECT_NE(told.find("a sphere of body"), std::string::npos) << told;
}

}  // namespace
}  // namespace spall
