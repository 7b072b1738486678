// How much it takes to tear metal: as much energy an area as its toughness says, whatever its
// bodies' size, and no less than a peak of tension of one body. SPDX-License-Identifier:
// BSD-3-Clause
#include <cmath>

#include "solid_worlds.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

double volume_of_body(double d) {
  return d * d * d / std::sqrt(2.0);  // m^3
}

// A body is a band as wide as the cube root of its volume, with an area of that squared.
TEST(Tearing, takes_the_fracture_energy_whatever_the_spacing) {
  const SolidLaw law =
      solid_law(*material_of_library("aluminium_6061_t6").solid, true, "aluminium_6061_t6");
  ASSERT_GT(law.fracture_energy, 0);
  for (const double d : {0.2e-3, 0.4e-3, 0.8e-3}) {
    Lab world = held_ball(d, law);
    const double h = 0.1 * d / law.sound_speed(), step = 3e-5;
    for (int n = 0; of_the_middle_body(world, &Bodies::damage) < 1; ++n) {
      ASSERT_LT(n, 10000) << d;
      deform(world, step / h * as_is, h, 1);
    }
    const double side = std::cbrt(volume_of_body(d));
    const double heat = of_the_middle_body(world, &Bodies::heat) / (side * side);
    // The integral of (1 - phi/phi_F) sigma dV, V = V_0/(1 - phi).
    const double grown = 1 + 2. / 3 * law.most_voids(volume_of_body(d));
    EXPECT_NEAR(heat, grown * law.fracture_energy, 0.06 * law.fracture_energy) << d;
  }
}

TEST(Tearing, needs_voids_of_a_quarter_at_most) {
  SolidLaw law = solid_law(*material_of_library("copper").solid, true, "copper");
  EXPECT_EQ(law.fracture_energy, 0);
  EXPECT_EQ(law.most_voids(1e-9), 0.25);
  law.fracture_energy = 100;
  EXPECT_EQ(law.most_voids(1e-30), 0.25);
  EXPECT_DOUBLE_EQ(law.most_voids(8e-9), 2 * 100 / (law.strength * 2e-3));
}

/// What a body bears whose neighbours are not pulled as it is: Pa, and its damage.
std::array<double, 2> pulled_alone(double strain) {
  const double d = 1e-3;
  const SolidLaw law = solid_law(*material_of_library("copper").solid, true, "copper");
  Lab world = held_ball(d, law);
  // The body in the middle has been pulled already, and this step asks all of them what they bear.
  Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.position[b].norm() < d / 2) {
      bodies.compression[b] = 1 - strain;
      bodies.pressure[b] = -law.bulk * strain;
    }
  solid_steps(world, 0.1 * d / law.sound_speed(), 2);
  return {-of_the_middle_body(world, &Bodies::pressure),
          of_the_middle_body(world, &Bodies::damage)};
}

TEST(Tearing, a_body_that_is_pulled_alone_bears_more_than_the_strength_but_not_twice_as_much) {
  const double strength = material_of_library("copper").solid->spall_strength;
  const double bulk = material_of_library("copper").solid->bulk_modulus();
  const auto [some, whole] = pulled_alone(1.5 * strength / bulk);
  EXPECT_GT(some, 1.3 * strength);
  EXPECT_EQ(whole, 0);
  const auto [most, damage] = pulled_alone(2.5 * strength / bulk);
  EXPECT_LT(most, 2.5 * strength);
  EXPECT_GT(damage, 0);
}

Eigen::Matrix3d deviator_of_the_middle(const Lab& world) {
  const Eigen::Matrix3d stress = stress_of_the_middle(world);
  return stress - stress.trace() / 3 * as_is;
}

/// It stays cold, and heat does not press it.
SolidLaw cold(const std::string& metal) {
  SolidLaw law = solid_law(*material_of_library(metal).solid, true, metal);
  law.specific_heat = law.gruneisen = 0;
  return law;
}

Eigen::Matrix3d simple_shear() {
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero();
  shear(0, 1) = 1;
  return shear;
}

