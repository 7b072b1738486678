// Solids with pores: the curve by which they are crushed, unloading, shocks, books, ranks,
// refusals. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "scene/scene.hpp"
#include "solid_worlds.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3, h = 1e-9;

const std::string text = R"([[groups]]
name = "plate"
material = "foam"
volume = {shape = "box", size = ["5 mm", "5 mm", "5 mm"]}
packing = {kind = "fcc", diameter = "1 mm"}
[[phases]]
name = "only"
method = "solid"
step = "10 ns"
duration = "20 ns"
[materials.foam]
library = "aluminium_porous"
[materials.foam.solid]
)";
/// Hardly any strength, which the jump conditions below know nothing of.
const Solid& soft() {
  static const Solid solid = [] {
    Solid known = *parse_case(text, "x.toml").materials[0].solid;
    known.yield_strength = 1e5;
    known.youngs_modulus = 1e9;
    known.specific_heat = known.melting_point = 0;
    return known;
  }();
  return solid;
}
const SolidLaw& law() {
  static const SolidLaw made = solid_law(soft(), true, "foam");
  return made;
}

/// alpha, by the formula.
double distension_at(const Pores& pores, double pressure) {
  if (pressure >= pores.compacted) return 1;
  const double left = (pores.compacted - pressure) / (pores.compacted - pores.elastic);
  return 1 + (pores.distension - 1) * std::min(1.0, left * left);
}
/// Pa, of Mie and Gruneisen: matter of this density (kg/m^3) with this energy (J/kg).
double pressure_of_matter(double density, double energy) {
  static const ColdCurve curve(soft());
  const auto cold = curve.at(density / soft().density);
  return cold.pressure + soft().gruneisen * (soft().density * energy - cold.energy);
}

struct State {
  double pressure, distension, density, energy;
};
State state_of(const Lab& world) {
  const double crushed = of_the_middle_body(world, &Bodies::crushed);
  const double at_rest = law().density * d * d * d / std::sqrt(2.0);  // kg
  return {.pressure = of_the_middle_body(world, &Bodies::pressure),
          .distension = 1 + 0.275 * (1 - crushed) * (1 - crushed),
          .density = law().density * of_the_middle_body(world, &Bodies::compression),
          .energy = of_the_middle_body(world, &Bodies::internal_energy) / at_rest};
}

// --- the curve ---

TEST(Porous, is_crushed_along_the_curve_and_has_its_matters_pressure) {
  Lab world = held_ball(d, law());
  double most = 0;
  for (int part = 0; part < 40; ++part) {
    deform(world, -0.003 / (10 * h) * as_is, h, 10);
    const State now = state_of(world);
    EXPECT_GT(now.pressure, most);
    most = now.pressure;
    EXPECT_NEAR(now.distension, distension_at(soft().pores, now.pressure), 1e-6);
    const double alpha = now.distension;
    // Between the cold pressure's nodes; the little shear has an energy too.
    EXPECT_NEAR(now.pressure, pressure_of_matter(alpha * now.density, now.energy) / alpha,
                1e-5 * law().bulk);
  }
  EXPECT_GT(most, 1e9);
}

TEST(Porous, unloads_elastically_at_its_distension) {
  for (double squeezed : {0.0004, 0.03, 0.08}) {  // before, amid and behind the curve
    Lab world = held_ball(d, law());
    deform(world, -squeezed / (200 * h) * as_is, h, 200);
    const State loaded = state_of(world);
    const double heat = of_the_middle_body(world, &Bodies::heat);
    deform(world, 2e-4 / (10 * h) * as_is, h, 10);
    const State back = state_of(world);
    EXPECT_EQ(back.distension, loaded.distension);
    const double alpha = back.distension;
    EXPECT_NEAR(back.pressure, pressure_of_matter(alpha * back.density, back.energy) / alpha,
                1e-5 * law().bulk);
    EXPECT_NEAR(loaded.pressure - back.pressure, 6e-4 * soft().bulk_modulus() / alpha,
                0.3 * 6e-4 * soft().bulk_modulus());
    const double work = loaded.pressure * 6e-4 * d * d * d / std::sqrt(2.0);
    // What is warm cools as it expands: dQ = -Gamma Q dV/V.
    EXPECT_NEAR(of_the_middle_body(world, &Bodies::heat), heat * (1 - 6e-4 * soft().gruneisen),
                0.02 * work);
    if (squeezed < 0.001) {
      EXPECT_EQ(alpha, 1.275);
      EXPECT_LE(std::abs(heat), 0.02 * work);
    } else if (squeezed < 0.05) {
      EXPECT_LT(alpha, 1.26);
      EXPECT_GT(alpha, 1.01);
    } else {
      EXPECT_EQ(alpha, 1);
    }
  }
}

