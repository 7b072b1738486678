// Bodies of two materials, each with its own law: forces, conservation, mixing, plates that meet.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include "pair_potentials.hpp"
#include "plate_impact.hpp"
#include "spall/error.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

/// Another solid: other stiffness, steepness and spacing.
const PairPotential other = [] {
  PairPotential p = embedded;
  p.depth = 1.6;
  p.steepness = 4.1;
  p.distance = 1.3;
  p.cutoff = (1 + 2 * p.breaking_strain) * p.distance;
  p.tension = 70;
  p.embedding = {.bulk_modulus = 90, .hugoniot_slope = 1.5, .gruneisen = 1.9, .density = 2.2};
  return p;
}();

ByPair<PairPotential> two_laws(const PairPotential& a, const PairPotential& b,
                               bool bonded = false) {
  ByPair<PairPotential> laws(2, PairPotential{});
  laws.set(0, 0, a);
  laws.set(1, 1, b);
  laws.set(0, 1, mixed_law(a, b, bonded));
  return laws;
}

/// Two balls of crystal, of materials and groups 0 and 1, that overlap a little where they meet.
struct Body : Sphere {
  int material = 0;
};
std::vector<Body> two_balls(double radius, double speed, double close, const PairPotential& a,
                            const PairPotential& b) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> motion(-0.1, 0.1);
  std::vector<Body> bodies;
  for (int m = 0; m < 2; ++m) {
    const double d = 0.98 * (m == 0 ? a : b).distance;
    const int n = static_cast<int>(radius / d * 1.5) + 1;
    for (int i = -n; i <= n; ++i)
      for (int j = -n; j <= n; ++j)
        for (int k = -n; k <= n; ++k) {
          const Vec3 x = d / std::sqrt(2.0) * Vec3(i, j, k);
          if ((i + j + k) % 2 != 0 || x.norm() > radius) continue;
          Body body;
          body.radius = d / 2;
          body.mass = m == 0 ? 1.0 : 2.5;
          body.position = x + Vec3((2 * m - 1) * close, 0.2 * m, 0.1 * m);
          body.velocity = {(1 - 2 * m) * speed + motion(random), motion(random), motion(random)};
          body.material = m;
          bodies.push_back(body);
        }
  }
  return bodies;
}

Lab world_of(const Comm& comm, const std::vector<Body>& bodies, const ByPair<PairPotential>& laws) {
  Lab world = make_world(comm, {bodies.begin(), bodies.end()}, {});
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.material[b] = world.bodies.group[b] = bodies[world.bodies.id[b]].material;
  world.potential.law = laws;
  return world;
}

double kinetic_energy(const Lab& world) {
  double energy = 0;
  for (const Sphere& s : spheres_of(world)) energy += s.mass * s.velocity.squaredNorm() / 2;
  return energy;
}

TEST(TwoSolids, a_mixed_bond_is_its_two_halves_in_series) {
  const PairPotential mixed = mixed_law(embedded, other, false);
  EXPECT_EQ(pair_force(mixed, 1.0001 * mixed.distance), 0);
  // A half of body a's bond is as long as half of it and twice as stiff: the same force where the
  // strain is the same.
  const auto strain_of = [](const PairPotential& p, double force) {
    double low = -0.3, high = 0;
    for (int halvings = 0; halvings < 60; ++halvings) {
      const double middle = (low + high) / 2;
      (pair_force(p, (1 + middle) * p.distance) > force ? low : high) = middle;
    }
    return low;
  };
  for (double strain : {-0.001, -0.01}) {
    const double force = pair_force(mixed, (1 + strain) * mixed.distance);
    const double halves = (strain_of(embedded, force) * embedded.distance +
                           strain_of(other, force) * other.distance) /
                          2;
    EXPECT_NEAR(halves, strain * mixed.distance, 20 * std::abs(strain * strain * strain));
  }
}

