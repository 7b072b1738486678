// Reads values with their units, and finds the key that a misspelt one was meant to be.
// SPDX-License-Identifier: BSD-3-Clause
#include "keys/section.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "spall/error.hpp"

namespace spall {
namespace {

std::string type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table:
      return "a table";
    case toml::node_type::array:
      return "an array";
    case toml::node_type::string:
      return "a text";
    case toml::node_type::boolean:
      return "true or false";
    case toml::node_type::integer:
    case toml::node_type::floating_point:
      return "a number";
    case toml::node_type::none:
    case toml::node_type::date:
    case toml::node_type::time:
    case toml::node_type::date_time:
      return "a date or time of day";
  }
  __builtin_unreachable();
}

/// Levenshtein's distance: insertions, removals and replacements from `a` to `b`.
std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({replaced, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

/// The nearest of `names`, unless more than a third of `given` would have to change.
std::optional<std::string> nearest(std::string_view given, const std::vector<std::string>& names) {
  constexpr std::size_t longest = 100;
  if (given.size() > longest) return std::nullopt;
  const auto closer = [&](const std::string& a, const std::string& b) {
    return edit_distance(given, a) < edit_distance(given, b);
  };
  const auto best = std::min_element(names.begin(), names.end(), closer);
  if (best == names.end() || 3 * edit_distance(given, *best) > given.size() + 2)
    return std::nullopt;
  return *best;
}

/// For messages: names of thousands of signs are no help.
std::string shortened(const std::string& name) {
  constexpr std::size_t most = 200;
  return name.size() <= most ? name : name.substr(0, most) + "...";
}

std::string kind_of(const Quantity& quantity) {
  const std::string unit = si_unit(quantity.dimension);
  return unit.empty() ? "number" : unit;
}

}  // namespace

void Section::read_all(const toml::table& table, const std::string& file, const Reader& read,
                       const Reference& listed) {
  Section section(&table, file, {}, &listed, nullptr);
  read(section);
  section.finish();
}

Section::Reference Section::reference(const Reader& read) {
  Reference all;
  const std::string no_file;
  Section section(nullptr, no_file, {}, nullptr, &all);
  read(section);
  return all;
}

void Section::radius(std::string_view meaning, double& radius) {
  const bool by_diameter = has("diameter");
  check("diameter", !by_diameter || !has("radius"), "is given beside radius: give one of them");
  if (reads(!by_diameter)) read({"radius", meaning, true}, radius, positive(dimension::length));
  if (reads(by_diameter)) {
    std::optional<double> diameter;
    read({"diameter", "in place of radius", false}, diameter, positive(dimension::length));
    if (diameter) radius = *diameter / 2;
  }
}

bool Section::read_below(std::string_view key, const toml::node* node, Path path,
                         const Reader& read) {
  if (node && !node->is_table())
    fail(key, fmt::format("is {}; a table is wanted: [{}] or {} = {{...}}", type_name(*node),
                          path.of_place, key));
  if (!node && !reference_) return false;
  Section section(node ? node->as_table() : nullptr, file_, std::move(path), listed_, reference_);
  read(section);
  section.finish();
  return true;
}

bool Section::table(std::string_view key, std::string_view meaning, const Reader& read) {
  return read_below(key, find({key, meaning, false}, "table", ""), below(key), read);
}

void Section::named_tables(std::string_view key, std::string_view meaning,
                           const std::function<void(Section&, const std::string&)>& read) {
  table(key, meaning, [&](Section& section) {
    if (reference_) return read(section, "");
    for (auto&& [name, node] : *section.table_) {
      const std::string own(name.str());  // clang 14 keeps structured bindings out of lambdas
      section.known_.push_back(own);
      section.read_below(own, &node, {section.path_of(own), section.path_.of_keys},
                         [&](Section& one) { read(one, own); });
    }
  });
}

void Section::tables(std::string_view key, std::string_view meaning, const Reader& read) {
  const toml::node* node = find({key, meaning, false}, "tables", "");
  if (reference_) {
    Section section(nullptr, file_, below(key), nullptr, reference_);
    read(section);
  }
  if (!node) return;
  if (!node->is_array_of_tables() && !(node->is_array() && node->as_array()->empty()))
    fail(key, fmt::format("is {}; tables are wanted: [[{}]]", type_name(*node), path_of(key)));
  std::size_t index = 0;
  for (const toml::node& element : *node->as_array()) {
    const toml::table& one = *element.as_table();
    const auto name = one["name"].value<std::string>();
    Path path = below(key);
    path.of_place += fmt::format(".{}", name.value_or(std::to_string(index)));
    Section section(&one, file_, std::move(path), listed_, nullptr);
    read(section);
    section.finish();
    ++index;
  }
}

std::string Section::path_of(std::string_view key) const {
  const std::string& path = path_.of_place;
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

std::string Section::key_of(std::string_view key) const {
  const std::string& path = path_.of_keys;
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

std::string Section::place_of(const toml::source_region& source) const {
  // What came by --set carries the option as its file; a table made by one has no place at all.
  if (!source.path) return file_;
  if (source.path->starts_with("--set")) return *source.path;
  return fmt::format("{}:{}:{}", *source.path, source.begin.line, source.begin.column);
}

std::string Section::place(std::string_view key) const {
  if (!table_) return "";
  const toml::node* node = table_->get(key);
  return fmt::format("{}: {}", place_of(node ? node->source() : table_->source()),
                     key.empty() ? path_.of_place : path_of(key));
}

void Section::fail(std::string_view key, std::string_view what) const {
  throw Error(fmt::format("{} {}", place(key), what));
}

void Section::check(std::string_view key, bool ok, std::string_view what) const {
  if (ok || reference_) return;
  // What is left out has no value that could be right.
  if (!missing_.empty()) fail(missing_.front(), "is missing");
  fail(key, what);
}

const toml::node* Section::find(const Key& key, const std::string& kind,
                                const std::string& by_default) {
  if (reference_) {
    const std::string& path = path_.of_keys;
    const std::size_t depth = path.empty() ? 0 : 1 + std::ranges::count(path, '.');
    reference_->keys.insert(key_of(key.name));
    reference_->text +=
        fmt::format("{:<24} {:<14} {:<11} {}\n", fmt::format("{:{}}{}", "", 2 * depth, key.name),
                    kind, key.required ? "required" : by_default, key.meaning);
    return nullptr;
  }
  if (!listed_->keys.contains(key_of(key.name)))
    throw std::logic_error(
        fmt::format("{} is read, but not listed: its condition must go through "
                    "Section::reads",
                    key_of(key.name)));
  known_.emplace_back(key.name);
  const toml::node* node = table_->get(key.name);
  if (!node && key.required) missing_.emplace_back(key.name);
  return node;
}

void Section::finish() const {
  if (reference_) return;
  // Unknown keys first: a required key that is missing is most often one that is misspelt.
  for (const auto& [key, node] : *table_) {
    if (std::ranges::find(known_, key.str()) != known_.end()) continue;
    const auto meant = nearest(key.str(), known_);
    throw Error(fmt::format("{}: {} is not a key here; {}", place_of(key.source()),
                            shortened(path_of(key.str())),
                            meant ? fmt::format("did you mean {}?", path_of(*meant))
                                  : fmt::format("the keys here are {}", fmt::join(known_, ", "))));
  }
  if (!missing_.empty()) fail(missing_.front(), "is missing");
}

double Section::number(std::string_view key, const toml::node& node,
                       const Quantity& quantity) const {
  double value = 0;
  if (node.is_number()) {
    // No double has all digits of a long whole number: value<double>() of that is none.
    value = node.is_integer() ? static_cast<double>(*node.value<std::int64_t>())
                              : *node.value<double>();
  } else if (const auto text = node.value<std::string>()) {
    try {
      value = parse_quantity(*text, quantity.dimension);
    } catch (const Error& error) {
      fail(key, fmt::format("= {}", error.what()));
    }
  } else {
    fail(key, fmt::format("is {}; {} is wanted", type_name(node), describe(quantity.dimension)));
  }
  const auto bad = [&](std::string_view wanted) {
    const std::string unit = si_unit(quantity.dimension);
    fail(key, fmt::format("= {}{}{}: {} is wanted", value, unit.empty() ? "" : " ", unit, wanted));
  };
  if (!std::isfinite(value)) bad("a finite value");
  // Products of several numbers, such as squares of speeds, stay finite and above zero.
  constexpr double most = 1e50, least = 1e-50;
  if (std::abs(value) > most || (value != 0 && std::abs(value) < least))
    bad(fmt::format("a size from {} to {}, or 0,", least, most));
  if (value > quantity.high) bad(fmt::format("{} to {}", quantity.low, quantity.high));
  if (value < quantity.low || (value == quantity.low && !quantity.low_allowed))
    bad(std::isfinite(quantity.high) ? fmt::format("{} to {}", quantity.low, quantity.high)
        : quantity.low_allowed       ? fmt::format("{} or more", quantity.low)
                                     : fmt::format("more than {}", quantity.low));
  return value;
}

Vec3 Section::vector(std::string_view key, const toml::node& node, const Quantity& quantity) const {
  const toml::array* array = node.as_array();
  if (!array || array->size() != 3)
    fail(key, fmt::format("is {}; three components are wanted, each {}",
                          array ? fmt::format("an array of {}", array->size()) : type_name(node),
                          describe(quantity.dimension)));
  return {number(key, *array->get(0), quantity), number(key, *array->get(1), quantity),
          number(key, *array->get(2), quantity)};
}

void Section::read(const Key& key, double& value, const Quantity& quantity) {
  if (const toml::node* node = find(key, kind_of(quantity), fmt::format("{}", value)))
    value = number(key.name, *node, quantity);
}

void Section::read(const Key& key, std::optional<double>& value, const Quantity& quantity) {
  if (const toml::node* node = find(key, kind_of(quantity), ""))
    value = number(key.name, *node, quantity);
}

void Section::read(const Key& key, Vec3& value, const Quantity& quantity) {
  const toml::node* node = find(key, fmt::format("[3 {}]", kind_of(quantity)),
                                fmt::format("[{}, {}, {}]", value[0], value[1], value[2]));
  if (node) value = vector(key.name, *node, quantity);
}

void Section::read(const Key& key, std::vector<double>& values, const Quantity& quantity) {
  const toml::node* node = find(key, fmt::format("[{} ...]", kind_of(quantity)), "[]");
  if (!node) return;
  if (!node->is_array()) fail(key.name, fmt::format("is {}; an array is wanted", type_name(*node)));
  values.clear();
  for (const toml::node& element : *node->as_array())
    values.push_back(number(key.name, element, quantity));
}

void Section::read(const Key& key, std::vector<Vec3>& values, const Quantity& quantity) {
  const toml::node* node = find(key, fmt::format("[[3 {}] ...]", kind_of(quantity)), "[]");
  if (!node) return;
  if (!node->is_array()) fail(key.name, fmt::format("is {}; an array is wanted", type_name(*node)));
  values.clear();
  for (const toml::node& element : *node->as_array())
    values.push_back(vector(key.name, element, quantity));
}

void Section::read(const Key& key, std::int64_t& value, std::int64_t low) {
  const toml::node* node = find(key, "whole number", std::to_string(value));
  if (!node) return;
  if (!node->is_integer())
    fail(key.name, fmt::format("is {}; a whole number is wanted",
                               node->is_number() ? "not whole" : type_name(*node)));
  value = *node->value<std::int64_t>();
  if (value < low) fail(key.name, fmt::format("= {}: {} or more is wanted", value, low));
}

void Section::read(const Key& key, std::string& value) {
  const toml::node* node = find(key, "text", value);
  if (!node) return;
  if (!node->is_string())
    fail(key.name, fmt::format("is {}; a text in quotes is wanted", type_name(*node)));
  value = *node->value<std::string>();
}

void Section::read(const Key& key, std::array<std::string, 2>& names) {
  const toml::node* node = find(key, "[2 text]", "");
  if (!node) return;
  const toml::array* array = node->as_array();
  if (!array || array->size() != 2 || !array->is_homogeneous<std::string>())
    fail(key.name, "is not two names, such as [\"rock\", \"ice\"]");
  for (std::size_t k = 0; k < 2; ++k) names[k] = *array->get(k)->value<std::string>();
}

void Section::read(const Key& key, std::vector<std::string>& values) {
  const toml::node* node = find(key, "[text ...]", "[]");
  if (!node) return;
  if (!node->is_array()) fail(key.name, fmt::format("is {}; an array is wanted", type_name(*node)));
  values.clear();
  for (const toml::node& element : *node->as_array()) {
    if (!element.is_string())
      fail(key.name, fmt::format("has {}; texts in quotes are wanted", type_name(element)));
    values.push_back(*element.value<std::string>());
  }
}

void Section::read(const Key& key, bool& value) {
  const toml::node* node = find(key, "true, false", value ? "true" : "false");
  if (!node) return;
  if (!node->is_boolean())
    fail(key.name, fmt::format("is {}; true or false is wanted", type_name(*node)));
  value = *node->value<bool>();
}

std::size_t Section::choose(const Key& key, const std::vector<std::string_view>& names,
                            std::size_t by_default) {
  const std::string meaning =
      fmt::format("{}{}{}", fmt::join(names, " | "), key.meaning.empty() ? "" : "; ", key.meaning);
  const toml::node* node =
      find({key.name, meaning, key.required}, "name", std::string(names[by_default]));
  if (!node) return by_default;
  const auto text = node->value<std::string>();
  const auto found = text ? std::ranges::find(names, *text) : names.end();
  if (found == names.end())
    fail(key.name, fmt::format("= {}: one of \"{}\" is wanted",
                               text ? fmt::format("\"{}\"", *text) : type_name(*node),
                               fmt::join(names, "\", \"")));
  return static_cast<std::size_t>(found - names.begin());
}

}  // namespace spall
