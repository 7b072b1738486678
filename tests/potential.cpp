// Steps of pair potentials against sums over all pairs, conservation laws, other numbers of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include "pair_potentials.hpp"
#include "spall/error.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

/// Of the distance: the first neighbours of an fcc crystal are at 1, the second at 1.41. None
/// crosses this cut-off, where the force jumps.
constexpr double between_shells = 1.22;

Lab potential_world(const Comm& comm, const std::vector<Sphere>& spheres,
                    const PairPotential& potential) {
  Lab world = make_world(comm, spheres, {});
  world.potential.law = potential;
  return world;
}

/// A ball of an fcc crystal with random velocities.
std::vector<Sphere> crystal(double d, double radius, double speed,
                            const Vec3& centre = Vec3::Zero(),
                            const Vec3& velocity = Vec3::Zero()) {
  std::mt19937_64 random(11);
  std::uniform_real_distribution<double> motion(-speed, speed);
  std::vector<Sphere> spheres;
  const int n = static_cast<int>(radius / d * 1.5) + 1;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k) {
        const Vec3 x = d / std::sqrt(2.0) * Vec3(i, j, k);
        if ((i + j + k) % 2 != 0 || x.norm() > radius) continue;
        const double mass = 1 + 0.5 * ((i + n) % 2);
        const Vec3 v(motion(random), motion(random), motion(random));
        spheres.push_back(
            {.radius = d / 2, .mass = mass, .position = centre + x, .velocity = velocity + v});
      }
  return spheres;
}

struct Sums {
  double kinetic = 0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
};
Sums sums_of(const std::vector<Sphere>& spheres) {
  Sums s;
  for (const Sphere& b : spheres) {
    s.kinetic += b.mass * b.velocity.squaredNorm() / 2;
    s.momentum += b.mass * b.velocity;
    s.angular += b.mass * b.position.cross(b.velocity);
  }
  return s;
}

double total_energy(Lab& world) {
  return sums_of(spheres_of(world)).kinetic + potential_energy(world);
}

double heat_of(const Lab& world) {
  double heat = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) heat += world.bodies.heat[b];
  return world.comm.sum(heat);
}

/// J, what each body presses with at these positions, by the sum over all pairs.
std::vector<double> pushes_of(const std::vector<Sphere>& spheres, const std::vector<Vec3>& at,
                              const PairPotential& p) {
  std::vector<double> pushes(at.size(), 0.0);
  if (p.embedding.bulk_modulus == 0) return pushes;
  const EmbeddingLaw law(p);
  for (std::size_t i = 0; i < at.size(); ++i) {
    double crowding = 0;
    for (std::size_t j = 0; j < at.size(); ++j)
      if (j != i) crowding += std::pow(std::max(0.0, 1 - (at[j] - at[i]).norm() / law.reach()), 2);
    pushes[i] = law.volume(spheres[i].mass) * law.push(crowding, 0).all;
  }
  return pushes;
}

double embedding_energy(const std::vector<Sphere>& spheres, const PairPotential& p) {
  if (p.embedding.bulk_modulus == 0) return 0;
  const EmbeddingLaw law(p);
  double energy = 0;
  for (const Sphere& a : spheres) {
    double crowding = -1;  // of itself
    for (const Sphere& b : spheres)
      crowding += std::pow(std::max(0.0, 1 - (a.position - b.position).norm() / law.reach()), 2);
    energy += law.volume(a.mass) * law.energy(crowding);
  }
  return energy;
}

/// The velocities after a step by the sum over all pairs.
std::vector<Vec3> kicked(const std::vector<Sphere>& spheres, const PairPotential& p, double c,
                         double h) {
  std::vector<Vec3> velocity, middle;
  for (const Sphere& s : spheres) middle.push_back(s.position + h / 2 * s.velocity);
  const std::vector<double> push = pushes_of(spheres, middle, p);
  const double reach = crowding_reach * p.distance;
  for (std::size_t i = 0; i < spheres.size(); ++i) {
    const Sphere& a = spheres[i];
    Vec3 force = Vec3::Zero();
    for (std::size_t j = 0; j < spheres.size(); ++j) {
      if (j == i) continue;
      const Sphere& b = spheres[j];
      const Vec3 x = b.position - a.position + h / 2 * (b.velocity - a.velocity);
      const double r = x.norm();
      const Vec3 n = x / r;
      force -= textbook_force(p, r) * n;
      if (r < reach) force -= (push[i] + push[j]) * 2 / reach * (1 - r / reach) * n;
      if (r < p.distance) force += c * (b.velocity - a.velocity).dot(n) * n;
    }
    velocity.push_back(a.velocity + h / a.mass * force);
  }
  return velocity;
}

