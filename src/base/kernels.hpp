// Kernels for each level of instructions, chosen when the program starts.
// SPDX-License-Identifier: BSD-3-Clause
//
// The program is built for x86-64-v2, which every node of a cluster has. Files with kernels
// (SPALL_KERNELS in CMakeLists.txt) are compiled again for v3 (AVX2, FMA) and v4 (AVX-512), with
// SPALL_LEVEL defined. The linker joins a level's files into one object in which all but the entry
// points is local: no inline function or template of a level can stand in for the program's own.
#pragma once

#include <string>

namespace spall {

enum class Instructions { v2 = 2, v3, v4 };

/// Those in use: of this machine the best, but not better than SPALL_INSTRUCTIONS (v2, v3, v4)
/// allows, nor than those of another rank, for ranks must round alike. Throws Error if the variable
/// says something else.
Instructions instructions();
/// The best of this machine, or less: of all ranks when a session starts, and in tests.
void use_instructions(Instructions most);
/// "x86-64-v4", "scalar" …
std::string instructions_name();

template <class F>
F* kernel_of(F* v2, F* v3, F* v4) {
  switch (instructions()) {
    case Instructions::v2:
      return v2;
    case Instructions::v3:
      return v3;
    case Instructions::v4:
      return v4;
  }
  return nullptr;
}

}  // namespace spall

// SPALL_KERNEL(Result, name, (parameters), (arguments)) { … } defines an entry point: what others
// call, which passes its arguments on, and the function of this level.
#if defined(SPALL_LEVEL)
#define SPALL_PASTE(name, level) name##_##level
#define SPALL_AT_LEVEL(name, level) SPALL_PASTE(name, level)
#define SPALL_KERNEL(Result, name, parameters, arguments) \
  Result name parameters;                                 \
  Result SPALL_AT_LEVEL(name, SPALL_LEVEL) parameters;    \
  Result SPALL_AT_LEVEL(name, SPALL_LEVEL) parameters
#elif defined(SPALL_LEVELS)
#define SPALL_KERNEL(Result, name, parameters, arguments)           \
  Result name##_v2 parameters;                                      \
  Result name##_v3 parameters;                                      \
  Result name##_v4 parameters;                                      \
  Result name parameters {                                          \
    return kernel_of(&name##_v2, &name##_v3, &name##_v4) arguments; \
  }                                                                 \
  Result name##_v2 parameters
#else
#define SPALL_KERNEL(Result, name, parameters, arguments) Result name parameters
#endif
