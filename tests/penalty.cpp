// Penalty contact against exact solutions, sums over all pairs, conservation laws and other numbers
// of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "penalty/elastic.hpp"
#include "penalty/jkr.hpp"
#include "penalty_worlds.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

const PenaltySettings hooke{.model = PenaltyModel::hooke, .stiffness = 1e6};
const PenaltySettings hertz{.model = PenaltyModel::hertz};
PenaltySettings sticky(Adhesion adhesion) {
  PenaltySettings s = hertz;
  s.adhesion = adhesion;
  s.adhesion_strength = 200;
  return s;
}
ContactLaw contact_law(double friction, double restitution) {
  return {.friction = friction, .restitution = restitution};
}

/// Two spheres of 1 m and 1000 kg that meet head-on at `speed`, each at half of it.
std::vector<Sphere> head_on(double speed, double gap) {
  return {
      {.radius = 1, .mass = 1000, .position = {-1 - gap / 2, 0, 0}, .velocity = {speed / 2, 0, 0}},
      {.radius = 1, .mass = 1000, .position = {1 + gap / 2, 0, 0}, .velocity = {-speed / 2, 0, 0}}};
}

struct Collision {
  double restitution, overlap, duration;
};
Collision collide(const PenaltySettings& settings, double restitution, double speed, double h) {
  // Touching begins in the middle of a step: the first force acts at zero overlap.
  Lab world =
      penalty_world(alone(), head_on(speed, speed * h / 2), settings, contact_law(0, restitution));
  Collision c{0, 0, 0};
  for (bool touched = false;;) {
    penalty_steps(world, h, 1);
    const auto s = spheres_of(world);
    const double overlap = 2 - (s[1].position - s[0].position).norm();
    c.overlap = std::max(c.overlap, overlap);
    if (overlap > 0) c.duration += h;
    touched = touched || overlap > 0;
    if (touched && overlap < -0.1 * speed * h)
      return {-(s[1].velocity - s[0].velocity).x() / -speed, c.overlap, c.duration};
  }
}

TEST(Penalty, hooke_gives_the_restitution_exactly) {
  for (double e : {0.9, 0.5, 0.2}) {
    std::vector<double> errors;
    for (double h : {2e-4, 1e-4})
      errors.push_back(std::abs(collide(hooke, e, 0.1, h).restitution - e));
    // Half a period is not a whole number of steps: an error of first order, below a hundredth.
    EXPECT_LT(errors[1], 0.01 * e) << e;
    EXPECT_NEAR(collide(hooke, e, 10, 1e-5).restitution, e, 1e-3) << e;
  }
}

TEST(Penalty, hertz_gives_the_same_restitution_at_all_speeds) {
  for (double e : {0.9, 0.6, 0.3})
    for (double speed : {0.01, 0.1, 1.0}) {
      const double duration = 0.02 * std::pow(speed, -0.2);
      EXPECT_NEAR(collide(hertz, e, speed, duration / 2000).restitution, e, 2e-3) << e << speed;
    }
}

TEST(Penalty, elastic_impact_has_hertz_overlap_and_duration) {
  // delta = (15 m v^2/(16 E* sqrt(R)))^(2/5), t = 2.943 delta/v (Hertz 1882; Johnson 1985, 11.3).
  const double modulus = 1e8 / (2 * (1 - 0.0625)), m = 500, r = 0.5, v = 0.5;
  const double overlap = std::pow(15 * m * v * v / (16 * modulus * std::sqrt(r)), 0.4);
  const Collision c = collide(hertz, 1, v, 1e-5);
  EXPECT_NEAR(c.overlap, overlap, 1e-4 * overlap);
  EXPECT_NEAR(c.duration, 2.9433 * overlap / v, 3e-5);
  EXPECT_NEAR(c.restitution, 1, 1e-4);
}

