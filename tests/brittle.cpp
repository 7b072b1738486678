// Solids that break by cracks from flaws: how many there are, the strength that they leave at a
// rate, what broken matter bears, books, ranks, refusals.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "scene/scene.hpp"
#include "solid/flaws.hpp"
#include "solid_worlds.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3;  // m

const std::string rock = R"([[groups]]
name = "rock"
material = "rock"
volume = {shape = "sphere", radius = "3 mm"}
packing = {kind = "fcc", diameter = "1 mm"}
[[phases]]
name = "only"
method = "solid"
step = "10 ns"
duration = "20 ns"
[materials.rock]
library = "basalt"
[materials.rock.solid]
)";
/// Basalt as Benz and Asphaug have it: von Mises' strength, and what has failed is dust.
const Solid& basalt() {
  static const Solid solid = [] {
    Solid known = *parse_case(rock, "x.toml").materials[0].solid;
    known.rock = {};
    known.yield_strength = 3.5e9;
    return known;
  }();
  return solid;
}
const SolidLaw& law() {
  static const SolidLaw law = solid_law(basalt(), true, "basalt");
  return law;
}
const double volume = d * d * d / std::sqrt(2.0);

/// Pa, of strain along one direction.
double modulus() {
  return law().bulk + 4 * law().shear / 3;
}

/// The strain that opens so many flaws of a body in the mean.
double strain_of(double flaws) {
  return std::pow(flaws / (law().flaws.k * volume), 1 / law().flaws.m);
}

// --- flaws ---

TEST(Flaws, are_as_many_as_weibull_says_and_independent) {
  constexpr int bodies = 20000;
  for (double expected : {0.05, 1.0, 20.0}) {
    double sum = 0, squares = 0;
    for (BodyId id = 0; id < bodies; ++id) {
      const double opened = open_flaws(law(), id, volume, strain_of(expected));
      sum += opened;
      squares += (opened - expected) * (opened - expected);
    }
    // Mean and variance of a Poisson process, within four standard errors.
    EXPECT_NEAR(sum / bodies, expected, 4 * std::sqrt(expected / bodies));
    EXPECT_NEAR(squares / bodies, expected,
                4 * std::sqrt((expected + 2 * expected * expected) / bodies));
  }
  EXPECT_NEAR(open_flaws(law(), 3, volume, strain_of(1e6)), 1e6, 1);
}

TEST(Flaws, of_other_bodies_and_seeds_are_others) {
  SolidLaw other = law();
  other.seed = 1;
  constexpr int bodies = 20000;
  const double strain = strain_of(1);
  double by_body = 0, by_seed = 0;  // covariances, of unit variances
  for (BodyId id = 0; id < bodies; ++id) {
    const double opened = open_flaws(law(), id, volume, strain) - 1;
    by_body += opened * (open_flaws(law(), id + 1, volume, strain) - 1);
    by_seed += opened * (open_flaws(other, id, volume, strain) - 1);
  }
  EXPECT_NEAR(by_body / bodies, 0, 4 / std::sqrt(bodies));
  EXPECT_NEAR(by_seed / bodies, 0, 4 / std::sqrt(bodies));
}

TEST(Flaws, once_open_stay_open_at_larger_strains) {
  for (BodyId id = 0; id < 100; ++id)
    for (double flaws = 0.1, before = 0; flaws < 200; flaws *= 1.3) {
      const double opened = open_flaws(law(), id, volume, strain_of(flaws));
      if (flaws < 64) {
        EXPECT_GE(opened, before);
      }
      before = opened;
    }
}

// --- stress ---

/// A ball whose bodies are held to a motion of constant strain rate (1/s) along x.
Lab pulled_ball(double rate, double damage = 0) {
  auto spheres = ball(d, basalt().density, turned, 3.2 * d);
  for (Sphere& s : spheres) {
    s.mass = infinity;
    s.velocity = {rate * s.position.x(), 0, 0};
  }
  Lab world = world_of(testing_world(), spheres, law());
  for (Index b = 0; b < world.bodies.owned; ++b) world.bodies.damage[b] = damage;
  return world;
}

