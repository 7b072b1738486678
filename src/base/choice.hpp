// Values that a user chooses by name: in a case file, on the command line.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string_view>

namespace spall {

template <class Enum>
struct Choice {
  std::string_view name;
  Enum value;
};

}  // namespace spall