TEST(Porous, crushing_takes_the_work_of_its_pressure) {
  Lab world = held_ball(d, law());
  double work = 0;
  State before = state_of(world);
  for (int step = 0; step < 400; ++step) {
    deform(world, -0.08 / (400 * h) * as_is, h, 1);
    const State now = state_of(world);
    work += (before.pressure + now.pressure) / 2 * (1 / before.density - 1 / now.density);
    before = now;
  }
  EXPECT_NEAR(before.energy, work, 2e-3 * work);
}

TEST(Porous, rock_is_broken_by_the_share_of_pores_that_are_closed) {
  Solid rock = soft();
  rock.weibull = {.k = 1e-60, .m = 9};
  Lab world = held_ball(d, solid_law(rock, true, "rock"));
  for (int part = 0; part < 5; ++part) {
    deform(world, -0.015 / (50 * h) * as_is, h, 50);
    const double closed = 1 - (state_of(world).distension - 1) / 0.275;
    EXPECT_NEAR(of_the_middle_body(world, &Bodies::damage), closed, 1e-6);
  }
}

TEST(Porous, rock_that_is_crushed_bears_less_shear) {
  Solid rock = soft();
  rock.weibull = {.k = 1e-60, .m = 9};
  rock.yield_strength = 1e12;
  const SolidLaw strong = solid_law(rock, true, "rock");
  Lab world = held_ball(d, strong);
  Eigen::Matrix3d shearing = Eigen::Matrix3d::Zero();
  shearing(0, 1) = shearing(1, 0) = 1;
  deform(world, 0.001 / (20 * h) * shearing, h, 20);
  const double whole = stress_of_the_middle(world)(0, 1);
  EXPECT_NEAR(whole, 0.002 * strong.shear, 1e-3 * whole);
  for (int part = 0; part < 5; ++part) {
    deform(world, -0.01 / (50 * h) * as_is, h, 50);
    const double damage = of_the_middle_body(world, &Bodies::damage);
    EXPECT_NEAR(stress_of_the_middle(world)(0, 1), (1 - damage) * whole, 0.02 * whole) << damage;
  }
  EXPECT_GT(of_the_middle_body(world, &Bodies::damage), 0.5);
}

// --- tension ---

TEST(Porous, that_has_cracked_bears_no_tension_whatever_its_pores) {
  for (double distension : {1.275, 2.0, 3.5}) {
    Solid rock = soft();
    rock.weibull = {.k = 1e-60, .m = 9};
    rock.pores.distension = distension;
    Lab world = held_ball(d, solid_law(rock, true, "rock"), 1);
    deform(world, 0.01 / (50 * h) * as_is, h, 50);
    EXPECT_NEAR(of_the_middle_body(world, &Bodies::pressure), 0, 1e-6 * rock.bulk_modulus())
        << distension;
  }
}

TEST(Porous, bears_its_spall_strength_less_the_voids_whatever_its_pores) {
  for (double distension : {1.275, 2.0, 3.5}) {
    Solid metal = soft();
    metal.spall_strength = 5e7;
    metal.pores.distension = distension;
    Lab world = held_ball(d, solid_law(metal, true, "metal"));
    deform(world, 0.005 / (50 * h) * as_is, h, 50);
    const double damage = of_the_middle_body(world, &Bodies::damage);
    EXPECT_GT(damage, 0.01);
    EXPECT_LT(damage, 0.2);
    EXPECT_NEAR(of_the_middle_body(world, &Bodies::pressure), -(1 - damage) * 5e7, 1e6)
        << distension;
  }
}