TEST(Penalty, elastic_energy_error_is_of_second_order) {
  for (const PenaltySettings& settings : {hooke, hertz}) {
    std::vector<double> errors;
    for (int halvings = 0; halvings < 3; ++halvings) {
      const int steps = 100 << halvings;
      // Starts pressed together and ends so: no step is cut by the loss of contact.
      auto spheres = head_on(0.2, -0.02);
      Lab world = penalty_world(alone(), spheres, settings, contact_law(0, 1));
      const double before = sums_of(spheres).kinetic + contact_energy(world);
      double worst = 0;
      for (int k = 0; k < steps / 4; ++k) {
        penalty_steps(world, 0.02 / steps, 1);
        worst = std::max(
            worst, std::abs(sums_of(spheres_of(world)).kinetic + contact_energy(world) - before));
      }
      errors.push_back(worst);
    }
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.15);
  }
}

TEST(Penalty, energy_of_elastic_spheres_does_not_drift) {
  if (testing_world().rank > 0) return;  // small and long: one rank does it
  auto spheres = crowd(27, 0, 1);
  for (Sphere& s : spheres) s.spin.setZero();
  Lab world = penalty_world(alone(), spheres, hertz, contact_law(0, 1));
  world.period.size = Vec3::Constant(9);
  const double before = sums_of(spheres).kinetic + contact_energy(world);
  double first = 0, last = 0;
  for (int part = 0; part < 100; ++part) {
    penalty_steps(world, 1e-4, 1000);
    const double now = sums_of(spheres_of(world)).kinetic + contact_energy(world);
    (part < 50 ? first : last) += (now - before) / 50;
  }
  // Each impact is a little off, one way or the other.
  EXPECT_NEAR(last, first, 1e-3 * before);
  EXPECT_NEAR(last, 0, 1e-3 * before);
}

/// A pair's normal force by the book, damping apart, with its S, k_t and attraction.
struct Textbook {
  double force, slope, tangential, attraction;
};
Textbook textbook(const PenaltySettings& s, double overlap, double r) {
  if (s.model == PenaltyModel::hooke)
    return {s.stiffness * overlap, s.stiffness, s.tangential_ratio * s.stiffness, 0};
  const double nu = soft_rock.poisson_ratio, w = s.adhesion_strength;
  const double modulus = soft_rock.youngs_modulus / (2 * (1 - nu * nu));
  const double shear = soft_rock.youngs_modulus / (4 * (2 - nu) * (1 + nu));
  double a = std::sqrt(r * overlap), force = 4 / 3.0 * modulus * a * overlap, attraction = 0;
  if (s.adhesion == Adhesion::dmt) attraction = 2 * pi * w * r;
  force -= attraction;
  if (s.adhesion == Adhesion::jkr) {
    // The larger root of a^2/R - sqrt(2 pi w a/E*) = overlap, by halving.
    double low = std::cbrt(2 * pi * w * r * r / (16 * modulus)), high = 10 * r;
    for (int k = 0; k < 200; ++k) {
      a = (low + high) / 2;
      (a * a / r - std::sqrt(2 * pi * w * a / modulus) < overlap ? low : high) = a;
    }
    force = 4 * modulus * a * a * a / (3 * r) - std::sqrt(8 * pi * w * modulus * a * a * a);
    attraction = 3 * pi * w * r;
  }
  return {force, 2 * modulus * a, 8 * shear * a, attraction};
}

TEST(Penalty, pairs_are_looked_for_as_far_as_necks_reach) {
  // The neck of a sphere of 1 m on a wall, R = 1 m, is the longest, longer than of two of them. It
  // ends where the overlap, a^2/R - sqrt(2 pi w a/E*), has its least.
  const PenaltySettings s = sticky(Adhesion::jkr);
  const double nu = soft_rock.poisson_ratio, w = s.adhesion_strength, r = 1;
  const double modulus = soft_rock.youngs_modulus / (2 * (1 - nu * nu));
  const double a = std::cbrt(pi * w * r * r / (8 * modulus));
  const double least = a * a / r - std::sqrt(2 * pi * w * a / modulus);
  const PenaltyLaw law = penalty_law(s, contact_law(0.5, 0.5), soft_rock, soft_rock);
  EXPECT_NEAR(widest_gap(law, 1), -least, 1e-12 * -least);
  EXPECT_EQ(widest_gap(penalty_law(hertz, contact_law(0.5, 0.5), soft_rock, soft_rock), 1), 0);
}