// Shear parts a layer by the same energy as tension: from where Johnson and Cook's sum is 1 on.
TEST(Tearing, by_strain_takes_the_fracture_energy_whatever_the_spacing) {
  SolidLaw law = cold("aluminium_6061_t6");
  law.flow.d = {0.2, 0, 0, 0, 0};
  const Eigen::Matrix3d shear = simple_shear();
  for (const double d : {0.2e-3, 0.4e-3, 0.8e-3}) {
    Lab world = held_ball(d, law);
    const double h = 0.1 * d / law.sound_speed(), side = std::cbrt(volume_of_body(d));
    double begun = 0;
    for (int n = 0; of_the_middle_body(world, &Bodies::damage) < 1; ++n) {
      ASSERT_LT(n, 3000) << d;
      deform(world, 1e-3 / h * shear, h, 1);
      if (of_the_middle_body(world, &Bodies::strained) < 1)
        begun = of_the_middle_body(world, &Bodies::heat);
    }
    const double heat = (of_the_middle_body(world, &Bodies::heat) - begun) / (side * side);
    EXPECT_NEAR(heat, law.fracture_energy, 0.03 * law.fracture_energy) << d;
  }
}

// Voids grow from 0.15 to 0.25 of the volume, by 3 * 0.283 exp(1.5 sigma*) of themselves a strain.
TEST(Tearing, by_strain_takes_no_more_than_voids_need_to_join) {
  SolidLaw law = cold("aluminium_6061_t6");
  const double fine = volume_of_body(0.01e-3), coarse = volume_of_body(1e-3);
  for (const double triaxiality : {-1. / 3, 0., 1. / 3, 1.}) {
    const double grown =
        3 * 0.283 * std::exp(1.5 * triaxiality) * law.parting_strain(triaxiality, law.flow.a, fine);
    EXPECT_NEAR(0.15 * std::exp(grown), 0.25, 1e-12) << triaxiality;
    EXPECT_DOUBLE_EQ(law.parting_strain(triaxiality, law.flow.a, coarse),
                     2 * law.fracture_energy / (law.flow.a * std::cbrt(coarse)));
  }
  law.flow.d = {0.2, 0, 0, 0, 0};
  const double d = 0.01e-3, h = 0.1 * d / law.sound_speed();
  Lab world = held_ball(d, law);
  double begun = 0;
  for (int n = 0; of_the_middle_body(world, &Bodies::damage) < 1; ++n) {
    ASSERT_LT(n, 3000);
    deform(world, 1e-3 / h * simple_shear(), h, 1);
    if (of_the_middle_body(world, &Bodies::strained) < 1)
      begun = of_the_middle_body(world, &Bodies::plastic_strain);
  }
  const double parts = of_the_middle_body(world, &Bodies::plastic_strain) - begun;
  EXPECT_NEAR(parts, std::log(0.25 / 0.15) / (3 * 0.283), 0.03 * parts);
}

// Sheared until strain begins to fail it, stretched, and sheared on. What voids feel is the mean
// tension over the flow stress of what is still whole, and no more than 1.
TEST(Tearing, by_strain_is_faster_under_tension) {
  SolidLaw law = cold("aluminium_6061_t6");
  law.flow.d = {0.2, 0, 0, 0, 0};
  const double d = 0.01e-3, h = 0.1 * d / law.sound_speed(), step = 1e-3;
  for (const double pull : {0.0, 0.5, 2.0}) {
    Lab world = held_ball(d, law);
    while (of_the_middle_body(world, &Bodies::strained) < 1)
      deform(world, step / h * simple_shear(), h, 1);
    deform(world, pull * law.flow.a / law.bulk / 3 / h * as_is, h, 1);
    const double begun = of_the_middle_body(world, &Bodies::damage);
    double expected = begun, before = of_the_middle_body(world, &Bodies::plastic_strain);
    for (int n = 0; of_the_middle_body(world, &Bodies::damage) < 0.8; ++n) {
      ASSERT_LT(n, 2000) << pull;
      const double whole = 1 - of_the_middle_body(world, &Bodies::damage);
      const double tension = -of_the_middle_body(world, &Bodies::pressure);
      deform(world, step / h * simple_shear(), h, 1);
      const double flow = std::sqrt(1.5) * deviator_of_the_middle(world).norm() / whole;
      const double strain = of_the_middle_body(world, &Bodies::plastic_strain);
      expected += (strain - before) /
                  law.parting_strain(std::min(tension / flow, 1.0), flow, volume_of_body(d));
      before = strain;
    }
    const double damage = of_the_middle_body(world, &Bodies::damage);
    EXPECT_NEAR(damage, expected, 0.03 * (damage - begun)) << pull;
  }
}