// --- shocks ---

struct Jump {
  double speed, density, pressure;
};

/// Behind a shock that brings what is at rest to the velocity u: mass, momentum and energy, with
/// the elastic wave that runs ahead. Speed by the places at rest.
Jump jump(const Solid& solid, double u) {
  const double rest = solid.bulk_density(), c = solid.sound_speed, p1 = solid.pores.elastic;
  const double u1 = p1 / (rest * c), rho1 = rest * c / (c - u1);
  Jump at{};
  double low = u * 1.001, high = 3 * c;
  for (int halvings = 0; halvings < 80; ++halvings) {
    const double U = (low + high) / 2;
    const double rho = rho1 * (U - u1) / (U - u);
    const double p = p1 + rho1 * (U - u1) * (u - u1);
    const double e = u1 * u1 / 2 + (p + p1) / 2 * (1 / rho1 - 1 / rho);
    const double alpha = distension_at(solid.pores, p);
    (pressure_of_matter(alpha * rho, e) / alpha > p ? low : high) = U;
    at = {rho1 * (U - u1) / rest, rho, p};
  }
  return at;
}

TEST(PorousShock, has_the_speed_density_and_pressure_of_the_jump_conditions) {
  // The elastic wave comes back from the rear as a release, which must not have met the shock.
  constexpr int cells = 36, across = 4;
  const double a = std::sqrt(2.0) * d;
  const Pores partly{.distension = 1.275, .elastic = 8e6, .compacted = 4e9};
  const struct {
    Pores pores;
    double speed;
  } shocks[] = {{soft().pores, 500}, {soft().pores, 1500}, {partly, 500}};
  for (const auto& [pores, u] : shocks) {
    Solid solid = soft();
    solid.pores = pores;
    const Jump expected = jump(solid, u);
    EXPECT_EQ(expected.pressure > pores.compacted, pores.compacted < 1e9);
    const auto spheres = crystal(d, law().density, as_is, cells * a + d, [&](const Vec3& x) {
      const Vec3 cell = x / a + Vec3::Constant(0.25);
      return cell.minCoeff() > 0 && cell.x() < across && cell.y() < across && cell.z() < cells;
    });
    std::vector<int> layer;
    auto flying = spheres;
    for (Sphere& s : flying) {
      layer.push_back(static_cast<int>(std::floor(s.position.z() / a + 0.25)));
      s.position.z() += d / 2;
      s.velocity = {0, 0, -u};
    }
    Lab world = world_of(testing_world(), flying, solid_law(solid, true, "foam"));
    world.planes.emplace_back();
    world.period.size = {across * a, across * a, 0};
    const auto of_layers = [&](auto&& f) {
      std::vector<double> sums(2 * cells);
      for (Index b = 0; b < world.bodies.owned; ++b) {
        const auto l = static_cast<std::size_t>(layer[world.bodies.id[b]]);
        sums[2 * l] += 1;
        sums[2 * l + 1] += f(world.bodies, b);
      }
      world.comm.sum(sums);
      std::vector<double> means;
      for (std::size_t l = 0; l < cells; ++l) means.push_back(sums[2 * l + 1] / sums[2 * l]);
      return means;
    };
    const Sums first = sums_of(world);
    const double step = 0.7 * longest_step(law(), d, 2 * u);
    std::vector<double> reached(cells, 0.0), before(cells, -u);  // s, by half of the jump
    double time = 0;
    while (time < 20 * a / expected.speed) {
      solid_steps(world, step, 2);
      const auto now =
          of_layers([](const Bodies& bodies, Index b) { return bodies.velocity[b].z(); });
      for (std::size_t l = 0; l < cells; ++l)
        if (reached[l] == 0 && now[l] > -u / 2)
          reached[l] = time + 2 * step * (-u / 2 - before[l]) / (now[l] - before[l]);
      before = now;
      time += 2 * step;
    }
    EXPECT_NEAR(10 * a / (reached[18] - reached[8]), expected.speed, 0.03 * expected.speed) << u;
    const auto compression =
        of_layers([](const Bodies& bodies, Index b) { return bodies.compression[b]; });
    const auto pressure =
        of_layers([](const Bodies& bodies, Index b) { return bodies.pressure[b]; });
    double density = 0, pressed = 0;
    for (int l = 6; l < 14; ++l) {
      density += law().density * compression[l] / 8;
      pressed += pressure[l] / 8;
    }
    EXPECT_NEAR(density, expected.density, 0.02 * expected.density) << u;
    EXPECT_NEAR(pressed, expected.pressure, 0.03 * expected.pressure) << u;
    const Sums last = sums_of(world);
    const double contacts = world.solid.energy(world) - (last.internal - last.heat);
    EXPECT_NEAR(last.kinetic + last.internal + contacts, first.kinetic, 0.01 * first.kinetic) << u;
  }
}

