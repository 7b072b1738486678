// Parses a number with a compound unit and checks its dimension.
// SPDX-License-Identifier: BSD-3-Clause
#include "keys/units.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "spall/error.hpp"
#include "spall/types.hpp"

namespace spall {
namespace {

/// `factor` 10^`exponent` SI units: powers of ten are kept apart so that "0.237 mm" is 0.237e-3 to
/// the last bit.
struct Unit {
  std::string_view name;
  Dimension dimension;
  int exponent = 0;
  double factor = 1;
};

constexpr Dimension power{2, 1, -3};

// No hertz: all rates here are of angles, and as one "1 Hz" could be a radian or a turn a second.
constexpr Unit units_with_prefix[] = {
    {"m", dimension::length},      {"g", dimension::mass, -3},
    {"s", dimension::time},        {"N", dimension::force},
    {"Pa", dimension::pressure},   {"bar", dimension::pressure, 5},
    {"J", dimension::energy},      {"W", power},
    {"K", dimension::temperature},
};

// The international inch, foot and pound of 1959 and the standard gravity of a pound-force are
// exact (NIST Special Publication 811, 2008, appendix B).
constexpr double inch = 0.0254, foot = 0.3048, pound = 0.45359237, pound_force = pound * 9.80665;
constexpr double psi = pound_force / (inch * inch);

constexpr Unit units_alone[] = {
    {"t", dimension::mass, 3},
    {"min", dimension::time, 0, 60},
    {"h", dimension::time, 0, 3600},
    {"hour", dimension::time, 0, 3600},
    {"hours", dimension::time, 0, 3600},
    {"d", dimension::time, 0, 86400},
    {"day", dimension::time, 0, 86400},
    {"days", dimension::time, 0, 86400},
    {"rad", dimension::angle},
    {"deg", dimension::angle, 0, pi / 180},
    {"rev", dimension::angle, 0, 2 * pi},
    {"rpm", dimension::spin, 0, pi / 30},
    {"%", dimension::number, -2},
    {"in", dimension::length, 0, inch},
    {"mil", dimension::length, -3, inch},
    {"ft", dimension::length, 0, foot},
    {"lb", dimension::mass, 0, pound},
    {"lbf", dimension::force, 0, pound_force},
    {"psi", dimension::pressure, 0, psi},
    {"ksi", dimension::pressure, 3, psi},
};

struct Prefix {
  std::string_view name;
  int exponent;
};
constexpr Prefix prefixes[] = {{"p", -12}, {"n", -9}, {"u", -6}, {"µ", -6}, {"m", -3},
                               {"c", -2},  {"k", 3},  {"M", 6},  {"G", 9},  {"T", 12}};

constexpr struct {
  Dimension dimension;
  std::string_view name, unit, example;
} named[] = {
    {dimension::number, "a number", "", "0.5"},
    {dimension::angle, "an angle", "rad", "\"30 deg\""},
    {dimension::length, "a length", "m", "\"0.237 mm\""},
    {dimension::mass, "a mass", "kg", "\"500 kg\""},
    {dimension::time, "a time", "s", "\"10 s\" or \"12 h\""},
    {dimension::speed, "a speed", "m/s", "\"6.7 km/s\""},
    {dimension::acceleration, "an acceleration", "m/s^2", "\"9.81 m/s^2\""},
    {dimension::spin, "a rate", "rad/s", "\"0.1 rad/s\" or \"2 rev/h\""},
    {dimension::number_density, "a number a volume", "m^-3", "\"4e29 cm^-3\""},
    {dimension::density, "a density", "kg/m^3", "\"1600 kg/m^3\""},
    {dimension::force, "a force", "N", "\"500 N\""},
    {{0, 1, -2}, "a stiffness or surface energy", "N/m", "\"1 MN/m\" or \"0.1 J/m^2\""},
    {dimension::pressure, "a pressure", "Pa", "\"1.2 GPa\""},
    {dimension::specific_energy, "an energy of a mass", "J/kg", "\"1.05 MJ/kg\""},
    {dimension::energy, "an energy", "J", "\"1 kJ\""},
    {dimension::temperature, "a temperature", "K", "\"855 K\""},
    {dimension::per_pressure, "a share a pressure", "Pa^-1", "\"14.5 TPa^-1\""},
    {dimension::per_temperature, "a share a temperature", "K^-1", "\"0.13 kK^-1\""},
    {dimension::specific_heat, "a specific heat", "J/(kg K)", "\"896 J/(kg K)\""},
    {dimension::gravitational_parameter, "a gravitational parameter", "m^3/s^2",
     "\"34.1 m^3/s^2\""},
    {dimension::gravitational_constant, "a gravitational constant", "m^3/(kg s^2)",
     "\"6.6743e-11 m^3/(kg s^2)\""},
};

std::string name_of(Dimension dimension) {
  for (const auto& entry : named)
    if (entry.dimension == dimension) return std::string(entry.name);
  const std::string angle = dimension.angle == 0 ? "" : fmt::format(" rad^{}", dimension.angle);
  return fmt::format("in m^{} kg^{} s^{} K^{}{}", dimension.length, dimension.mass, dimension.time,
                     dimension.temperature, angle);
}

std::optional<Unit> find_unit(std::string_view name) {
  for (const Unit& unit : units_alone)
    if (unit.name == name) return unit;
  for (Unit unit : units_with_prefix) {
    if (unit.name == name) return unit;
    if (!name.ends_with(unit.name)) continue;
    for (const Prefix& prefix : prefixes)
      if (name.substr(0, name.size() - unit.name.size()) == prefix.name) {
        unit.exponent += prefix.exponent;
        return unit;
      }
  }
  return std::nullopt;
}

/// Takes the longest start of `text` whose characters `belong` off it.
template <class Belongs>
std::string_view take(std::string_view& text, Belongs&& belongs) {
  std::size_t length = 0;
  while (length < text.size() && belongs(text[length])) ++length;
  const std::string_view taken = text.substr(0, length);
  text.remove_prefix(length);
  return taken;
}

bool is_joint(char c) {
  return c == ' ' || c == '*' || c == '(' || c == ')';
}

/// The product of all units in `text`; after a '/' they divide.
Unit parse_units(std::string_view text, std::string_view whole, Dimension wanted) {
  Unit product{text, {}};
  int sign = 1;
  bool divides = false;  // by something
  while (true) {
    take(text, is_joint);
    if (text.empty()) {
      require(sign > 0 || divides, "\"{}\": nothing stands behind '/'", whole);
      return product;
    }
    if (text.front() == '/') {
      require(sign > 0, "\"{}\" has two '/': write all that divides after one", whole);
      sign = -1;
      text.remove_prefix(1);
      continue;
    }
    const std::string_view name = take(
        text, [](char c) { return !is_joint(c) && c != '/' && c != '^' && (c < '0' || c > '9'); });
    const bool raised = !text.empty() && text.front() == '^';
    if (raised) text.remove_prefix(1);
    int exponent = 1;
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), exponent);
    require((!raised || code == std::errc()) && std::abs(exponent) < 100,
            "\"{}\": \"{}^\" has no power", whole, name);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    const std::optional<Unit> unit = find_unit(name);
    require(unit.has_value(), "\"{}\": \"{}\" is not a unit known here; {} is wanted", whole, name,
            describe(wanted));
    const int n = sign * exponent;
    divides = sign < 0;
    product.dimension.length += n * unit->dimension.length;
    product.dimension.mass += n * unit->dimension.mass;
    product.dimension.time += n * unit->dimension.time;
    product.dimension.temperature += n * unit->dimension.temperature;
    product.dimension.angle += n * unit->dimension.angle;
    product.exponent += n * unit->exponent;
    product.factor *= std::pow(unit->factor, n);
  }
}

}  // namespace