void expect_velocities(const std::vector<Sphere>& after, const std::vector<Vec3>& expected,
                       double tolerance) {
  double largest = 0, worst = 0;
  for (std::size_t b = 0; b < after.size(); ++b) {
    largest = std::max(largest, expected[b].norm());
    worst = std::max(worst, (after[b].velocity - expected[b]).norm());
  }
  EXPECT_LE(worst, tolerance * largest);
}

TEST(PairPotential, step_equals_the_sum_over_all_pairs) {
  for (PairPotential p : {lennard_jones, mie, morse, sprung, steinhauser, breaking, embedded})
    for (double damping : {0.0, 0.4}) {
      p.damping = damping;
      // Compressed, so that pairs lie on both sides of the distance of rest.
      const auto spheres = crystal(0.98 * p.distance, 4.1, 1.5);
      Lab world = potential_world(testing_world(), spheres, p);
      double energy = embedding_energy(spheres, p);
      for (std::size_t i = 0; i < spheres.size(); ++i)
        for (std::size_t j = 0; j < i; ++j)
          energy += pair_energy(p, (spheres[i].position - spheres[j].position).norm());
      EXPECT_NEAR(potential_energy(world), energy, 1e-13 * std::abs(energy));
      const double h = 1e-2, c = damping * std::sqrt(2 * stiffness(p) * 1);
      potential_steps(world, h, 1);
      expect_velocities(spheres_of(world), kicked(spheres, p, c, h), 1e-13);
    }
}

TEST(PairPotential, no_pair_is_lost_at_hypervelocity) {
  // Aluminium by the formulas of the Hugoniot: k = 1.5 m c0^2/d^2, a d = 4 s - 2.
  const double d = 0.237e-3, c0 = 5350, m = 2703 * d * d * d / std::sqrt(2.0);
  PairPotential p{.law = PairLaw::morse,
                  .depth = 1.5 * m * c0 * c0 / (2 * 3.36 * 3.36),
                  .distance = d,
                  .steepness = 3.36,
                  .cutoff = 1.3 * d};
  auto spheres = crystal(d, 3.1 * d, 1);
  for (const Sphere& s : crystal(d, 3.1 * d, 1, {7.1 * d, 0.3 * d, 0.2 * d}, {-6700, 0, 0}))
    spheres.push_back(s);
  for (Sphere& s : spheres) s.mass = m;
  const double h = 0.05 * std::sqrt(m / stiffness(p));
  Lab world = potential_world(testing_world(), spheres, p);
  const int steps = 150;
  for (int step = 0; step < steps; ++step) {
    const auto expected = kicked(spheres, p, 0, h);
    potential_steps(world, h, 1);
    spheres = spheres_of(world);
    expect_velocities(spheres, expected, 1e-12);
  }
  // They have met, and most steps had pairs that were found before.
  EXPECT_GT(spheres[0].velocity.norm(), 0);
  EXPECT_GT(world.potential.near.searches, 5);
  EXPECT_LT(world.potential.near.searches, steps / 2);
}

TEST(PairPotential, energy_error_is_of_second_order) {
  for (PairPotential p : {lennard_jones, morse, crowded}) {
    p.cutoff = between_shells * p.distance;
    const auto spheres = crystal(p.distance, 2.6, 0.15);
    std::vector<double> errors;
    for (int halvings = 0; halvings < 3; ++halvings) {
      Lab world = potential_world(alone(), spheres, p);
      const int steps = 60 << halvings;
      const double before = total_energy(world);
      double worst = 0;
      for (int k = 0; k < steps; ++k) {
        potential_steps(world, 1.8 / steps, 1);
        worst = std::max(worst, std::abs(total_energy(world) - before));
      }
      errors.push_back(worst);
    }
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.15);
  }
}

TEST(PairPotential, energy_does_not_drift) {
  PairPotential p = morse;
  p.cutoff = between_shells * p.distance;
  Lab world = potential_world(alone(), crystal(p.distance, 2.3, 0.1), p);
  const double before = total_energy(world), kinetic = sums_of(spheres_of(world)).kinetic;
  std::vector<double> error;
  for (int part = 0; part < 100; ++part) {
    potential_steps(world, 0.015, 1000);
    error.push_back((total_energy(world) - before) / kinetic);
  }
  double first = 0, last = 0;
  for (int k = 0; k < 50; ++k) {
    first += error[k] / 50;
    last += error[50 + k] / 50;
  }
  // What an instant is off by is of second order; its mean stays where it was.
  EXPECT_NEAR(last, first, 1e-3);
}