TEST(TwoSolids, forces_are_the_slope_of_the_energy) {
  for (bool bonded : {false, true}) {
    const auto laws = two_laws(embedded, other, bonded);
    auto bodies = two_balls(1.9, 0, 1.6, embedded, other);
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> shift(-0.04, 0.04);
    for (Body& b : bodies) {
      b.position += Vec3(shift(random), shift(random), shift(random));
      b.velocity.setZero();
    }
    Lab world = world_of(testing_world(), bodies, laws);
    const double h = 1e-7;
    potential_steps(world, h, 1);
    const auto after = spheres_of(world);
    double largest = 0;
    for (std::size_t b = 0; b < bodies.size(); ++b)
      largest = std::max(largest, after[b].mass * after[b].velocity.norm() / h);
    for (std::size_t b = 0; b < bodies.size(); b += 5)
      for (int axis = 0; axis < 3; ++axis) {
        const double step = 1e-5;
        const auto energy = [&](double way) {
          auto moved = bodies;
          moved[b].position[axis] += way;
          Lab there = world_of(testing_world(), moved, laws);
          return potential_energy(there);
        };
        const double slope = (energy(step) - energy(-step)) / (2 * step);
        EXPECT_NEAR(after[b].mass * after[b].velocity[axis] / h, -slope, 1e-5 * largest)
            << b << " " << axis;
      }
  }
}

TEST(TwoSolids, a_body_among_others_of_equal_spacing_is_at_rest_as_in_its_own_solid) {
  PairPotential b = other;
  b.distance = embedded.distance;
  b.cutoff = embedded.cutoff;
  // One crystal whose halves are of two metals.
  auto bodies = two_balls(2.9, 0, 0, embedded, b);
  bodies.erase(
      std::remove_if(bodies.begin(), bodies.end(), [](const Body& s) { return s.material == 1; }),
      bodies.end());
  for (Body& s : bodies) {
    s.position /= 0.98;
    s.velocity.setZero();
    s.material = s.position.x() > 0;
  }
  const auto before = bodies;
  Lab world = world_of(testing_world(), bodies, two_laws(embedded, b));
  potential_steps(world, 0.01, 1);
  const auto after = spheres_of(world);
  for (std::size_t k = 0; k < after.size(); ++k) EXPECT_LT(after[k].velocity.norm(), 1e-12) << k;
}

TEST(TwoSolids, momenta_are_kept_to_round_off) {
  PairPotential a = embedded, b = other;
  a.damping = b.damping = 0.3;
  const auto bodies = two_balls(3.2, 1.5, 3.8, a, b);
  Lab world = world_of(testing_world(), bodies, two_laws(a, b));
  const auto sums = [](const std::vector<Sphere>& all) {
    Eigen::Matrix<double, 6, 1> s = Eigen::Matrix<double, 6, 1>::Zero();
    for (const Sphere& body : all) {
      s.head<3>() += body.mass * body.velocity;
      s.tail<3>() += body.mass * body.position.cross(body.velocity);
    }
    return s;
  };
  double scale = 0;
  for (const Body& body : bodies) scale += body.mass * body.velocity.norm();
  const auto before = sums(spheres_of(world));
  const double kinetic = kinetic_energy(world);
  potential_steps(world, 0.005, 300);
  EXPECT_LE((sums(spheres_of(world)) - before).norm(), 1e-12 * scale);
  double heat = 0;
  for (Index k = 0; k < world.bodies.owned; ++k) heat += world.bodies.heat[k];
  EXPECT_GT(world.comm.sum(heat), 0.02 * kinetic);
}

TEST(TwoSolids, energy_error_is_of_second_order) {
  // Laws without breaks, cut where no pair passes: bonds that end have a kink.
  PairPotential a = crowded, b = crowded;
  b.depth = 1.4;
  a.cutoff = b.cutoff = 1.22 * a.distance;
  auto bodies = two_balls(1.9, 0.4, 1.9, a, b);
  std::vector<double> errors;
  for (int halvings = 0; halvings < 3; ++halvings) {
    Lab world = world_of(alone(), bodies, two_laws(a, b));
    const int steps = 100 << halvings;
    const double before = kinetic_energy(world) + potential_energy(world);
    double worst = 0;
    for (int k = 0; k < steps; ++k) {
      potential_steps(world, 1.0 / steps, 1);
      worst = std::max(worst, std::abs(kinetic_energy(world) + potential_energy(world) - before));
    }
    errors.push_back(worst);
  }
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.3);
}