double parse_quantity(std::string_view text, Dimension wanted) {
  std::string_view rest = text;
  take(rest, [](char c) { return c == ' '; });
  double value = 0;
  const auto [end, code] = std::from_chars(rest.data(), rest.data() + rest.size(), value);
  require(code == std::errc() && std::isfinite(value),
          "\"{}\" does not begin with a number; {} is wanted", text, describe(wanted));
  const std::string_view number = rest.substr(0, static_cast<std::size_t>(end - rest.data()));
  int open = 0;
  for (const char c : text) {
    open += c == '(' ? 1 : c == ')' ? -1 : 0;
    require(open >= 0, "\"{}\": a bracket has no partner", text);
  }
  require(open == 0, "\"{}\": a bracket has no partner", text);
  Unit unit = parse_units(rest.substr(number.size()), text, wanted);
  if (wanted.angle == 1 && unit.dimension.angle == 0) unit.dimension.angle = 1;
  require(unit.dimension == wanted, "\"{}\" is {}; {} is wanted", text, name_of(unit.dimension),
          describe(wanted));
  // The power of ten goes into the decimal text, so that the result is rounded once.
  const std::size_t e = number.find_first_of("eE");
  const bool has_exponent = e != number.npos && value != 0;
  const int exponent = has_exponent ? std::stoi(std::string(number.substr(e + 1))) : 0;
  const std::string decimal = fmt::format("{}e{}", number.substr(0, e), exponent + unit.exponent);
  const auto scaled = std::from_chars(decimal.data(), decimal.data() + decimal.size(), value);
  require(scaled.ec == std::errc(), "\"{}\" is beyond the numbers that are reckoned with", text);
  return value * unit.factor;
}

std::string si_unit(Dimension dimension) {
  for (const auto& entry : named)
    if (entry.dimension == dimension) return std::string(entry.unit);
  return name_of(dimension);
}

std::string describe_units() {
  std::string text = "\nUnits, as in \"6.7 km/s\", \"1600 kg/m^3\", \"896 J/(kg K)\"\n";
  const auto add = [&](std::string_view what, const auto& list) {
    text += fmt::format("{:<23}", what);
    for (const auto& one : list) text += fmt::format("{} ", one.name);
    text.back() = '\n';
  };
  add("with prefixes", units_with_prefix);
  add("prefixes", prefixes);
  add("alone", units_alone);
  return text;
}

std::string describe(Dimension dimension) {
  for (const auto& entry : named)
    if (entry.dimension == dimension)
      return fmt::format("{} such as {}", entry.name, entry.example);
  return name_of(dimension);
}

}  // namespace spall
