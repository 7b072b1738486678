// Penalty contact in scenes with known answers: measured oblique impacts, bonds that are pulled,
// columns, rolling, and what a run refuses.
// SPDX-License-Identifier: BSD-3-Clause
#include <fstream>
#include <sstream>

#include "output/diagnostics.hpp"
#include "penalty_worlds.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double g = 9.81;

TEST(PenaltyScene, oblique_impacts_are_those_that_were_measured) {
  if (testing_world().rank > 0) return;  // small and long: one rank does it
  const Material alumina{.name = "Al2O3", .youngs_modulus = 360e9, .poisson_ratio = 0.23};
  const Material glass{.name = "glass", .youngs_modulus = 70e9, .poisson_ratio = 0.25};
  std::ifstream data(MEASURED);
  int rows = 0;
  for (std::string line; std::getline(data, line);) {
    std::istringstream words(line);
    std::string quantity;
    double angle, measured;
    char comma;
    if (!std::getline(words, quantity, ',') || !(words >> angle >> comma >> measured)) continue;
    const double theta = angle * pi / 180, speed = 3.9, r = 2.5e-3;
    const Vec3 v{speed * std::sin(theta), 0, -speed * std::cos(theta)};
    Lab world = penalty_world(alone(),
                              {{.radius = r,
                                .mass = 4000 * 4 / 3.0 * pi * r * r * r,
                                .position = {0, 0, r * 1.0001},
                                .velocity = v}},
                              {}, {.friction = 0.092, .restitution = 0.98});
    world.materials = {alumina, glass};
    world.planes = {{.material = 1}};
    penalty_steps(world, 5e-9, 5000);
    const Sphere after = spheres_of(world)[0];
    ASSERT_GT(after.velocity.z(), 0);
    // The measured spin at 6 degrees is that of e_t = 0.67, between 0.745 and 0.673 measured at 3.7
    // and 9.5; the solution with slip in the rim (Cattaneo, Mindlin) is 14 % below it as well.
    if (quantity == "e_t") {
      EXPECT_NEAR(after.velocity.x() / v.x(), measured, 0.05) << angle;
    } else if (quantity == "omega") {
      EXPECT_NEAR(after.spin.y(), measured, (angle < 15 ? 0.25 : 0.08) * measured) << angle;
    }
    rows += quantity != "rebound_angle";
  }
  EXPECT_EQ(rows, 15);
}

/// A sphere that never moves and one below it, pulled down by this part of the bond's strength.
struct Pulled {
  double early, late;  ///< m, furthest fall in the first and last tenth
  bool parted;
};
Pulled pull(const PenaltySettings& settings, const ContactLaw& contact, double strength,
            double part, int steps) {
  constexpr int looks = 10000;
  const double start = -0.9999;
  Lab world = penalty_world(
      alone(),
      {{.radius = 0.5, .mass = infinity}, {.radius = 0.5, .mass = 1000, .position = {0, 0, start}}},
      settings, contact);
  world.uniform_gravity = {0, 0, -part * strength / 1000};
  Pulled p{0, 0, false};
  for (int look = 0; look < looks; ++look) {
    for (int k = 0; k < steps / looks; ++k) penalty_steps(world, 1e-4, 1);
    double fall = 0;
    for (Index b = 0; b < world.bodies.owned; ++b)
      fall = std::max(fall, start - world.bodies.position[b].z());
    if (look < looks / 10) p.early = std::max(p.early, fall);
    if (look >= looks - looks / 10) p.late = std::max(p.late, fall);
    if (fall > 1) return {p.early, fall, true};
  }
  return p;
}

TEST(PenaltyScene, bond_holds_a_pull_below_its_strength_and_parts_above) {
  const Comm& comm = testing_world();  // small and long: each rank does some
  const double w = 500, r = 0.25;
  const PenaltySettings hooke{.model = PenaltyModel::hooke, .stiffness = 1e7};
  const PenaltySettings hertz;  // of soft_rock
  PenaltySettings dmt = hertz, jkr = hertz;
  dmt.adhesion_strength = jkr.adhesion_strength = w;
  dmt.adhesion = Adhesion::dmt;
  jkr.adhesion = Adhesion::jkr;
  int turn = 0;
  for (double restitution : {0.5, 1.0}) {
    const ContactLaw plain{.restitution = restitution};
    ContactLaw cohesive = plain;
    cohesive.cohesion = 1000;
    cohesive.cohesion_range = 0.01;
    struct Bond {
      PenaltySettings settings;
      ContactLaw contact;
      double strength;
    };
    for (const Bond& bond :
         {Bond{hooke, cohesive, 1000}, Bond{hertz, cohesive, 1000},
          Bond{dmt, plain, 2 * pi * w * r}, Bond{jkr, plain, 1.5 * pi * w * r}}) {
      if (turn++ % comm.size != comm.rank) continue;
      // Nothing damps what swings for ever: twice its static strain must hold.
      const bool swings = restitution == 1;
      const int steps = swings || bond.settings.model == PenaltyModel::hooke ? 100000 : 200000;
      const Pulled held =
          pull(bond.settings, bond.contact, bond.strength, swings ? 0.3 : 0.8, steps);
      EXPECT_FALSE(held.parted) << bond.strength;
      EXPECT_LE(held.late, swings ? 1.001 * held.early : held.early) << bond.strength;
      EXPECT_TRUE(pull(bond.settings, bond.contact, bond.strength, 1.05, 20000).parted)
          << bond.strength;
    }
  }
}