/// The mean over all bodies of `f(bodies, row)`.
template <class F>
double mean_of(const Lab& world, F&& f) {
  double sum = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) sum += f(world.bodies, b);
  return world.comm.sum(sum) / world.comm.sum(static_cast<double>(world.bodies.owned));
}
double pull_of(const Bodies& bodies, Index b) {
  return bodies.direct_stress[b].x() - bodies.pressure[b];
}
double damage_of(const Bodies& bodies, Index b) {
  return bodies.damage[b];
}

// With n = k V eps^m, eps = rate t M/E, D = (c_g/R int n^(1/3) dt)^3
//   = (c_g/R)^3 k V (rate M/E)^m t^(m+3) / (1 + m/3)^3,
// and M rate t (1 - D) is largest where D = 1/(m + 4): as rate^(3/(m+3)) (Grady & Kipp).
TEST(Brittle, strength_grows_with_the_rate_as_grady_and_kipp_s) {
  const double m = law().flaws.m, radius = std::cbrt(3 * volume / (4 * pi));
  std::vector<double> strengths;
  const double factor = 4;
  for (double rate = 8e4; rate < 1e7; rate *= factor) {
    const double most = 1 / (m + 4), growth = std::pow(crack_speed(law()) / radius, 3);
    const double opened =
        law().flaws.k * volume * std::pow(rate * modulus() / law().youngs_modulus(), m);
    const double time = std::pow(most * std::pow(1 + m / 3, 3) / (growth * opened), 1 / (m + 3));
    const double expected = modulus() * rate * time * (1 - most);
    Lab world = pulled_ball(rate);
    double strength = 0;
    for (int step = 0; step < 300; ++step) {
      solid_steps(world, time / 200, 1);
      strength = std::max(strength, mean_of(world, pull_of));
    }
    EXPECT_NEAR(strength, expected, 0.01 * expected) << rate;
    EXPECT_GT(mean_of(world, damage_of), 0.9) << rate;
    strengths.push_back(strength);
  }
  const double exponent = std::log(strengths.back() / strengths.front()) /
                          (std::log(factor) * static_cast<double>(strengths.size() - 1));
  EXPECT_NEAR(exponent, 3 / (m + 3), 0.005);
}

TEST(Brittle, what_is_pressed_does_not_break) {
  Lab world = pulled_ball(-1e5);
  solid_steps(world, 5e-9, 100);
  EXPECT_EQ(mean_of(world, damage_of), 0);
  EXPECT_LT(mean_of(world, pull_of), -0.04 * modulus());
}

TEST(Brittle, cracks_take_their_share_of_tension_and_shear_but_none_of_pressure) {
  for (double damage : {0.0, 0.3, 1.0})
    for (double strain : {1e-5, -1e-5}) {  // no flaw opens
      Lab world = pulled_ball(strain / 1e-7, damage);
      solid_steps(world, 1e-8, 10);
      const Eigen::Matrix3d stress = stress_of_the_middle(world);
      const double mean = stress.trace() / 3, borne = 1 - damage;
      EXPECT_NEAR(mean, law().bulk * strain * (strain > 0 ? borne : 1), 1e-8 * law().bulk);
      EXPECT_NEAR(stress(0, 0) - mean, 4.0 / 3 * law().shear * strain * borne, 1e-8 * law().shear);
      // What is stretched is elastic: the work upon it can be had back.
      const Sums sums = sums_of(world);
      EXPECT_GT(sums.internal, damage == 1 && strain > 0 ? -1 : 0);
      EXPECT_LE(std::abs(sums.heat), 2e-3 * law().bulk * strain * strain * volume *
                                         static_cast<double>(spheres_of(world).size()))
          << damage << " " << strain;
    }
}