TEST(Penalty, growth_of_the_tangential_stiffness_is_its_slope) {
  const auto differs = [](const auto& law, double overlap) {
    const double r = 0.5, h = 1e-5 * overlap;
    const auto k = [&](double x) {
      return std::log(law.force(spread(x), spread(r)).tangential[0]);
    };
    const double slope = (k(overlap + h) - k(overlap - h)) / (2 * h);
    return law.force(spread(overlap), spread(r)).growth[0] / slope - 1;
  };
  for (Adhesion adhesion : {Adhesion::none, Adhesion::dmt, Adhesion::jkr}) {
    const PenaltySettings s = adhesion == Adhesion::none ? hertz : sticky(adhesion);
    const PenaltyLaw law = penalty_law(s, contact_law(0.5, 0.5), soft_rock, soft_rock);
    for (double overlap : {1e-4, 1e-2})
      EXPECT_NEAR(adhesion == Adhesion::jkr ? differs(JkrLanes<double>(law), overlap)
                                            : differs(HertzLanes<false, double>(law), overlap),
                  0, 1e-6);
  }
}

/// Velocities and spins after a step with fresh springs, by a sum over all pairs.
std::vector<Sphere> kicked(std::vector<Sphere> spheres, const PenaltySettings& s,
                           const ContactLaw& contact, double h) {
  const PenaltyLaw law = penalty_law(s, contact, soft_rock, soft_rock);
  for (Sphere& a : spheres) a.position += h / 2 * a.velocity;
  std::vector<Sphere> after = spheres;
  for (std::size_t i = 0; i < spheres.size(); ++i)
    for (std::size_t j = 0; j < spheres.size(); ++j) {
      if (i == j) continue;
      const Sphere &a = spheres[i], &b = spheres[j];
      const double d = (b.position - a.position).norm(), overlap = a.radius + b.radius - d;
      const Vec3 n = (b.position - a.position) / d;
      Vec3 force = Vec3::Zero(), torque = Vec3::Zero();  // on a
      if (overlap > -law.cohesion_range) force += law.cohesion * n;
      if (overlap > 0) {
        const double m = 1 / (1 / a.mass + 1 / b.mass),
                     r = a.radius * b.radius / (a.radius + b.radius);
        const double kappa = d / (a.radius + b.radius);
        const Textbook t = textbook(s, overlap, r);
        const Vec3 u =
            b.velocity - a.velocity - kappa * (a.radius * a.spin + b.radius * b.spin).cross(n);
        const double un = u.dot(n), c = law.damping * std::sqrt(t.slope * m);
        const double fn = t.force - c * un;
        const Vec3 ut = u - un * n;
        Vec3 ft = (t.tangential * h + law.tangential_damping * c) * ut;  // on a
        const double bound = contact.friction * std::abs(fn + t.attraction);
        if (ft.norm() > bound) ft *= bound / ft.norm();
        force += ft - fn * n;
        torque = kappa * a.radius * n.cross(ft);
        if (s.rolling_friction > 0) {
          const Vec3 v = r * (b.spin - a.spin).cross(n);
          Vec3 f = t.tangential * h * v;
          const double most = s.rolling_friction * std::abs(fn + t.attraction);
          if (f.norm() > most) f *= most / f.norm();
          torque += r * n.cross(f);
        }
      }
      after[i].velocity += h / a.mass * force;
      after[i].spin += h / (0.4 * a.mass * a.radius * a.radius) * torque;
    }
  return after;
}