TEST(PenaltyScene, jkr_contact_parts_at_its_pull_off_force_and_not_where_it_formed) {
  if (testing_world().rank > 0) return;  // small and long: one rank does it
  // Loaded slowly by a growing weight: it parts at 3/2 pi w R.
  const double w = 500, r = 0.25, strength = 1.5 * pi * w * r;
  const PenaltySettings s{.adhesion = Adhesion::jkr, .adhesion_strength = w};
  Lab world = penalty_world(
      alone(),
      {{.radius = 0.5, .mass = infinity}, {.radius = 0.5, .mass = 10, .position = {0, 0, -0.9999}}},
      s, {.restitution = 0.2});
  double pulled = 0, gap = 0;
  for (int k = 0; k < 40000; ++k) {
    pulled = 1.2 * strength * k / 40000;
    world.uniform_gravity = {0, 0, -pulled / 10};
    penalty_steps(world, 1e-4, 1);
    double now = 0;
    for (Index b = 0; b < world.bodies.owned; ++b)
      now = std::max(now, -world.bodies.position[b].z() - 1);
    if (now > 2e-3) break;
    gap = std::max(gap, now);
  }
  EXPECT_NEAR(pulled, strength, 0.05 * strength);  // it takes time to part
  EXPECT_GT(pulled, 0.999 * strength);
  EXPECT_GT(gap, 0);  // the neck
}

TEST(PenaltyScene, overlaps_of_a_column_carry_the_weight_above) {
  if (testing_world().rank > 0) return;  // small and long: one rank does it
  const double k = 1e6, m = 10, r = 0.1;
  const int count = 6;
  std::vector<Sphere> spheres;
  for (int i = 0; i < count; ++i)
    spheres.push_back({.radius = r, .mass = m, .position = {0, 0, (2 * i + 1) * r}});
  Lab world = penalty_world(alone(), spheres, {.model = PenaltyModel::hooke, .stiffness = k},
                            {.friction = 0.5, .restitution = 0.1});
  world.planes = {{}};
  world.uniform_gravity = {0, 0, -g};
  penalty_steps(world, 2e-4, 1);
  for (int step = 0; step < 20000; ++step) penalty_steps(world, 2e-4, 1);
  const auto s = spheres_of(world);
  // Gravity's kick comes half a step before that of the ground, whose dashpot feels g h/2
  // meanwhile.
  const double lag = 1.05 * penalty_laws(world, world.penalty.settings).common().damping *
                     std::sqrt(k * m) * g * 1e-4 / k;
  for (int i = 0; i < count; ++i) {
    const double below = i == 0 ? -r : s[i - 1].position.z();
    const double overlap = 2 * r - (s[i].position.z() - below);
    EXPECT_NEAR(overlap, (count - i) * m * g / k, i == 0 ? lag : 1e-6 * m * g / k) << i;
  }
}

/// A sphere on the ground, or on a slope, for `time`; its speed along x and its spin about y.
Sphere on_ground(double friction, double rolling, double speed, const Vec3& gravity, double time) {
  const double r = 0.1, m = 10, k = 1e6;
  Lab world =
      penalty_world(alone(),
                    {{.radius = r,
                      .mass = m,
                      .position = {0, 0, r + gravity.z() * m / k},
                      .velocity = {speed, 0, 0}}},
                    {.model = PenaltyModel::hooke, .stiffness = k, .rolling_friction = rolling},
                    {.friction = friction, .restitution = 0.3});
  world.planes = {{}};
  world.uniform_gravity = gravity;
  const double h = 1e-4;
  for (int step = 0; step < std::lround(time / h); ++step) penalty_steps(world, h, 1);
  return spheres_of(world)[0];
}

