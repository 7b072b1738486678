// The parser limits values inside values, but not the parts of a key.
// SPDX-License-Identifier: BSD-3-Clause
#include "keys/toml_text.hpp"

#include <algorithm>

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

}  // namespace

toml::table parse_toml(const std::string& text, const std::string& source) {
  check_depth(text, source);
  return toml::parse(text, source);
}

std::string toml_string(std::string_view text) {
  std::string quoted = "\"";
  for (char c : text) {
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f)
      quoted += fmt::format("\\u{:04x}", c);
    else
      quoted += c;
  }
  return quoted + "\"";
}

}  // namespace spall