TEST(Tearing, by_strain_is_at_once_where_no_energy_is_known) {
  SolidLaw law = cold("copper");
  law.flow.d = {0.2, 0, 0, 0, 0};
  const Eigen::Matrix3d shear = simple_shear();
  Lab world = held_ball(1e-3, law);
  const double h = 0.1e-3 / law.sound_speed();
  for (int n = 0; of_the_middle_body(world, &Bodies::strained) < 1; ++n) {
    ASSERT_LT(n, 1000);
    ASSERT_EQ(of_the_middle_body(world, &Bodies::damage), 0);
    deform(world, 1e-3 / h * shear, h, 1);
  }
  EXPECT_EQ(of_the_middle_body(world, &Bodies::damage), 1);
  EXPECT_LT(deviator_of_the_middle(world).norm(), 1e-12 * law.shear);
}

// Squeezed by this strain, then sheared: Johnson and Cook's sum.
TEST(Tearing, by_strain_is_put_off_by_pressure) {
  const double d = 1e-3, step = 2e-3;
  SolidLaw law = cold("aluminium_2024_t351");
  const Eigen::Matrix3d shear = simple_shear();
  double last = 1;
  for (const double squeezed : {0.0, 0.0004, 0.0008, 0.0012}) {
    Lab world = held_ball(d, law);
    const double h = 0.1 * d / law.sound_speed(), rate = step / std::sqrt(3.0) / h;
    deform(world, -squeezed / 3 / h * as_is, h, 1);
    double expected = 0, before = of_the_middle_body(world, &Bodies::plastic_strain);
    for (int n = 0; n < 100; ++n) {
      const double around = of_the_middle_body(world, &Bodies::pressure);
      deform(world, step / h * shear, h, 1);
      const double mises = std::sqrt(1.5) * deviator_of_the_middle(world).norm();
      const double strain = of_the_middle_body(world, &Bodies::plastic_strain);
      expected += (strain - before) / law.failure_strain(-around / mises, rate, 0);
      before = strain;
    }
    const double strained = of_the_middle_body(world, &Bodies::strained);
    EXPECT_NEAR(strained, expected, 0.03 * expected) << squeezed;
    EXPECT_LT(strained, last) << squeezed;
    last = strained;
  }
}

// Stretched to a mean tension above von Mises' stress and below the spall strength, then sheared.
TEST(Tearing, by_strain_rests_where_voids_alone_are_judged) {
  const double d = 1e-3, step = 2e-3;
  const SolidLaw law = cold("aluminium_2024_t351");
  Lab world = held_ball(d, law);
  const double h = 0.1 * d / law.sound_speed();
  deform(world, 0.01 / 3 / h * as_is, h, 1);
  deform(world, step / h * simple_shear(), h, 10);
  const double strained = of_the_middle_body(world, &Bodies::strained);
  for (int n = 0; n < 200; ++n) {
    deform(world, step / h * simple_shear(), h, 1);
    const double mises = std::sqrt(1.5) * deviator_of_the_middle(world).norm();
    ASSERT_GT(-of_the_middle_body(world, &Bodies::pressure), 1.1 * mises);
  }
  EXPECT_GT(of_the_middle_body(world, &Bodies::plastic_strain), 0.2);
  EXPECT_EQ(of_the_middle_body(world, &Bodies::strained), strained);
  EXPECT_EQ(of_the_middle_body(world, &Bodies::damage), 0);
}

// Sheared until it is half torn, squeezed, and sheared on.
TEST(Tearing, by_strain_rests_under_more_pressure_than_in_a_bar) {
  const double d = 1e-3, step = 2e-3;
  SolidLaw law = cold("aluminium_2024_t351");
  const Eigen::Matrix3d shear = simple_shear();
  for (const bool begun : {false, true}) {
    Lab world = held_ball(d, law);
    const double h = 0.1 * d / law.sound_speed();
    for (int n = 0; begun && of_the_middle_body(world, &Bodies::damage) < 0.5; ++n) {
      ASSERT_LT(n, 1000);
      deform(world, step / h * shear, h, 1);
    }
    deform(world, -0.05 / 3 / h * as_is, h, 1);
    const double damage = of_the_middle_body(world, &Bodies::damage);
    const double strained = of_the_middle_body(world, &Bodies::strained);
    deform(world, step / h * shear, h, 500);
    EXPECT_EQ(of_the_middle_body(world, &Bodies::damage), damage);
    EXPECT_EQ(of_the_middle_body(world, &Bodies::strained), strained);
    EXPECT_GT(of_the_middle_body(world, &Bodies::plastic_strain), 0.5);
    if (!begun) {
      EXPECT_LT(strained, 1e-4);
    }
  }
}