TEST(PenaltyScene, sliding_sphere_starts_to_roll) {
  const double mu = 0.3, v0 = 1, t = 2 * v0 / (7 * mu * g), r = 0.1;
  const Sphere sliding = on_ground(mu, 0, v0, {0, 0, -g}, 0.9 * t);
  EXPECT_NEAR(sliding.velocity.x(), v0 - mu * g * 0.9 * t, 2e-3 * v0);
  EXPECT_GT(sliding.velocity.x() - r * sliding.spin.y(), 0.05 * v0);
  const Sphere rolls = on_ground(mu, 0, v0, {0, 0, -g}, 1.5 * t);
  EXPECT_NEAR(rolls.velocity.x(), 5 / 7.0 * v0, 5e-3 * v0);
  EXPECT_NEAR(rolls.velocity.x(), r * rolls.spin.y(), 5e-3 * v0);
}

TEST(PenaltyScene, sphere_on_a_slope_rolls_slides_or_is_held_by_rolling_friction) {
  const double theta = 0.4, time = 0.5;  // tan = 0.42: rolls for mu > 0.12
  const Vec3 gravity = g * Vec3(std::sin(theta), 0, -std::cos(theta));
  const double along = g * std::sin(theta);
  EXPECT_NEAR(on_ground(0.5, 0, 0, gravity, time).velocity.x(), 5 / 7.0 * along * time,
              0.01 * along * time);
  EXPECT_NEAR(on_ground(0.05, 0, 0, gravity, time).velocity.x(),
              (along - 0.05 * g * std::cos(theta)) * time, 0.01 * along * time);
  // On a wall R is r: the torque of the weight m g sin r is held up to mu_r m g cos r.
  EXPECT_LT(std::abs(on_ground(0.8, 0.5, 0, gravity, time).velocity.x()), 0.02 * along * time);
  EXPECT_GT(on_ground(0.8, 0.3, 0, gravity, time).velocity.x(), 0.1 * along * time);
}

TEST(PenaltyScene, a_pair_across_the_boundary_is_a_pair) {
  // The same crowd as it is, and moved so that it is cut by the sides of the box that repeats.
  const auto spheres = crowd(60, 0.2, 1.0);
  auto moved = spheres;
  const Period period{.low = {-20, -20, -20}, .size = {40, 40, 40}};
  for (Sphere& s : moved) s.position = period.wrapped(s.position + Vec3(20, 19, 18));
  const PenaltySettings settings;
  const ContactLaw contact{.friction = 0.5, .restitution = 0.6};
  Lab here = penalty_world(testing_world(), spheres, settings, contact);
  Lab there = penalty_world(testing_world(), moved, settings, contact);
  there.period = period;
  penalty_steps(here, 2e-4, 300);
  penalty_steps(there, 2e-4, 300);
  const auto a = spheres_of(here), b = spheres_of(there);
  EXPECT_GT(here.penalty.touch.searches, 1);
  for (std::size_t k = 0; k < a.size(); ++k) {
    EXPECT_LE((a[k].velocity - b[k].velocity).norm(), 1e-8) << k;
    EXPECT_LE((a[k].spin - b[k].spin).norm(), 1e-8) << k;
  }
  there.period.size[1] = 4;
  there.penalty.touch = TouchPairs{};
  EXPECT_THROW(penalty_steps(there, 2e-4, 1), Error);
}

TEST(PenaltyScene, what_rubs_across_the_boundary_rubs_alike_from_both_sides) {
  // Springs last through searches, in which either side finds those of its own image of a pair.
  const int side = 5, count = side * side * side;
  const double edge = 5.5;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Sphere> spheres;
  for (int k = 0; k < count; ++k) {
    const double x = normal(random), y = normal(random), z = normal(random);
    spheres.push_back({.radius = 0.5,
                       .position = edge / side * Vec3(k % side, k / side % side, k / side / side),
                       .velocity = {x, y, z}});
  }
  Lab world = penalty_world(testing_world(), spheres, {.rolling_friction = 0.1},
                            {.friction = 0.5, .restitution = 0.6});
  world.period.size = Vec3::Constant(edge);
  const Diagnostics before = diagnose(world);
  penalty_steps(world, 4e-5, 6000);
  const Diagnostics after = diagnose(world);
  EXPECT_LT((after.momentum - before.momentum).norm(), 1e-12 * before.momentum_scale);
  EXPECT_GT(after.dissipated, 0.02 * before.kinetic);
  EXPECT_GT(world.penalty.touch.searches, 3);
}

