// What this machine can do, and what was asked for.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/kernels.hpp"

#include <algorithm>
#include <cstdlib>

#include "spall/error.hpp"

namespace spall {
namespace {

Instructions best() {
#ifdef SPALL_LEVELS
  if (__builtin_cpu_supports("x86-64-v4")) return Instructions::v4;
  if (__builtin_cpu_supports("x86-64-v3")) return Instructions::v3;
#endif
  return Instructions::v2;
}

Instructions asked_for() {
  const char* const variable = std::getenv("SPALL_INSTRUCTIONS");
  if (!variable) return best();
  const std::string level = variable;
  require(level == "v2" || level == "v3" || level == "v4",
          "SPALL_INSTRUCTIONS = \"{}\": v2, v3 or v4 is wanted", level);
  return std::min(best(), static_cast<Instructions>(level[1] - '0'));
}

Instructions& in_use() {
  static Instructions level = asked_for();
  return level;
}

}  // namespace

Instructions instructions() {
  return in_use();
}

void use_instructions(Instructions most) {
  in_use() = std::min(best(), most);
}

std::string instructions_name() {
#if defined(SPALL_SCALAR)
  return "scalar";
#elif defined(SPALL_LEVELS)
  return fmt::format("x86-64-v{}", static_cast<int>(instructions()));
#else
  return "as compiled";
#endif
}

}  // namespace spall
