// The parser limits values inside values, but not the parts of a key.
// SPDX-License-Identifier: BSD-3-Clause
#include "keys/toml_text.hpp"

#include <algorithm>
#include <sstream>
#include <utility>
#include <vector>

#include "spall/error.hpp"

namespace spall {
namespace {

/// Counts dots between the signs that end a key: more than it has parts, never less.
void check_depth(const std::string& text, const std::string& source) {
  constexpr int most_dots = 1000;
  int dots = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (std::string_view("=,[]{}#\n").find(text[at]) != std::string_view::npos) dots = 0;
    if (text[at] == '.') ++dots;
    if (dots <= most_dots) continue;
    const auto line = 1 + std::count(text.begin(), text.begin() + std::ptrdiff_t(at), '\n');
    throw Error(fmt::format("{}:{}: a key has more than {} parts", source, line, most_dots));
  }
}

using Entry = std::pair<std::string, const toml::node*>;

std::vector<Entry> entries_of(const toml::table& table) {
  std::vector<Entry> entries;
  for (auto&& [key, node] : table) {
    constexpr const char* bare = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
    const std::string name(key.str());
    const bool is_bare = !name.empty() && name.find_first_not_of(bare) == name.npos;
    entries.emplace_back(is_bare ? name : toml_string(name), &node);
  }
  std::ranges::stable_sort(entries, {},
                           [](const Entry& entry) { return entry.second->source().begin.line; });
  return entries;
}

std::string value_text(const toml::node& node) {
  std::string inside;
  const auto add = [&](const std::string& text) { inside += (inside.empty() ? "" : ", ") + text; };
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : entries_of(*table)) add(key + " = " + value_text(*value));
    return "{" + inside + "}";
  }
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& value : *array) add(value_text(value));
    return "[" + inside + "]";
  }
  if (const auto* text = node.as_string()) return toml_string(text->get());
  if (const auto* number = node.as_floating_point()) return toml_number(number->get());
  std::ostringstream other;
  node.visit([&](const auto& value) {
    if constexpr (toml::is_value<decltype(value)>) other << value;
  });
  return other.str();
}

bool has_heading(const toml::node& node) {
  return node.is_table()
             ? !node.as_table()->is_inline()
             : node.is_array_of_tables() && !node.as_array()->front().as_table()->is_inline();
}

/// The rows of a table, then the tables below it, each with its heading.
void add_table(std::string& text, const toml::table& table, const std::string& path) {
  const std::vector<Entry> entries = entries_of(table);
  for (const auto& [key, node] : entries)
    if (!has_heading(*node)) text += key + " = " + value_text(*node) + "\n";
  for (const auto& [key, node] : entries) {
    if (!has_heading(*node)) continue;
    const std::string whole = path.empty() ? key : path + "." + key;
    if (const toml::table* below = node->as_table()) {
      const auto is_row = [](const Entry& entry) { return !has_heading(*entry.second); };
      if (below->empty() || std::ranges::any_of(entries_of(*below), is_row))
        text += "\n[" + whole + "]\n";
      add_table(text, *below, whole);
    } else {
      for (const toml::node& element : *node->as_array()) {
        text += "\n[[" + whole + "]]\n";
        add_table(text, *element.as_table(), whole);
      }
    }
  }
}

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& source) {
  check_depth(text, source);
  return toml::parse(text, source);
}

toml::table parse_override(const std::string& text) {
  const std::string option = "--set " + text;
  const std::size_t equals = text.find('=');
  require(equals != text.npos && equals > 0, "{}: key.path=value is wanted", option);
  try {
    return parse_toml(text, option);
  } catch (const toml::parse_error&) {
    try {
      return parse_toml(fmt::format("{}='{}'", text.substr(0, equals), text.substr(equals + 1)),
                        option);
    } catch (const toml::parse_error& error) {
      throw Error(fmt::format("{}: {}", option, error.description()));
    }
  }
}

std::string toml_string(std::string_view text) {
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (c == '\n')
      quoted += "\\n";
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      quoted += fmt::format("\\u{:04x}", c);
    else
      quoted += c;
  }
  return quoted + "\"";
}

std::string toml_number(double value) {
  std::string text = fmt::format("{}", value);
  if (text.find_first_of(".en") == std::string::npos) text += ".0";
  return text;
}

std::string toml_text(const toml::table& table) {
  std::string text;
  add_table(text, table, "");
  return text;
}

}  // namespace spall
