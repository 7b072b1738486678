// Metals that are stiffer and stronger under pressure, after Steinberg, Cochran & Guinan: moduli,
// flow stress, heat, books, refusals. SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "scene/scene.hpp"
#include "solid/flow_stress.hpp"
#include "solid_worlds.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3;                               // m
constexpr double h = 1e-9;                               // s
const double mass = 16690 * d * d * d / std::sqrt(2.0);  // kg, of a body of tantalum
constexpr double specific_heat = 140;                    // J/(kg K)

const std::string plate = R"([[groups]]
name = "plate"
material = "plate"
volume = {shape = "sphere", radius = "3 mm"}
packing = {kind = "fcc", diameter = "1 mm"}
[[phases]]
name = "only"
method = "solid"
step = "10 ns"
duration = "20 ns"
[materials.plate]
library = "tantalum"
)";
const Solid& tantalum() {
  static const Solid solid = *parse_case(plate, "x.toml").materials[0].solid;
  return solid;
}
const SolidLaw& law() {
  static const SolidLaw of = solid_law(tantalum(), true, "tantalum");
  return of;
}

const Eigen::Matrix3d shearing = [] {
  Eigen::Matrix3d m = Eigen::Matrix3d::Zero();
  m(0, 1) = m(1, 0) = 1;
  return m;
}();

/// By the formula, with the constants that Steinberg prints for tantalum (TPa^-1, kK^-1, GPa).
double grown(double compression, double pressure, double warmed) {
  return 1 + 14.5 * (pressure / 1e12) / std::pow(compression, 1.0 / 3) - 0.13 * (warmed / 1000);
}
double flow(double strain) {
  return 1e9 * std::min(1.1, 0.77 * std::pow(1 + 10 * strain, 0.1));
}

void warm(Lab& world, double by) {
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.heat[b] = world.bodies.internal_energy[b] = by * specific_heat * mass;
}

/// A held ball that has been warmed by so many K, and squeezed along each axis.
Lab squeezed_ball(double warmed, double squeezed) {
  Lab world = held_ball(d, law());
  warm(world, warmed);
  deform(world, -squeezed / (40 * h) * as_is, h, 40);
  return world;
}

struct State {
  double growth, strain, shear;  // shear: Pa, sqrt(J2)
};
State state_of(const Lab& world) {
  const Eigen::Matrix3d stress = stress_of_the_middle(world);
  const double pressure = of_the_middle_body(world, &Bodies::pressure);
  const double compression = of_the_middle_body(world, &Bodies::compression);
  const double heat = of_the_middle_body(world, &Bodies::heat) / mass;
  return {grown(compression, pressure, heat / specific_heat),
          of_the_middle_body(world, &Bodies::plastic_strain),
          (stress + pressure * as_is).norm() / std::sqrt(2.0)};
}

TEST(PressedMetal, hardens_up_to_a_limit) {
  for (double strain : {0.0, 0.01, 0.3, 2.0, 5.0}) {
    const auto y = flow_stress_of(law(), 0.2).at(strain, 1e5);
    EXPECT_NEAR(y.stress, flow(strain), 1e-9 * y.stress) << strain;
    const double e = 1e-6;
    EXPECT_NEAR(y.by_strain, (flow(strain + e) - flow(strain)) / e, 1e-3 * y.stress) << strain;
  }
  EXPECT_EQ(flow_stress_of(law(), 0.2).at(5, 1e5).stress, 1.1e9);
  EXPECT_EQ(flow_stress_of(law(), 1).at(0.1, 1e5).stress, 0);
}

TEST(PressedMetal, is_as_stiff_as_its_pressure_and_temperature_make_it) {
  for (double warmed : {0.0, 800.0})
    for (double squeezed : {-0.001, 0.02, 0.06}) {
      Lab world = squeezed_ball(warmed, squeezed);
      const double growth = state_of(world).growth;
      EXPECT_GT(growth, squeezed > 0.05 ? 1.4 : 0.8);
      const double strain = 1e-4;
      deform(world, strain / (10 * h) * shearing, h, 10);
      const double stress = stress_of_the_middle(world)(0, 1);
      const double expected = 2 * strain * tantalum().shear_modulus() * growth;
      EXPECT_NEAR(stress, expected, 2e-3 * expected) << warmed << " " << squeezed;
    }
}

