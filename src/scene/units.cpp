// Parses a number with a compound unit and checks its dimension.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/scene/units.hpp"

#include <charconv>
#include <cmath>
#include <optional>

#include "spall/base/require.hpp"
#include "spall/base/types.hpp"

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

constexpr Dimension pressure{-1, 1, -2}, energy{2, 1, -2}, wattage{2, 1, -3};

constexpr Unit units_with_prefix[] = {
    {"m", dimension::length},
    {"g", dimension::mass, -3},
    {"s", dimension::time},
    {"N", dimension::force},
    {"Pa", pressure},
    {"bar", pressure, 5},
    {"J", energy},
    {"W", wattage},
    {"Hz", dimension::spin},
};

constexpr Unit units_alone[] = {
    {"t", dimension::mass, 3},
    {"min", dimension::time, 0, 60},
    {"h", dimension::time, 0, 3600},
    {"hour", dimension::time, 0, 3600},
    {"hours", dimension::time, 0, 3600},
    {"d", dimension::time, 0, 86400},
    {"day", dimension::time, 0, 86400},
    {"days", dimension::time, 0, 86400},
    {"rad", dimension::number},
    {"deg", dimension::number, 0, pi / 180},
    {"rev", dimension::number, 0, 2 * pi},
    {"rpm", dimension::spin, 0, pi / 30},
    {"%", dimension::number, -2},
};

struct Prefix {
  std::string_view name;
  int exponent;
};
constexpr Prefix prefixes[] = {{"p", -12}, {"n", -9}, {"u", -6}, {"µ", -6}, {"m", -3},
                               {"c", -2},  {"k", 3},  {"M", 6},  {"G", 9},  {"T", 12}};

constexpr struct {
  Dimension dimension;
  std::string_view name, example;
} named[] = {
    {dimension::number, "a number", "0.5"},
    {dimension::length, "a length", "\"0.237 mm\""},
    {dimension::mass, "a mass", "\"500 kg\""},
    {dimension::time, "a time", "\"10 s\" or \"12 h\""},
    {dimension::speed, "a speed", "\"6.7 km/s\""},
    {dimension::acceleration, "an acceleration", "\"9.81 m/s^2\""},
    {dimension::spin, "a rate", "\"0.1 rad/s\" or \"2 rev/h\""},
    {dimension::density, "a density", "\"1600 kg/m^3\""},
    {dimension::force, "a force", "\"500 N\""},
    {pressure, "a pressure", "\"1.2 GPa\""},
    {energy, "an energy", "\"1 kJ\""},
    {dimension::gravitational_parameter, "a gravitational parameter", "\"34.1 m^3/s^2\""},
    {dimension::gravitational_constant, "a gravitational constant", "\"6.6743e-11 m^3/(kg s^2)\""},
};

std::string name_of(Dimension dimension) {
  for (const auto& entry : named)
    if (entry.dimension == dimension) return std::string(entry.name);
  return fmt::format("a quantity in {}", si_unit(dimension));
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
Unit parse_units(std::string_view text, std::string_view whole) {
  Unit product{text, {}};
  int sign = 1;
  while (true) {
    take(text, is_joint);
    if (text.empty()) return product;
    if (text.front() == '/') {
      require(sign > 0, "\"{}\" has two '/': write all that divides after one", whole);
      sign = -1;
      text.remove_prefix(1);
      continue;
    }
    const std::string_view name = take(
        text, [](char c) { return !is_joint(c) && c != '/' && c != '^' && (c < '0' || c > '9'); });
    int power = 1;
    if (!text.empty() && text.front() == '^') text.remove_prefix(1);
    const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), power);
    text.remove_prefix(static_cast<std::size_t>(end - text.data()));
    const std::optional<Unit> unit = find_unit(name);
    require(unit.has_value(), "\"{}\": \"{}\" is not a unit known here", whole, name);
    power *= sign;
    product.dimension.length += power * unit->dimension.length;
    product.dimension.mass += power * unit->dimension.mass;
    product.dimension.time += power * unit->dimension.time;
    product.exponent += power * unit->exponent;
    product.factor *= std::pow(unit->factor, power);
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
  const Unit unit = parse_units(rest.substr(number.size()), text);
  require(unit.dimension == wanted, "\"{}\" is {}; {} is wanted", text, name_of(unit.dimension),
          describe(wanted));
  // The power of ten goes into the decimal text, so that the result is rounded once.
  const std::size_t e = number.find_first_of("eE");
  const int exponent = e == number.npos ? 0 : std::stoi(std::string(number.substr(e + 1)));
  const std::string decimal = fmt::format("{}e{}", number.substr(0, e), exponent + unit.exponent);
  std::from_chars(decimal.data(), decimal.data() + decimal.size(), value);
  return value * unit.factor;
}

std::string si_unit(Dimension dimension) {
  std::string above, below;
  for (const auto& [name, power] :
       {std::pair{"kg", dimension.mass}, std::pair{"m", dimension.length},
        std::pair{"s", dimension.time}}) {
    if (power == 0) continue;
    std::string& side = power > 0 ? above : below;
    if (!side.empty()) side += ' ';
    side += name;
    if (std::abs(power) > 1) side += fmt::format("^{}", std::abs(power));
  }
  if (below.empty()) return above;
  if (above.empty()) above = "1";
  return below.find(' ') == below.npos ? fmt::format("{}/{}", above, below)
                                       : fmt::format("{}/({})", above, below);
}

std::string describe(Dimension dimension) {
  for (const auto& entry : named)
    if (entry.dimension == dimension)
      return fmt::format("{} such as {}", entry.name, entry.example);
  return name_of(dimension);
}

}  // namespace spall
