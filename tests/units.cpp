// Quantities: values to the last bit, and what is said of wrong ones.
// SPDX-License-Identifier: BSD-3-Clause
#include "keys/units.hpp"

#include "spall/error.hpp"
#include "spall/types.hpp"
#include "testing.hpp"

namespace spall {
namespace {

std::string complaint(std::string_view text, Dimension wanted) {
  return complaint_of([&] { parse_quantity(text, wanted); });
}

TEST(Units, powers_of_ten_are_rounded_once) {
  EXPECT_EQ(parse_quantity("6.7 km/s", dimension::speed), 6700);
  EXPECT_EQ(parse_quantity("0.237 mm", dimension::length), 0.237e-3);
  EXPECT_EQ(parse_quantity("17.7ns", dimension::time), 17.7e-9);
  EXPECT_EQ(parse_quantity("-1.5e2 um", dimension::length), -1.5e-4);
  EXPECT_EQ(parse_quantity("7 µm", dimension::length), 7e-6);
  EXPECT_EQ(parse_quantity("2.7 g/cm^3", dimension::density), 2.7e3);
  EXPECT_EQ(parse_quantity("5 %", dimension::number), 0.05);
}

TEST(Units, brackets_have_partners) {
  EXPECT_EQ(complaint("1 m/(s", dimension::speed), "\"1 m/(s\": a bracket has no partner");
  EXPECT_EQ(complaint("1 m/s)", dimension::speed), "\"1 m/s)\": a bracket has no partner");
  EXPECT_EQ(complaint("1 )m(", dimension::length), "\"1 )m(\": a bracket has no partner");
  EXPECT_EQ(complaint("1 m /", dimension::length), "\"1 m /\": nothing stands behind '/'");
}

TEST(Units, compound_units_multiply_and_divide) {
  const Dimension pressure{-1, 1, -2}, specific_energy{2, 0, -2}, inertia{2, 1, 0};
  EXPECT_EQ(parse_quantity("1600 kg/m^3", dimension::density), 1600);
  EXPECT_EQ(parse_quantity("1600 kg m^-3", dimension::density), 1600);
  EXPECT_EQ(parse_quantity("1.2 GPa", pressure), 1.2e9);
  EXPECT_EQ(parse_quantity("12 kbar", pressure), 1.2e9);
  EXPECT_EQ(parse_quantity("9.5 MJ/kg", specific_energy), 9.5e6);
  EXPECT_EQ(parse_quantity("3 kg*m^2", inertia), 3);
  EXPECT_EQ(parse_quantity("500 N", dimension::force), 500);
  EXPECT_EQ(parse_quantity("0.896 kJ/(kg K)", dimension::specific_heat), 896);
  EXPECT_EQ(parse_quantity("6.6743e-11 m^3/(kg s^2)", dimension::gravitational_constant),
            6.6743e-11);
  EXPECT_EQ(parse_quantity("6.6743e-11 N m^2/kg^2", dimension::gravitational_constant), 6.6743e-11);
}

TEST(Units, times_and_angles_have_their_customary_units) {
  EXPECT_EQ(parse_quantity("12 h", dimension::time), 43200);
  EXPECT_EQ(parse_quantity("2 days", dimension::time), 172800);
  EXPECT_EQ(parse_quantity("10 min", dimension::time), 600);
  EXPECT_DOUBLE_EQ(parse_quantity("30 deg", dimension::angle), pi / 6);
  EXPECT_EQ(parse_quantity("0.5", dimension::angle), 0.5);
  EXPECT_EQ(parse_quantity("2 s^-1", dimension::spin), 2);
  EXPECT_DOUBLE_EQ(parse_quantity("90 deg/min", dimension::spin), pi / 120);
  EXPECT_DOUBLE_EQ(parse_quantity("60 rpm", dimension::spin), 2 * pi);
  EXPECT_DOUBLE_EQ(parse_quantity("36 km/h", dimension::speed), 10);
}

TEST(Units, inches_feet_pounds_and_their_pressures_are_the_exact_ones) {
  EXPECT_DOUBLE_EQ(parse_quantity("1 in", dimension::length), 0.0254);
  EXPECT_DOUBLE_EQ(parse_quantity("0.375 in", dimension::length), 9.525e-3);
  EXPECT_DOUBLE_EQ(parse_quantity("40 mil", dimension::length), 1.016e-3);
  EXPECT_DOUBLE_EQ(parse_quantity("1 ft", dimension::length), 0.3048);
  EXPECT_DOUBLE_EQ(parse_quantity("22000 ft/s", dimension::speed), 6705.6);
  EXPECT_DOUBLE_EQ(parse_quantity("1 lb", dimension::mass), 0.45359237);
  EXPECT_DOUBLE_EQ(parse_quantity("1 lbf", dimension::force), 4.4482216152605);
  // NIST SP 811, appendix B.8, to the seven digits that it prints.
  EXPECT_NEAR(parse_quantity("1 psi", dimension::pressure), 6.894757e3, 0.5e-3);
  EXPECT_NEAR(parse_quantity("1 ksi", dimension::pressure), 6.894757e6, 0.5);
  EXPECT_NEAR(parse_quantity("1 lb/in^3", dimension::density), 2.767990e4, 0.5e-2);
  EXPECT_DOUBLE_EQ(parse_quantity("1 lbf/in^2", dimension::pressure),
                   parse_quantity("1 psi", dimension::pressure));
  EXPECT_EQ(parse_quantity("2 min", dimension::time), 120);  // no milli-inches
}

TEST(Units, that_are_listed_are_known) {
  const std::string list = describe_units();
  for (const char* unit : {" bar ", " mil ", " psi "})
    EXPECT_NE(list.find(unit), list.npos) << list;
}

TEST(Units, wrong_ones_are_told_with_an_example) {
  EXPECT_EQ(complaint("6.7 km", dimension::speed),
            "\"6.7 km\" is a length; a speed such as \"6.7 km/s\" is wanted");
  EXPECT_EQ(complaint("6.7", dimension::speed),
            "\"6.7\" is a number; a speed such as \"6.7 km/s\" is wanted");
  EXPECT_EQ(complaint("30 deg", dimension::number),
            "\"30 deg\" is an angle; a number such as 0.5 is wanted");
  EXPECT_EQ(complaint("2 rev m", dimension::length),
            "\"2 rev m\" is in m^1 kg^0 s^0 K^0 rad^1; a length such as \"0.237 mm\" is wanted");
  EXPECT_EQ(complaint("3 furlong", dimension::length),
            "\"3 furlong\": \"furlong\" is not a unit known here; a length such as \"0.237 mm\" is "
            "wanted");
  EXPECT_EQ(
      complaint("1 Hz", dimension::spin),
      "\"1 Hz\": \"Hz\" is not a unit known here; a rate such as \"0.1 rad/s\" or \"2 rev/h\" is "
      "wanted");
  EXPECT_EQ(complaint("m", dimension::length),
            "\"m\" does not begin with a number; a length such as \"0.237 mm\" is wanted");
  EXPECT_EQ(complaint("inf m", dimension::length),
            "\"inf m\" does not begin with a number; a length such as \"0.237 mm\" is wanted");
  EXPECT_EQ(complaint("1 m/s/s", dimension::acceleration),
            "\"1 m/s/s\" has two '/': write all that divides after one");
  EXPECT_EQ(complaint("1 m^", dimension::length), "\"1 m^\": \"m^\" has no power");
}

}  // namespace
}  // namespace spall