TEST(Penalty, step_equals_the_sum_over_all_pairs) {
  for (double radii : {0.0, 0.3})
    for (PenaltySettings s : {hooke, hertz, sticky(Adhesion::dmt), sticky(Adhesion::jkr)})
      for (double rolling : {0.0, 0.1})
        for (double cohesion : {0.0, 3000.0}) {
          s.rolling_friction = rolling;
          ContactLaw contact = contact_law(0.4, 0.5);
          contact.cohesion = cohesion;
          contact.cohesion_range = 0.1;
          const auto spheres = crowd(150, radii, 0.3);
          Lab world = penalty_world(testing_world(), spheres, s, contact);
          const double h = 1e-4;
          const auto expected = kicked(spheres, s, contact, h);
          penalty_steps(world, h, 1);
          const auto now = spheres_of(world);
          double most = 0, turned = 0;
          for (std::size_t k = 0; k < now.size(); ++k) {
            most = std::max(most, (expected[k].velocity - spheres[k].velocity).norm());
            turned = std::max(turned, (expected[k].spin - spheres[k].spin).norm());
          }
          for (std::size_t k = 0; k < now.size(); ++k) {
            ASSERT_LE((now[k].velocity - expected[k].velocity).norm(), 1e-11 * most) << k;
            ASSERT_LE((now[k].spin - expected[k].spin).norm(), 1e-11 * turned) << k;
          }
        }
}

/// Two spheres that press on each other, ten times as large as those that lie on them.
std::vector<Sphere> boulders_on_giants() {
  std::vector<Sphere> spheres;
  for (double x : {0.0, -19.9})
    spheres.push_back({.radius = 10,
                       .mass = 1e6,
                       .position = {x, 0, 0},
                       .velocity = {-0.01 * x, 0.1, 0},
                       .spin = {0.01, 0.02, 0.03}});
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (Sphere s : crowd(150, 0.3, 0.3)) {
    const Vec3 to = Vec3(normal(random), normal(random), normal(random)).normalized();
    s.position = spheres[to.x() < 0 ? 1 : 0].position + (9.9 + s.radius) * to;
    bool free = true;
    for (const Sphere& other : spheres)
      free = free && (s.position - other.position).norm() > s.radius + other.radius - 0.11;
    if (free) spheres.push_back(s);
  }
  return spheres;
}

TEST(Penalty, giants_feel_all_that_lies_on_them) {
  PenaltySettings s = sticky(Adhesion::dmt);
  s.rolling_friction = 0.1;
  const ContactLaw contact = contact_law(0.4, 0.5);
  const auto spheres = boulders_on_giants();
  Lab world = penalty_world(testing_world(), spheres, s, contact);
  const double h = 1e-4;
  const auto expected = kicked(spheres, s, contact, h);
  penalty_steps(world, h, 1);
  const auto now = spheres_of(world);
  double most = 0;
  for (std::size_t k = 0; k < now.size(); ++k)
    most = std::max(most, (expected[k].velocity - spheres[k].velocity).norm());
  for (std::size_t k = 0; k < now.size(); ++k)
    ASSERT_LE((now[k].velocity - expected[k].velocity).norm(), 1e-11 * most) << k;
  // A search by the giants' size would list all pairs, each once.
  EXPECT_LT(world.penalty.touch.pairs, 0.1 * static_cast<double>(spheres.size() * spheres.size()));

  Lab one = penalty_world(alone(), spheres, s, contact);
  penalty_steps(one, h, 100);
  penalty_steps(world, h, 99);
  const auto a = spheres_of(one), b = spheres_of(world);
  for (std::size_t k = 0; k < a.size(); ++k)
    EXPECT_LE((a[k].position - b[k].position).norm(), 1e-10) << k;
}