TEST(TwoSolids, two_names_of_one_solid_are_that_solid) {
  for (PairPotential p : {embedded, breaking}) {
    p.damping = 0.3;
    auto bodies = two_balls(2.6, 1, 3, p, p);
    for (Body& b : bodies) b.mass = 1;
    Lab one = world_of(testing_world(), bodies, p);
    Lab two = world_of(testing_world(), bodies, two_laws(p, p));
    EXPECT_NEAR(potential_energy(one), potential_energy(two),
                1e-13 * std::abs(potential_energy(one)));
    potential_steps(one, 0.01, 100);
    potential_steps(two, 0.01, 100);
    const auto a = spheres_of(one), b = spheres_of(two);
    for (std::size_t k = 0; k < a.size(); ++k)
      EXPECT_LE((a[k].position - b[k].position).norm(), 1e-11 * p.distance) << k;
  }
}

TEST(TwoSolids, motion_is_the_same_on_any_number_of_ranks) {
  PairPotential a = embedded, b = other;
  a.damping = b.damping = 0.3;
  const auto bodies = two_balls(2.6, 1, 3, a, b);
  Lab one = world_of(alone(), bodies, two_laws(a, b));
  Lab many = world_of(testing_world(), bodies, two_laws(a, b));
  potential_steps(one, 0.01, 100);
  potential_steps(many, 0.01, 100);
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-10 * a.distance) << k;
}

TEST(TwoSolids, bodies_of_two_solids_weld_only_where_asked_for) {
  // Two bodies at rest beside each other, pulled apart.
  for (bool bonded : {false, true}) {
    const auto laws = two_laws(embedded, other, bonded);
    const double d = laws(0, 1).distance, v = 1e-3;
    std::vector<Body> bodies(2);
    bodies[1].material = 1;
    bodies[1].position = {d, 0, 0};
    bodies[1].velocity = {v, 0, 0};
    Lab world = world_of(alone(), bodies, laws);
    int links = 0;
    for_each_near_pair(world, world.potential,
                       [&](Index, Index, const Vec3&, bool bound) { links += bound; });
    EXPECT_EQ(links, bonded ? 1 : 0);
    potential_steps(world, 0.01, 100);
    EXPECT_EQ(spheres_of(world)[1].velocity.x() == v, !bonded);
  }
}

// Plates that meet, against hand calculation by the Hugoniots of both.

TEST(TwoSolids, plates_of_two_metals_meet_as_their_impedances_say) {
  const struct {
    const char *flyer, *target;
    double speed;
  } impacts[] = {{"copper", "steel_304", 2000}, {"steel_304", "aluminium_6061_t6", 1000}};
  for (const auto& [flyer, target, speed] : impacts) {
    const auto [measured, by_hand] = plate_impact(
        testing_world(), {.flyer = flyer, .target = target, .speed = speed}, MATERIALS);
    EXPECT_NEAR(measured.velocity, by_hand.velocity, 0.03 * by_hand.velocity) << flyer;
    EXPECT_NEAR(measured.pressure, by_hand.pressure, 0.03 * by_hand.pressure) << flyer;
  }
}

/// What its steps are refused for; bodies of the second material may be held.
std::string refused(const std::vector<Body>& bodies, const ByPair<PairPotential>& laws) {
  Lab world = world_of(testing_world(), bodies, laws);
  return complaint_of([&] { world.potential.check_steps(world, {1e-6, 1, "here"}); });
}

TEST(TwoSolids, steps_beside_a_material_that_is_held_are_checked_by_who_moves) {
  std::vector<Body> bodies = two_balls(3, 1, 4, embedded, other);
  for (Body& b : bodies)
    if (b.material == 1) b.mass = infinity, b.velocity = Vec3::Zero();
  EXPECT_EQ(refused(bodies, two_laws(embedded, other)), "");
}

TEST(TwoSolids, pass_through_each_other_by_the_energy_of_the_heaviest_that_meet) {
  PairPotential soft = embedded;
  soft.law = PairLaw::morse;
  soft.embedding = {};
  soft.steepness = 1;
  soft.depth = 1;
  const double wall = std::exp(2) - 2 * std::exp(1);  // J at distance 0
  const auto three = [&](double other_mass, int other_material, double part) {
    std::vector<Body> bodies(3);
    for (int k = 0; k < 3; ++k) bodies[k].position = {2.0 * k, 0, 0};
    bodies[0].mass = 1;
    bodies[1].mass = 1000;
    bodies[2].mass = other_mass;
    bodies[2].material = other_material;
    const double reduced = std::isinf(other_mass) ? 1000 : 1000 * other_mass / (1000 + other_mass);
    bodies[1].velocity = {part * std::sqrt(2 * wall / reduced), 0, 0};
    return bodies;
  };
  for (int material : {0, 1})
    for (double mass : {1000.0, 500.0, infinity})
      for (const ByPair<PairPotential>& laws :
           {ByPair<PairPotential>(soft), two_laws(soft, soft, true)}) {
        EXPECT_EQ(refused(three(mass, material, 0.99), laws), "") << mass;
        EXPECT_NE(refused(three(mass, material, 1.01), laws).find("pass through"),
                  std::string::npos)
            << mass;
      }
}

