// Quantities as people write them: a number and its unit, turned into SI.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

namespace spall {

/// Powers of metre, kilogram, second, kelvin and radian. Where an angle is wanted a number is one,
/// in radians; where a number is wanted, as of a coefficient, an angle is none.
struct Dimension {
  int length = 0, mass = 0, time = 0, temperature = 0, angle = 0;
  bool operator==(const Dimension&) const = default;
};

namespace dimension {
inline constexpr Dimension number{}, angle{.angle = 1}, length{1, 0, 0}, mass{0, 1, 0},
    time{0, 0, 1}, speed{1, 0, -1}, acceleration{1, 0, -2}, spin{.time = -1, .angle = 1},
    density{-3, 1, 0}, force{1, 1, -2}, energy{2, 1, -2}, pressure{-1, 1, -2},
    specific_energy{2, 0, -2}, gravitational_parameter{3, 0, -2}, gravitational_constant{3, -1, -2},
    spring_constant{0, 1, -2}, temperature{0, 0, 0, 1}, specific_heat{2, 0, -2, -1},
    number_density{-3, 0, 0}, per_pressure{1, -1, 2}, per_temperature{0, 0, 0, -1};
}

/// "6.7 km/s", "0.237 mm", "12 h", "1.2 GPa", "1600 kg/m^3", "9.5 MJ/kg", "30 deg/min", "8 kg m^2":
/// units with powers, joined by '*' or a space; all after a '/' divides. The SI value of
/// `text`, correctly rounded where the unit is a power of ten. Throws Error, with an example of
/// what would be right, on an unknown unit or another dimension than `wanted`.
double parse_quantity(std::string_view text, Dimension wanted);

/// "m/s", "kg/m^3"; empty for a number.
std::string si_unit(Dimension dimension);

/// All units and prefixes, for `spall keys`.
std::string describe_units();

/// "a speed such as \"6.7 km/s\"".
std::string describe(Dimension dimension);

}  // namespace spall