TEST(Penalty, momenta_are_kept_to_round_off) {
  PenaltySettings s = sticky(Adhesion::jkr);
  s.rolling_friction = 0.2;
  const auto spheres = crowd(200, 0.3, 1.0);
  Lab world = penalty_world(testing_world(), spheres, s, contact_law(0.5, 0.6));
  const Sums before = sums_of(spheres);
  double scale = 0, turn = 0;
  for (const Sphere& a : spheres) {
    scale += a.mass * a.velocity.norm();
    turn += a.mass * a.velocity.norm() * a.position.norm();
  }
  penalty_steps(world, 2e-4, 500);
  const Sums after = sums_of(spheres_of(world));
  EXPECT_LE((after.momentum - before.momentum).norm(), 1e-13 * scale);
  EXPECT_LE((after.angular - before.angular).norm(), 1e-13 * turn);
  EXPECT_GT(world.comm.sum(world.ledger.dissipated), 0.1 * before.kinetic);
  EXPECT_GT(world.penalty.touch.searches, 1);
}

TEST(Penalty, energy_of_contacts_is_the_same_after_their_springs_are_kept) {
  // Whether a neck holds two grains that do not touch is told by what they remember.
  Lab world = penalty_world(testing_world(), crowd(200, 0.3, 1.0), sticky(Adhesion::jkr),
                            contact_law(0.5, 0.6));
  penalty_steps(world, 2e-4, 300);
  const double held = world.penalty.energy(world);
  world.penalty.restart_pairs(world, world.penalty.remember(world));
  EXPECT_NEAR(world.penalty.energy(world), held, 1e-12 * std::abs(held));
}

TEST(Penalty, motion_is_the_same_on_any_number_of_ranks) {
  PenaltySettings s = hertz;
  s.rolling_friction = 0.1;
  const auto spheres = crowd(200, 0.3, 1.0);
  Lab one = penalty_world(alone(), spheres, s, contact_law(0.5, 0.6));
  Lab many = penalty_world(testing_world(), spheres, s, contact_law(0.5, 0.6));
  penalty_steps(one, 2e-4, 200);
  for (int k = 0; k < 200; ++k) penalty_steps(many, 2e-4, 1);
  const auto a = spheres_of(one), b = spheres_of(many);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_LE((a[k].position - b[k].position).norm(), 1e-10) << k;
    EXPECT_LE((a[k].spin - b[k].spin).norm(), 1e-9) << k;
  }
}

TEST(Penalty, needs_neither_the_field_of_gravity_nor_that_of_potentials) {
  const auto spheres = crowd(200, 0.3, 1.0);
  Lab full = penalty_world(testing_world(), spheres, hertz, contact_law(0.5, 0.6));
  Lab lean = penalty_world(testing_world(), spheres, hertz, contact_law(0.5, 0.6));
  set_fields(lean.bodies, {Field::angular_velocity, Field::heat});
  penalty_steps(full, 2e-4, 100);
  penalty_steps(lean, 2e-4, 100);
  const auto a = spheres_of(full), b = spheres_of(lean);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_EQ(a[k].position, b[k].position) << k;
    EXPECT_EQ(a[k].spin, b[k].spin) << k;
  }
  lean.uniform_gravity = {0, 0, -1};  // needs none by itself
  EXPECT_NO_THROW(penalty_steps(lean, 2e-4, 1));
  lean.gravity.method = GravityMethod::direct;
  EXPECT_THROW(penalty_steps(lean, 2e-4, 1), Error);
}