TEST(PenaltyScene, no_collision_of_a_gas_is_missed) {
  // Free flights many skins long, images across every face, two sizes.
  const int side = 6, count = side * side * side;
  const double edge = 12;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  std::vector<Sphere> spheres;
  for (int k = 0; k < count; ++k) {
    const double x = normal(random), y = normal(random), z = normal(random);
    spheres.push_back({.radius = k % 3 == 0 ? 0.6 : 0.5,
                       .position = edge / side * Vec3(k % side, k / side % side, k / side / side),
                       .velocity = {x, y, z}});
  }
  Lab world = penalty_world(testing_world(), spheres,
                            {.model = PenaltyModel::hooke, .stiffness = 5e4}, {.restitution = 0.9});
  world.period.size = Vec3::Constant(edge);
  const double h = 4.5e-4;
  std::int64_t seen = 0;
  for (int k = 0; k < 40; ++k) {
    penalty_steps(world, h, 300);
    // Forces were those of the middle of the last step.
    auto now = spheres_of(world);
    for (Sphere& s : now) s.position -= h / 2 * s.velocity;
    std::int64_t expected = 0;
    for (int i = 0; i < count; ++i)
      for (int j = 0; j < i; ++j) {
        Vec3 x = now[i].position - now[j].position;
        for (double& c : x) c = std::remainder(c, edge);
        expected += x.norm() < now[i].radius + now[j].radius;
      }
    ASSERT_EQ(world.comm.sum(count_touching(world.bodies, world.penalty.touch)), expected) << k;
    seen += expected;
  }
  EXPECT_GT(seen, 40);
  EXPECT_GT(world.penalty.touch.searches, 3);
}

/// T over that of Haff's law at 1, 2, ... 5 tau, and T at the end over that at the start.
std::vector<double> cooling_of_a_gas(unsigned seed) {
  // T = T0/(1 + t/tau)^2, 1/tau = (1 - e^2) w_E/6, w_E = 4 n d^2 g sqrt(pi T/m).
  const double e = 0.9, r = 0.5, m = 1, phi = 0.1;
  const int side = 10, count = side * side * side;
  const double edge = std::cbrt(count * 4 / 3.0 * pi * r * r * r / phi), cell = edge / side;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  std::vector<Sphere> spheres;
  Vec3 mean = Vec3::Zero();
  for (int k = 0; k < count; ++k) {
    const double x = normal(random), y = normal(random), z = normal(random);
    spheres.push_back({.radius = r,
                       .mass = m,
                       .position = cell * Vec3(k % side, k / side % side, k / side / side),
                       .velocity = {x, y, z}});
    mean += spheres.back().velocity / count;
  }
  for (Sphere& s : spheres) s.velocity -= mean;
  Lab world = penalty_world(alone(), spheres, {.model = PenaltyModel::hooke, .stiffness = 5e4},
                            {.restitution = e});
  world.period.size = Vec3::Constant(edge);
  const auto temperature = [&] {
    double sum = 0;
    for (Index b = 0; b < world.bodies.owned; ++b)
      sum += m * world.bodies.velocity[b].squaredNorm();
    return world.comm.sum(sum) / (3 * count);
  };
  // Velocities become those of a gas first.
  const double h = 4.5e-4;
  penalty_steps(world, h, 2000);
  const double start = temperature(), n = count / (edge * edge * edge);
  const double crowding = (1 - phi / 2) / std::pow(1 - phi, 3);
  const double rate = 4 * n * 4 * r * r * crowding * std::sqrt(pi * start / m);
  const double tau = 6 / ((1 - e * e) * rate);
  std::vector<double> ratios;
  for (int step = 0; step * h < 5 * tau;) {
    const int steps = static_cast<int>(tau / h);
    penalty_steps(world, h, steps);
    step += steps;
    const double expected = start / std::pow(1 + step * h / tau, 2);
    ratios.push_back(temperature() / expected);
  }
  ratios.push_back(temperature() / start);
  return ratios;
}

TEST(PenaltyScene, gas_of_inelastic_spheres_cools_as_haff_says) {
  if (testing_world().size > 1) return;  // small and long: one rank does it
  // A thousand spheres scatter by 0.02 about a mean 0.025 above the law, which is of dilute gases
  // (ten seeds). The mean of three is told here, with three times what it scatters by.
  std::vector<std::vector<double>> gases;
  for (unsigned seed : {1u, 2u, 3u}) gases.push_back(cooling_of_a_gas(seed));
  for (std::size_t k = 0; k + 1 < gases[0].size(); ++k) {
    double mean = 0;
    for (const auto& gas : gases) {
      EXPECT_NEAR(gas[k], 1, 0.1) << k;
      mean += gas[k] / static_cast<double>(gases.size());
    }
    EXPECT_NEAR(mean, 1, 0.025 + 3 * 0.02 / std::sqrt(3)) << k;
  }
  for (const auto& gas : gases) EXPECT_LT(gas.back(), 0.03);  // 1/36 by the law
}