TEST(PairPotential, fixed_bodies_press_like_a_crystal_s) {
  PairPotential p = embedded;
  p.damping = 0.3;
  std::vector<Sphere> spheres = crystal(p.distance, 2.1, 0.1, {0, 0, 5.4}, {0, 0, -1});
  for (const Sphere& s : crystal(p.distance, 2.1, 0)) {
    spheres.push_back(s);
    spheres.back().mass = infinity;
  }
  Lab world = potential_world(testing_world(), spheres, p);
  const double before = potential_energy(world);
  potential_steps(world, 0.01, 200);
  EXPECT_TRUE(std::isfinite(before));
  EXPECT_TRUE(std::isfinite(potential_energy(world)));
  for (const Sphere& s : spheres_of(world)) EXPECT_LT(s.velocity.norm(), 2);
}

TEST(PairPotential, momenta_are_kept_to_round_off) {
  PairPotential p = embedded;
  p.damping = 0.3;
  auto spheres = crystal(p.distance, 3.1, 0.2);
  for (const Sphere& s : crystal(p.distance, 2.1, 0.2, {6.5, 0.5, 0.2}, {-4, 0, 0}))
    spheres.push_back(s);
  Lab world = potential_world(testing_world(), spheres, p);
  const Sums before = sums_of(spheres);
  double scale = 0, turn = 0;
  for (const Sphere& s : spheres) {
    scale += s.mass * s.velocity.norm();
    turn += s.mass * s.velocity.norm() * s.position.norm();
  }
  potential_steps(world, 0.01, 300);
  const Sums after = sums_of(spheres_of(world));
  EXPECT_LE((after.momentum - before.momentum).norm(), 1e-13 * scale);
  EXPECT_LE((after.angular - before.angular).norm(), 1e-13 * turn);
  EXPECT_GT(heat_of(world), 0.01 * before.kinetic);
}

void expect_the_same_motion_on_any_number_of_ranks(PairPotential p) {
  p.damping = 0.2;
  const auto spheres = crystal(p.distance, 3.1, 0.3);
  Lab one = potential_world(alone(), spheres, p);
  Lab many = potential_world(testing_world(), spheres, p);
  potential_steps(one, 0.02, 100);
  for (int k = 0; k < 100; ++k) potential_steps(many, 0.02, 1);
  const auto a = spheres_of(one), b = spheres_of(many);
  for (std::size_t k = 0; k < a.size(); ++k)
    EXPECT_LE((a[k].position - b[k].position).norm(), 1e-11 * p.distance) << k;
  EXPECT_NEAR(heat_of(one), heat_of(many), 1e-11 * heat_of(one));
}

TEST(PairPotential, motion_is_the_same_on_any_number_of_ranks) {
  expect_the_same_motion_on_any_number_of_ranks(morse);
}

TEST(PairPotential, motion_with_an_embedding_is_the_same_on_any_number_of_ranks) {
  expect_the_same_motion_on_any_number_of_ranks(crowded);
}

TEST(PairPotential, needs_no_spins_and_without_damping_no_heat) {
  const auto spheres = crystal(morse.distance, 3.1, 0.3);
  Lab full = potential_world(testing_world(), spheres, morse);
  Lab lean = potential_world(testing_world(), spheres, morse);
  set_fields(lean.bodies, {});
  potential_steps(full, 0.02, 100);
  potential_steps(lean, 0.02, 100);
  EXPECT_GT(lean.potential.near.searches, 1);
  set_fields(lean.bodies, FieldSet::all());  // as tests gather them
  const auto a = spheres_of(full), b = spheres_of(lean);
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].position, b[k].position) << k;
  set_fields(lean.bodies, {});
  PairPotential damped = morse;
  damped.damping = 0.1;
  lean.potential.law = damped;
  EXPECT_THROW(potential_steps(lean, 0.02, 1), Error);
}

TEST(PairPotential, steps_in_one_call_equal_steps_in_many_bit_for_bit) {
  const auto spheres = crystal(morse.distance, 2.1, 0.05);
  Lab one = potential_world(alone(), spheres, morse);
  Lab many = potential_world(alone(), spheres, morse);
  potential_steps(one, 0.02, 20);
  for (int k = 0; k < 20; ++k) potential_steps(many, 0.02, 1);
  const auto a = spheres_of(one), b = spheres_of(many);
  for (std::size_t k = 0; k < a.size(); ++k) EXPECT_EQ(a[k].position, b[k].position) << k;
}

