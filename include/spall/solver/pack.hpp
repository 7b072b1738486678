// Eight doubles at a time: the lanes in which the solver's kernels treat eight contacts at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

namespace spall {

/// Lanes of a pack. Arithmetic is the compiler's own on vectors of this size (GCC, Clang): one
/// register where the machine has 512-bit ones, several elsewhere. A pack may alias its doubles.
inline constexpr int lanes = 8;
using Pack = double __attribute__((vector_size(64)));
using HalfPack = double __attribute__((vector_size(32)));
using PackMask = std::int64_t __attribute__((vector_size(64)));
using FloatPack = float __attribute__((vector_size(32)));

inline Pack widen(FloatPack a) {
  return __builtin_convertvector(a, Pack);
}

inline double select(bool condition, double yes, double no) {
  return condition ? yes : no;
}
inline Pack select(PackMask condition, Pack yes, Pack no) {
  return condition ? yes : no;
}

template <class T>
T larger(T a, T b) {
  return select(a > b, a, b);
}

inline double square_root(double a) {
  return std::sqrt(a);
}
inline Pack square_root(Pack a) {
  for (int l = 0; l < lanes; ++l) a[l] = std::sqrt(a[l]);
  return a;
}

inline double sum(Pack a) {
  return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]));
}
inline double largest(Pack a) {
  double result = a[0];
  for (int l = 1; l < lanes; ++l) result = larger<double>(result, a[l]);
  return result;
}

}  // namespace spall