// How cases ask for it.

const char* const two_groups = R"([materials.al.solid]
density = 2703
sound_speed = 5350
hugoniot_slope = 1.34
gruneisen = 1.97
youngs_modulus = "68.9 GPa"
poisson_ratio = 0.33
spall_strength = "1.2 GPa"
[materials.steel.solid]
density = 7896
sound_speed = 4569
hugoniot_slope = 1.49
gruneisen = 1.93
youngs_modulus = "193 GPa"
poisson_ratio = 0.29
spall_strength = "1.9 GPa"
[materials.rock]
density = 2000
[[groups]]
name = "plate"
material = "al"
volume = {shape = "box", size = ["5 mm", "5 mm", "2 mm"]}
packing = {kind = "fcc", diameter = "0.5 mm"}
[[groups]]
name = "ball"
material = "steel"
volume = {shape = "sphere", diameter = "2 mm", center = [0, 0, "3 mm"]}
packing = {kind = "fcc", diameter = "0.4 mm"}
[[phases]]
name = "only"
method = "potential"
step = "1 ns"
duration = "2 ns"
)";

Case case_with(const std::string& law) {
  return parse_case(two_groups + law, "x.toml");
}
ByPair<PairPotential> laws_of(const std::string& law) {
  return case_with(law).engines.find<PotentialSettings>()->law;
}
std::string complaint(const std::string& law) {
  return complaint_of([&] { case_with(law); });
}

TEST(TwoSolids, a_case_gets_the_law_of_each_material_and_of_both) {
  const std::string both = "[pair_potential]\nmaterials = [\"al\", \"steel\"]\ndamping = 0.3\n";
  const auto laws = laws_of(both);  // of al, rock, steel and the impactor
  EXPECT_EQ(laws(0, 0).distance, 0.5e-3);
  EXPECT_EQ(laws(2, 2).distance, 0.4e-3);
  EXPECT_DOUBLE_EQ(laws(0, 2).distance, 0.45e-3);
  EXPECT_FALSE(laws(0, 2).attracts());
  EXPECT_EQ(laws(2, 0).damping, 0.3);
  EXPECT_EQ(complaint(both + "breaking_strain = 0\n")
                .find("x.toml:37:19: pair_potential.breaking_strain is 0, but bonds"),
            0)
      << complaint(both + "breaking_strain = 0\n");
  const Case scene = case_with(both);
  const std::string words = describe_phases(scene, measure_groups(scene));
  for (const char* part : {"between bodies of al\n", "between bodies of steel\n",
                           "between bodies of al and steel\n", "repels only"})
    EXPECT_NE(words.find(part), std::string::npos) << part;

  const auto welded = laws_of(both +
                              "[[pair_potential.between]]\nmaterials = [\"steel\", \"al\"]\n"
                              "bonded = true\ndamping = 0.1\n");
  EXPECT_TRUE(welded(0, 2).attracts());
  EXPECT_GT(welded(0, 2).breaking_strain, 0);
  EXPECT_EQ(welded(0, 2).damping, 0.1);
  const std::string hand =
      "law = \"morse\"\ndepth = 2\ndistance = \"0.5 mm\"\nsteepness = 4\n"
      "cutoff = \"0.7 mm\"\n";
  const auto mixed =
      laws_of(both + "[[pair_potential.between]]\nmaterials = [\"steel\", \"al\"]\n" + hand);
  EXPECT_EQ(mixed(2, 0).depth, 2);
  EXPECT_EQ(mixed(0, 0), laws(0, 0));
  // Of one material only what is said changes.
  const auto damped = laws_of(both +
                              "[[pair_potential.between]]\nmaterials = [\"al\", \"al\"]\n"
                              "damping = 0.2\n");
  EXPECT_EQ(damped(0, 0).damping, 0.2);
  EXPECT_EQ(damped(0, 0).breaking_strain, laws(0, 0).breaking_strain);
  EXPECT_EQ(damped(0, 0).embedding, laws(0, 0).embedding);
  EXPECT_FALSE(damped(0, 0).bonds_groups);
  // By hand it is the law of all pairs.
  EXPECT_TRUE(laws_of("[pair_potential]\n" + hand).uniform());
}