TEST(Tearing, moduli_that_are_far_apart_are_a_slip_of_units) {
  const Solid copper = *material_of_library("copper").solid;
  for (const double slip : {1e-3, 1e-2, 1e2, 1e3}) {
    Solid solid = copper;
    solid.youngs_modulus *= slip;
    EXPECT_EQ(complaint_of([&] { solid_law(solid, true, "x"); }).substr(0, 22),
              "x: the bulk modulus is");
    solid = copper;
    solid.sound_speed *= slip;
    EXPECT_NE(complaint_of([&] { solid_law(solid, true, "x"); }), "");
  }
}

TEST(Tearing, slips_that_no_other_constant_contradicts_are_refused_and_the_library_is_not) {
  const Solid copper = *material_of_library("copper").solid;
  const auto told = [&](auto&& slip) {
    Solid solid = copper;
    slip(solid);
    return complaint_of([&] { solid_law(solid, true, "x"); });
  };
  EXPECT_EQ(told([](Solid& s) { s.johnson_cook.a *= 1e3; }).substr(0, 35),
            "x: johnson_cook_a + johnson_cook_b ");
  EXPECT_EQ(told([](Solid& s) { s.spall_strength *= 1e3; }).substr(0, 17), "x: spall_strength");
  EXPECT_EQ(told([](Solid& s) { s.specific_heat *= 1e3; }).substr(0, 16), "x: specific_heat");
  EXPECT_EQ(told([](Solid& s) { s.specific_heat *= 1e-3; }).substr(0, 16), "x: specific_heat");
  EXPECT_EQ(told([](Solid& s) { s.gruneisen = 19.7; }).substr(0, 12), "x: gruneisen");
  EXPECT_EQ(told([](Solid& s) { s.fracture_energy = 1e8; }).substr(0, 18), "x: fracture_energy");
  EXPECT_EQ(told([](Solid&) {}), "");
  Solid porous = *material_of_library("aluminium_porous").solid;
  porous.pores.compacted *= 1e3;
  EXPECT_EQ(complaint_of([&] { solid_law(porous, true, "x"); }).substr(0, 22),
            "x: compaction_pressure");
}

TEST(Tearing, strains_at_failure_that_no_metal_has_are_refused) {
  const auto told = [](int which, double value) {
    Solid solid = *material_of_library("copper").solid;
    solid.johnson_cook.d[which - 1] = value;
    return complaint_of([&] { solid_law(solid, true, "x"); });
  };
  EXPECT_EQ(told(1, -4.9).substr(0, 18), "x: johnson_cook_d1");  // none is left in shear
  EXPECT_EQ(told(1, 54).substr(0, 18), "x: johnson_cook_d1");    // in per cent
  EXPECT_EQ(told(3, 3.03),
            "x: johnson_cook_d3 = 3.03 lets it bear more strain where it is pulled: here it is "
            "exp(D3 triaxiality), so of a D3 of exp(-D3 triaxiality) give the negative");
  EXPECT_EQ(told(4, 1.4).substr(0, 18), "x: johnson_cook_d4");
  EXPECT_EQ(told(5, -1.12).substr(0, 18), "x: johnson_cook_d5");
}

TEST(Tearing, fracture_energy_needs_what_it_goes_with) {
  Solid solid = *material_of_library("copper").solid;
  solid.fracture_energy = 1e4;
  solid.spall_strength = 0;
  EXPECT_EQ(complaint_of([&] { solid_law(solid, true, "x"); }),
            "x: a solid with a stress needs spall_strength beside fracture_energy");
  solid = *material_of_library("basalt").solid;
  solid.fracture_energy = 1e4;
  EXPECT_EQ(complaint_of([&] { solid_law(solid, true, "x"); }),
            "x: weibull_k and fracture_energy: a solid breaks by its flaws, or as metals do; leave "
            "one out");
}

}  // namespace
}  // namespace spall
