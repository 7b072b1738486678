// Eight numbers at a time: the lanes in which the solver's kernels treat eight contacts at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <type_traits>

namespace spall {

/// Lanes of a pack. Arithmetic is the compiler's own on vectors of this size (GCC, Clang), in
/// registers as wide as the machine has. A pack may alias its numbers.
inline constexpr int lanes = 8;
using DoublePack = double __attribute__((vector_size(64)));
using FloatPack = float __attribute__((vector_size(32)));
using HalfDoublePack = double __attribute__((vector_size(32)));
using HalfFloatPack = float __attribute__((vector_size(16)));

template <class Real>
struct PackOf;
template <>
struct PackOf<double> {
  using Whole = DoublePack;
  using Half = HalfDoublePack;
};
template <>
struct PackOf<float> {
  using Whole = FloatPack;
  using Half = HalfFloatPack;
};
template <class Real>
using Pack = typename PackOf<Real>::Whole;
template <class Real>
using HalfPack = typename PackOf<Real>::Half;

template <class Real>
Pack<Real> convert(FloatPack a) {
  return __builtin_convertvector(a, Pack<Real>);
}
template <class Real>
Pack<Real> convert(DoublePack a) {
  return __builtin_convertvector(a, Pack<Real>);
}

/// Lane by lane; T is a number or a pack.
template <class T>
T larger(T a, T b) {
  return a > b ? a : b;
}

inline double square_root(double a) {
  return std::sqrt(a);
}
inline DoublePack square_root(DoublePack a) {
  for (int l = 0; l < lanes; ++l) a[l] = std::sqrt(a[l]);
  return a;
}
inline FloatPack square_root(FloatPack a) {
  for (int l = 0; l < lanes; ++l) a[l] = std::sqrt(a[l]);
  return a;
}

inline double sum(DoublePack a) {
  return ((a[0] + a[1]) + (a[2] + a[3])) + ((a[4] + a[5]) + (a[6] + a[7]));
}
inline double largest(DoublePack a) {
  double result = a[0];
  for (int l = 1; l < lanes; ++l) result = larger<double>(result, a[l]);
  return result;
}

}  // namespace spall