/// A ball that flies apart by its own motion, after steps of this share of a spacing.
struct Apart {
  Sums before, after;
  double damage = 0;
};
Apart fly_apart(double share) {
  auto spheres = ball(d, basalt().density, turned, 4.2 * d);
  for (Sphere& s : spheres) s.velocity = 3e3 * s.position + Vec3(300, 500, -700).cross(s.position);
  Lab world = world_of(testing_world(), spheres, law());
  const Sums before = sums_of(world);
  solid_steps(world, share * d / law().sound_speed(), static_cast<int>(std::lround(6 / share)));
  return {before, sums_of(world), mean_of(world, damage_of)};
}

TEST(Brittle, momenta_and_energy_are_kept_where_a_ball_flies_apart) {
  std::vector<double> errors;
  for (double share : {0.1, 0.025}) {
    const auto [before, after, damage] = fly_apart(share);
    const double momentum = before.kinetic / (3e3 * 4 * d);
    EXPECT_LE((after.momentum - before.momentum).norm(), 1e-12 * momentum);
    EXPECT_LE((after.angular - before.angular).norm(), 1e-12 * momentum * 4 * d);
    EXPECT_GT(after.heat, 0);  // what cracks set free
    EXPECT_GT(damage, 0.7);
    errors.push_back(std::abs(after.kinetic + after.internal - before.kinetic) / before.kinetic);
  }
  // A neighbour that fails takes its part in a body's gradient with it: an error of first order.
  EXPECT_LT(errors[0], 0.01);
  EXPECT_LT(errors[1], 0.35 * errors[0]);
}

TEST(Brittle, breaks_alike_on_any_number_of_ranks_and_after_a_restart) {
  auto spheres = ball(d, basalt().density, turned, 4.2 * d);
  for (Sphere& s : spheres) s.velocity = 3e3 * s.position;
  Lab one = world_of(alone(), spheres, law()), many = world_of(testing_world(), spheres, law());
  const double h = 0.1 * d / law().sound_speed();
  for (int part = 0; part < 2; ++part) {
    solid_steps(one, h, 40);
    solid_steps(many, h, 40);
    many.solid.restart_pairs(many, {});
  }
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-9 * d) << k;
  const double damage = mean_of(one, damage_of);
  EXPECT_GT(damage, 0.05);
  EXPECT_LT(damage, 0.95);
  EXPECT_NEAR(mean_of(many, damage_of), damage, 1e-9);
}

// --- how cases ask for it ---

std::string complaint(const std::string& more) {
  return complaint_of([&] { parse_case(rock + more, "x.toml"); });
}

TEST(BrittleCase, refuses_what_it_does_not_model) {
  EXPECT_EQ(complaint(""), "");
  EXPECT_EQ(complaint("spall_strength = \"1 GPa\""),
            "x.toml:1:1: groups.rock.material = \"rock\": weibull_k and spall_strength: a solid "
            "breaks by its flaws, or as metals do; leave one out");
  EXPECT_NE(complaint("johnson_cook_d1 = 0.5\nspecific_heat = 800\nmelting_point = 1500")
                .find("weibull_k and johnson_cook_d1"),
            std::string::npos);
}

TEST(BrittleCase, its_seed_draws_the_flaws) {
  const Case scene = parse_case("seed = 7\n" + rock, "x.toml");
  EXPECT_EQ(scene.engines.get<SolidSettings>().laws[0].seed, 7u);
}

TEST(BrittleCase, needs_both_constants_of_the_flaws) {
  Solid half = basalt();
  half.weibull.m = 0;
  EXPECT_EQ(complaint_of([&] { solid_law(half, true, "x"); }),
            "x: a solid with a stress needs weibull_m beside weibull_k");
  half.weibull = {.m = 9};
  EXPECT_EQ(complaint_of([&] { solid_law(half, true, "x"); }),
            "x: a solid with a stress needs weibull_k beside weibull_m");
}

}  // namespace
}  // namespace spall