/// Its material is of no group.
TEST(TwoSolids, an_impactor_has_the_law_that_a_table_gives_it) {
  const std::string text =
      "materials.rock.density = 1600\n[[groups]]\nname = \"a\"\nmaterial = \"rock\"\n"
      "volume = {radius = 1}\n[pair_potential]\nlaw = \"lennard_jones\"\ndepth = 1\n"
      "distance = 2\ncutoff = 3\n[[pair_potential.between]]\nmaterials = [\"rock\", "
      "\"impactor\"]\nlaw = \"lennard_jones\"\ndepth = 7\ndistance = 1.1\ncutoff = 3\n"
      "[[phases]]\nname = \"hit\"\nmethod = \"potential\"\nstep = \"1 us\"\nduration = 1\n"
      "impactor = {mass = 1, radius = 0.1, speed = 1, distance = 5}\n";
  const Case scene = parse_case(text, "x.toml");
  const auto laws = scene.phases[0].settings.get<PotentialSettings>().law;
  EXPECT_EQ(laws(0, 0).depth, 1);
  EXPECT_EQ(laws(0, scene.phases[0].impactor->material).depth, 7);
}

TEST(TwoSolids, materials_without_a_law_are_refused) {
  const std::string one = "[pair_potential]\nmaterial = \"al\"\n";
  EXPECT_EQ(complaint(one),
            "x.toml:24:1: groups.ball.material = \"steel\": x.toml:29:1: phases.only.method = "
            "\"potential\" has no law between bodies of al and steel; name them in "
            "pair_potential.materials or in a [[pair_potential.between]]");
  EXPECT_NE(complaint(one + "[[pair_potential.between]]\nmaterials = [\"al\", \"steel\"]\n")
                .find("pair_potential.between.0.materials: without a law by hand both must be"),
            std::string::npos)
      << complaint(one + "[[pair_potential.between]]\nmaterials = [\"al\", \"steel\"]\n");
  EXPECT_NE(complaint("[pair_potential]\nmaterials = [\"al\", \"rock\"]\n")
                .find("\"rock\" is not a solid of [materials]"),
            std::string::npos);
  EXPECT_NE(complaint("[pair_potential]\nmaterials = [\"al\", \"gold\"]\n")
                .find("\"gold\" is not in [materials]"),
            std::string::npos);
  EXPECT_NE(complaint("[pair_potential]\nmaterials = [\"al\", \"steel\"]\n"
                      "[[phases]]\nname = \"hit\"\nmethod = \"potential\"\nstep = \"1 ns\"\n"
                      "duration = \"2 ns\"\nimpactor = {mass = 1e-3, diameter = \"1 mm\", "
                      "speed = 100}\n")
                .find("the impactor has no law"),
            std::string::npos);
}

TEST(TwoSolids, too_long_a_step_names_the_pair) {
  const Case scene = case_with("[pair_potential]\nmaterials = [\"al\", \"steel\"]\n");
  Lab world(make_world(alone(), scene));
  world.bodies = make_bodies(scene, alone());
  world.potential.law = scene.engines.find<PotentialSettings>()->law;
  const std::string message = complaint_of([&] {
    world.potential.check_steps(world, {.h = 9e-9, .lasts = 1e-6, .place = "x.toml: phases.only"});
  });
  EXPECT_NE(message.find("phases.only, al: step = 9e-09 s is too long"), std::string::npos)
      << message;
}

TEST(TwoSolids, a_material_without_bodies_shortens_no_step_at_a_wall_either) {
  auto bodies = two_balls(1.9, 0, 1.6, embedded, other);
  std::erase_if(bodies, [](const Body& b) { return b.material == 1; });
  Lab world = world_of(alone(), bodies, two_laws(embedded, other));
  world.planes = {{.point = {-9, 0, 0}, .normal = Vec3::UnitX(), .material = 0}};
  const PlannedSteps steps{.h = 1e-3, .lasts = 1, .place = "x.toml: phases.only"};
  EXPECT_EQ(complaint_of([&] { world.potential.check_steps(world, steps); }), "");
}

}  // namespace
}  // namespace spall