TEST(PorousShock, is_the_same_on_any_number_of_ranks_and_after_a_restart) {
  std::vector<Sphere> spheres;
  for (int side : {-1, 1})
    for (Sphere s : ball(d, law().density, side < 0 ? as_is : turned, 2.6 * d)) {
      s.position += side * Vec3(3.2 * d, 0.3 * d, 0);
      s.velocity = -side * Vec3(400, 0, 0);
      spheres.push_back(s);
    }
  const auto make = [&](const Comm& comm) {
    Lab world = world_of(comm, spheres, law());
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.group[b] = spheres[world.bodies.id[b]].velocity.x() < 0;
    return world;
  };
  Lab one = make(alone()), many = make(testing_world());
  for (int part = 0; part < 2; ++part) {
    solid_steps(one, 0.1 * d / law().sound_speed(), 60);
    solid_steps(many, 0.1 * d / law().sound_speed(), 60);
    many.solid.restart_pairs(many, {});
  }
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-9 * d) << k;
  double crushed = 0;
  for (Index b = 0; b < one.bodies.owned; ++b) crushed = std::max(crushed, one.bodies.crushed[b]);
  EXPECT_GT(crushed, 0.3);
}

// --- how cases ask for it ---

std::string complaint(const std::string& more, const std::string& method = "solid") {
  std::string asked = text + more;
  asked.replace(asked.find("\"solid\""), 7, "\"" + method + "\"");
  return complaint_of([&] { parse_case(asked, "x.toml"); });
}

TEST(PorousCase, weighs_what_its_matter_does) {
  const Case scene = parse_case(text, "x.toml");
  const double of_a_body = 2707 / 1.275 * d * d * d / std::sqrt(2.0);
  for (double m : make_bodies(scene, Comm(MPI_COMM_SELF)).mass)
    EXPECT_NEAR(m, of_a_body, 1e-12 * of_a_body);
  EXPECT_NEAR(scene.materials[0].density, 2707 / 1.275, 1e-9);
  EXPECT_EQ(law().sound_speed(), std::sqrt((law().bulk + 4 * law().shear / 3) / (2707 / 1.275)));
  EXPECT_NE(describe_phases(scene, measure_groups(scene)).find("pores, 0.216 of its volume"),
            std::string::npos);
}

TEST(PorousCase, refuses_what_does_not_go_together) {
  EXPECT_EQ(complaint(""), "");
  EXPECT_NE(complaint("elastic_pressure = \"1 GPa\"").find("must be more than elastic_pressure"),
            std::string::npos);
  Solid half = soft();
  half.pores.compacted = 0;
  EXPECT_EQ(complaint_of([&] { solid_law(half, true, "x"); }),
            "x: a solid with a stress needs compaction_pressure beside distension");
  half = soft();
  half.pores.distension = 1;
  EXPECT_NE(
      complaint_of([&] { solid_law(half, true, "x"); }).find("distension must be more than 1"),
      std::string::npos);
  EXPECT_NE(complaint("[pair_potential]\nmaterial = \"foam\"\nmatch = \"bulk\"\n", "potential")
                .find("pairs have no pores"),
            std::string::npos);
}

}  // namespace
}  // namespace spall