TEST(Penalty, springs_survive_searches_and_migration) {
  PenaltySettings s = sticky(Adhesion::jkr);
  s.rolling_friction = 0.1;
  const auto spheres = crowd(100, 0.3, 1.0);
  const auto run = [&](auto&& disturb) {
    Lab world = penalty_world(testing_world(), spheres, s, contact_law(0.5, 0.6));
    for (int k = 0; k < 60; ++k) {
      penalty_steps(world, 2e-4, 1);
      disturb(world);
    }
    return spheres_of(world);
  };
  const auto expected = run([](Lab&) {});
  const auto expect_same = [&](const std::vector<Sphere>& now) {
    for (std::size_t k = 0; k < now.size(); ++k)
      EXPECT_LE((now[k].spin - expected[k].spin).norm(), 1e-10) << k;
  };
  expect_same(run([](Lab& world) { world.penalty.touch.skin = 0; }));
  expect_same(run([](Lab& world) {
    world.penalty.touch.skin = 0;
    world.penalty.touch.last_cut = {};  // never cut: the next search cuts
  }));
  expect_same(run([](Lab& world) {
    const PairMemory memory = world.penalty.remember(world);
    world.penalty.restart_pairs(world, memory);
    EXPECT_EQ(&*world.penalty.touch.carried, &*memory.contacts) << "one copy";
    EXPECT_EQ(&*world.penalty.remember(world).contacts, &*memory.contacts);
  }));
}

TEST(Penalty, spring_of_a_sphere_that_sticks_swings_on_unless_there_is_tangential_damping) {
  // On the ground, with a friction that holds: the point of contact moves as a spring k_t on 2/7 m
  // does, u = u0 exp(-c_t t/(4/7 m)) cos(omega t), and the centre as 5/7 u0 + 2/7 u.
  const double r = 0.1, m = 10, k = 1e6, weight = 98.1, u0 = 0.01, h = 2e-5;
  const double omega = std::sqrt(3.5 * 2 / 7.0 * k / m), period = 2 * pi / omega;
  for (double ratio : {0.0, 0.02}) {
    PenaltySettings s = hooke;
    s.tangential_damping = ratio;
    Lab world = penalty_world(
        alone(),
        {{.radius = r, .mass = m, .position = {0, 0, r - weight / k}, .velocity = {u0, 0, 0}}}, s,
        contact_law(0.5, 0.3));
    world.planes = {{}};
    world.uniform_gravity = {0, 0, -weight / m};
    const PenaltyLaw law = penalty_laws(world, s).common();
    const double damping = ratio * law.damping * std::sqrt(k * m);  // N s/m, c_t
    penalty_steps(world, h, std::lround(4.5 * period / h));
    double most = 0;
    for (int step = 0; step < std::lround(period / h); ++step) {
      penalty_steps(world, h, 1);
      most = std::max(most, spheres_of(world)[0].velocity.x());
    }
    const double swing = 2 / 7.0 * u0 * std::exp(-1.75 * damping / m * 5 * period);
    // Of first order in the step.
    EXPECT_NEAR(most, 5 / 7.0 * u0 + swing, omega * h * 2 / 7.0 * u0) << ratio;
  }
}

TEST(Penalty, books_close_to_first_order) {
  // Damping alone and friction alone: their errors have different signs.
  for (const ContactLaw& contact : {contact_law(0, 0.6), contact_law(0.5, 1)}) {
    const auto spheres = crowd(100, 0.2, 1.0);
    std::vector<double> errors;
    double lost = 0;
    for (int halvings = 0; halvings < 3; ++halvings) {
      Lab world = penalty_world(testing_world(), spheres, sticky(Adhesion::jkr), contact);
      const int steps = 200 << halvings;
      const double before = sums_of(spheres).kinetic + contact_energy(world);
      penalty_steps(world, 0.1 / steps, steps);
      lost = world.comm.sum(world.ledger.dissipated);
      errors.push_back(
          std::abs(sums_of(spheres_of(world)).kinetic + contact_energy(world) + lost - before));
    }
    EXPECT_GT(lost, 0.1 * sums_of(spheres).kinetic);
    EXPECT_LT(errors[2], 0.03 * lost);
    for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 1, 0.3);
  }
}

}  // namespace
}  // namespace spall