TEST(PressedMetal, flows_at_the_stress_of_its_pressure_temperature_and_strain) {
  for (double warmed : {0.0, 800.0})
    for (double squeezed : {0.001, 0.02, 0.06}) {
      Lab world = squeezed_ball(warmed, squeezed);
      // The stiffness is that of a step before: many steps.
      double before = 0;
      for (double strain : {0.02, 0.1, 0.3}) {
        deform(world, (strain - before) / (400 * h) * shearing, h, 400);
        before = strain;
        const State now = state_of(world);
        EXPECT_GT(now.strain, 0.9 * strain);
        const double expected = flow(now.strain) * now.growth / std::sqrt(3.0);
        EXPECT_NEAR(now.shear, expected, 5e-4 * expected) << warmed << " " << squeezed;
      }
    }
}

TEST(PressedMetal, bears_no_shear_where_heat_has_taken_its_stiffness) {
  SolidLaw soft = law();
  soft.melting = 1e5;
  soft.steinberg.b = 1e-3;
  Lab world = held_ball(d, soft);
  warm(world, 1500);
  deform(world, 0.01 / (10 * h) * shearing, h, 10);
  EXPECT_EQ(stress_of_the_middle(world)(0, 1), 0);
}

TEST(PressedMetal, keeps_the_energy_of_an_impact) {
  std::vector<Sphere> spheres;
  for (int side : {-1, 1})
    for (Sphere s : ball(d, law().density, side < 0 ? as_is : turned, 2.6 * d)) {
      s.position += side * Vec3(3.2 * d, 0.3 * d, 0);
      s.velocity = -side * Vec3(800, 0, 0);
      spheres.push_back(s);
    }
  Lab world = world_of(testing_world(), spheres, law());
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.group[b] = spheres[world.bodies.id[b]].velocity.x() < 0;
  const Sums first = sums_of(world);
  const double step = 0.5 * longest_step(law(), d, 1600);
  solid_steps(world, step, static_cast<int>(5 * d / 800 / step));
  const Sums last = sums_of(world);
  EXPECT_LT(last.kinetic, 0.6 * first.kinetic);
  const double contacts = world.solid.energy(world) - (last.internal - last.heat);
  EXPECT_NEAR(last.kinetic + last.internal + contacts, first.kinetic, 0.005 * first.kinetic);
  EXPECT_LE((last.momentum - first.momentum).norm(), 1e-12 * 800 * law().density * 100 * d * d * d);
}

TEST(PressedMetal, needs_all_of_its_constants_and_one_flow_stress) {
  const auto complains = [](auto&& change) {
    Solid solid = tantalum();
    change(solid);
    return complaint_of([&] { solid_law(solid, true, "x"); });
  };
  EXPECT_EQ(complains([](Solid&) {}), "");
  EXPECT_EQ(complains([](Solid& s) { s.steinberg.y0 = 0; }),
            "x: steinberg_ymax, beta, n, a and b need steinberg_y0 beside them");
  EXPECT_EQ(complains([](Solid& s) { s.steinberg.ymax = 0; }),
            "x: a solid with a stress needs steinberg_ymax beside steinberg_y0");
  EXPECT_EQ(complains([](Solid& s) { s.steinberg.ymax = 7e8; }),
            "x: steinberg_ymax = 7e+08 Pa must not be less than steinberg_y0 = 7.7e+08 Pa");
  EXPECT_EQ(complains([](Solid& s) { s.johnson_cook.a = 1e8; }),
            "x: johnson_cook_a and steinberg_y0: leave one out");
  EXPECT_EQ(complains([](Solid& s) { s.specific_heat = 0; }),
            "x: a solid with a stress needs specific_heat beside steinberg_b");
  EXPECT_EQ(complains([](Solid& s) {
              s.pores = {1.5, 1e8, 1e9};
            }),
            "x: distension and steinberg_y0: leave one out");
  EXPECT_EQ(
      complains([](Solid& s) {
        s.weibull = {1e30, 9};
      }),
      "x: weibull_k and steinberg_y0: a solid breaks by its flaws, or as metals do; leave one "
      "out");
  EXPECT_NE(describe_phases(parse_case(plate, "x.toml"), {{}})
                .find("flows at 7.7e+08 Pa (1 + 10 eps)^0.1"),
            std::string::npos);
}

}  // namespace
}  // namespace spall