TEST(PenaltyScene, sphere_in_a_cylinder_swings_like_a_pendulum_and_bounces_off_it) {
  if (testing_world().rank > 0) return;  // small and long: one rank does it
  const double wall = 1, r = 0.1, m = 10, k = 1e7, arm = wall - r, angle = 0.1, h = 2e-5;
  const PenaltySettings settings{.model = PenaltyModel::hooke, .stiffness = k};
  for (double friction : {0.0, 0.5}) {
    const Vec3 at = arm * Vec3(std::sin(angle), 0, -std::cos(angle)) + Vec3(2, 3, 4);
    Lab world = penalty_world(alone(), {{.radius = r, .mass = m, .position = at}}, settings,
                              {.friction = friction, .restitution = 0.2});
    world.cylinders = {{.point = {2, -1, 4}, .axis = {0, 1, 0}, .radius = wall}};
    world.uniform_gravity = {0, 0, -g};
    // To the lowest point in a quarter of the period; rolling it carries 7/5 of its mass along.
    const double quarter =
        pi / 2 * std::sqrt((friction > 0 ? 1.4 : 1) * arm / g) * (1 + angle * angle / 16);
    int steps = 0;
    while (spheres_of(world)[0].position.x() > 2 && steps * h < 2 * quarter) {
      penalty_steps(world, h, 1);
      ++steps;
    }
    EXPECT_NEAR(steps * h, quarter, 2e-3 * quarter) << friction;
    EXPECT_NEAR(spheres_of(world)[0].position.y(), 3, 1e-12);
  }
  const Vec3 out = Vec3(3, 0, 4) / 5;
  Lab world = penalty_world(alone(), {{.radius = r, .mass = m, .velocity = out}}, settings,
                            {.restitution = 0.6});
  world.cylinders = {{.point = {0, 1, 0}, .axis = {0, 1, 0}, .radius = wall}};
  penalty_steps(world, h, 60000);
  EXPECT_LE((spheres_of(world)[0].velocity + 0.6 * out).norm(), 1e-3);
}

TEST(PenaltyScene, what_cannot_be_resolved_is_refused_with_what_would_do) {
  const auto message = [&](double h, double speed, const PenaltySettings& s,
                           double modulus = 5e10) -> std::string {
    std::vector<Sphere> spheres{
        {.radius = 1, .mass = 4000, .position = {-3, 0, 0}, .velocity = {speed, 0, 0}},
        {.radius = 1, .mass = 4000},
        {.radius = 0.5, .mass = 500, .position = {3, 0, 0}},
        {.radius = 0.4, .mass = 250, .position = {6, 0, 0}}};
    Lab world = penalty_world(testing_world(), spheres, s, {.restitution = 0.5});
    world.materials[0].youngs_modulus = modulus;
    return complaint_of([&] { check_penalty_step(world, s, h, speed, "case.toml:7"); });
  };
  const PenaltySettings soft{.model = PenaltyModel::hooke, .stiffness = 1e8};
  const double m = 1 / (1 / 500.0 + 1 / 250.0), limit = 0.15 * std::sqrt(m / 1e8);
  EXPECT_EQ(message(0.99 * limit, 1, soft), "");
  const std::string too_long = message(1.01 * limit, 1, soft);
  for (const std::string& part : {std::string("case.toml:7"), std::string("body 3"),
                                  std::string("body 2"), fmt::format("{:.3g} s", limit)})
    EXPECT_NE(too_long.find(part), std::string::npos) << too_long;
  // 6.7 km/s: m v^2 = k (r/2)^2 for the two that are heaviest for their size.
  const std::string through = message(1e-9, 6700, soft);
  EXPECT_NE(through.find("body 0"), std::string::npos) << through;
  EXPECT_NE(through.find(fmt::format("{:.3g} N/m", 2000 * 6700.0 * 6700.0 / 0.25)),
            std::string::npos)
      << through;
  const std::string hertz = message(1e-9, 6700, {});
  EXPECT_NE(hertz.find("materials.rock.youngs_modulus must be at least"), std::string::npos)
      << hertz;
  const double harder = std::stod(hertz.substr(hertz.find("at least") + 8)) * 1.01;
  EXPECT_EQ(message(1e-9, 6700, {}, harder), "");
}

}  // namespace
}  // namespace spall