void expect_books_to_close(PairPotential p) {
  p.damping = 0.5;
  auto spheres = crystal(p.distance, 2.6, 0.05);
  for (const Sphere& s : crystal(p.distance, 1.6, 0.05, {5.6, 0.3, 0.2}, {-2, 0, 0}))
    spheres.push_back(s);
  std::vector<double> errors;
  double heat = 0;
  for (int halvings = 0; halvings < 3; ++halvings) {
    Lab world = potential_world(testing_world(), spheres, p);
    const int steps = 100 << halvings;
    const double before = total_energy(world);
    potential_steps(world, 3.0 / steps, steps);
    heat = heat_of(world);
    EXPECT_NEAR(world.comm.sum(world.ledger.dissipated), heat, 1e-12 * heat);
    errors.push_back(std::abs(total_energy(world) + heat - before));
  }
  // Heat is made at the velocities expected in the middle of the kick: of second order but
  // for pairs that the damping lets go in the middle of a step.
  EXPECT_GT(heat, 0.1 * sums_of(spheres).kinetic);
  EXPECT_LT(errors[2], 2e-3 * heat);
  EXPECT_GT(std::log2(errors[0] / errors[2]) / 2, 1.6);
}

TEST(PairPotential, heat_of_the_damping_closes_the_books) {
  expect_books_to_close(morse);
}

TEST(PairPotential, heat_that_presses_does_its_work_from_its_own) {
  expect_books_to_close(crowded);
}

TEST(PairPotential, bond_breaks_at_its_strain) {
  const double d = breaking.distance, first = 1.05 * d, strength = -textbook_force(breaking, first);
  // Released just inside of where the bond has no force left, with more or less than the energy
  // that is missing.
  for (double part : {0.9, 1.1}) {
    const double r = 1.02 * d;
    const double missing = -pair_energy(breaking, r);
    const double v = std::sqrt(part * missing);  // of each, m = 1: 2 v^2/2 = part * missing
    Lab world = potential_world(alone(),
                                {{.radius = d / 2, .velocity = {-v, 0, 0}},
                                 {.radius = d / 2, .position = {r, 0, 0}, .velocity = {v, 0, 0}}},
                                breaking);
    double furthest = 0;
    for (int k = 0; k < 2000; ++k) {
      potential_steps(world, 0.01, 1);
      const auto now = spheres_of(world);
      furthest = std::max(furthest, (now[1].position - now[0].position).norm());
    }
    EXPECT_EQ(furthest > breaking.cutoff, part > 1) << part << " " << strength;
  }
}

TEST(PairPotential, bond_holds_a_weight_below_its_strength_and_parts_above) {
  const double d = breaking.distance, strength = -textbook_force(breaking, 1.05 * d);
  // Hung up at the distance of rest a weight falls to twice its static strain: 0.4 is 0.8 there.
  for (double part : {0.4, 1.2}) {
    Lab world = potential_world(
        alone(), {{.radius = d / 2, .mass = infinity}, {.radius = d / 2, .position = {0, 0, -d}}},
        breaking);
    world.uniform_gravity = {0, 0, -part * strength};  // of 1 kg
    double early = 0, late = 0;                        // furthest fall in the first and last tenth
    const int steps = 1000000;
    for (int k = 0; k < steps && late < 10 * d; ++k) {
      potential_steps(world, 0.01, 1);
      double fall = 0;
      for (Index b = 0; b < world.bodies.owned; ++b)
        fall = std::max(fall, -d - world.bodies.position[b].z());
      if (k < steps / 10) early = std::max(early, fall);
      if (k >= steps - steps / 10 || fall > d) late = std::max(late, fall);
    }
    if (part < 1) {
      EXPECT_GT(early, 0);
      EXPECT_LT(late, 0.05 * d);
      EXPECT_NEAR(late, early, 1e-3 * early);  // no vibration grows
    } else {
      EXPECT_GE(late, 10 * d);
    }
  }
}

TEST(PairPotential, too_long_a_step_is_refused_with_one_that_would_do) {
  const double m = 2, limit = 0.1 * std::sqrt(m / stiffness(morse));
  EXPECT_NO_THROW(check_step(morse, 0.99 * limit, {m, m / 2, 0}, "here"));
  const auto message = [&](double h, double speed, PairPotential p) -> std::string {
    return complaint_of([&] { check_step(p, h, {m, m / 2, speed}, "case.toml:7"); });
  };
  EXPECT_NE(message(2 * limit, 0, morse).find(fmt::format("{:.3g} s", limit)), std::string::npos);
  EXPECT_NE(message(limit, 10, morse).find(fmt::format("{:.3g} s", 0.1 * morse.distance / 10)),
            std::string::npos);
  PairPotential soft = morse;
  soft.steepness = 1;
  EXPECT_NE(message(1e-4, 40, soft).find("pass through each other"), std::string::npos);
}

}  // namespace
}  // namespace spall
