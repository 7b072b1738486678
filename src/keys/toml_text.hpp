// TOML as text: what is read, and what is written to be read again.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <string>
#include <string_view>

namespace spall {

/// Throws toml::parse_error where it is none, and Error at a key of more than a thousand parts:
/// each part is a table in a table, and they would fill the stack.
toml::table parse_toml(const std::string& text, const std::string& source);

/// An override is a line of TOML, "step=1e-4"; a text may come without quotes, "duration=10 s".
/// Throws Error where it is none.
toml::table parse_override(const std::string& text);

/// In quotes, with escapes: as a value or as a key.
std::string toml_string(std::string_view text);

/// With all digits that tell it from its neighbours, and never to be read as a whole number.
std::string toml_number(double value);

/// A document that reads as `table`, in the order of what was read; changes of it come first.
std::string toml_text(const toml::table& table);

}  // namespace spall
