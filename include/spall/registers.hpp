// What registers hold: vectors of the compiler, and pairs of them. A part of spall/lanes.hpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#if defined(__AVX512F__) && defined(__AVX512DQ__) && defined(__AVX512VL__) && !defined(SPALL_SCALAR)
#define SPALL_AVX512
#elif defined(__AVX2__) && !defined(SPALL_SCALAR)
#define SPALL_TWO_REGISTERS
#endif
#if defined(__AVX__) && !defined(SPALL_SCALAR)
#include <immintrin.h>
#endif

#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

namespace spall {

#ifndef SPALL_SCALAR

template <class T, std::size_t n>
struct VectorOf {
  using Type __attribute__((vector_size(n * sizeof(T)))) = T;
};

#ifndef SPALL_TWO_REGISTERS

template <class T, std::size_t n>
using Vector = typename VectorOf<T, n>::Type;

#else

/// Lanes that fill two registers. GCC takes a vector that is wider than a register to pieces,
/// number by number, wherever it is compared or shuffled, and copies it through memory.
template <class T, std::size_t n>
struct alignas(n * sizeof(T)) LanePair {
  using Half = typename VectorOf<T, n / 2>::Type;
  using Mask = LanePair<std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>, n>;
  Half low, high;

  LanePair() = default;
  constexpr LanePair(T value) : low(Half{} + value), high(Half{} + value) {}
  constexpr LanePair(const Half& a, const Half& b) : low(a), high(b) {}
  template <class... U>
  requires(sizeof...(U) == n) constexpr LanePair(U... value) {
    const T at[] = {static_cast<T>(value)...};
    for (std::size_t l = 0; l < n / 2; ++l) low[l] = at[l], high[l] = at[n / 2 + l];
  }
  T& operator[](std::size_t l) { return reinterpret_cast<T*>(this)[l]; }
  constexpr T operator[](std::size_t l) const { return l < n / 2 ? low[l] : high[l - n / 2]; }

#define SPALL_OPERATOR(op, Result)                                                                \
  [[gnu::always_inline]] friend inline Result operator op(const LanePair& a, const LanePair& b) { \
    return {a.low op b.low, a.high op b.high};                                                    \
  }
#define SPALL_ARITHMETIC(op)                                                                      \
  SPALL_OPERATOR(op, LanePair)                                                                    \
  [[gnu::always_inline]] friend inline LanePair& operator op##=(LanePair& a, const LanePair& b) { \
    return a = a op b;                                                                            \
  }
  SPALL_ARITHMETIC(+)
  SPALL_ARITHMETIC(-)
  SPALL_ARITHMETIC(*)
  SPALL_ARITHMETIC(/)
  SPALL_ARITHMETIC(&)
  SPALL_ARITHMETIC(|)
  SPALL_ARITHMETIC(<<)
  SPALL_ARITHMETIC(>>)
  SPALL_OPERATOR(<, Mask)
  SPALL_OPERATOR(>, Mask)
  SPALL_OPERATOR(<=, Mask)
  SPALL_OPERATOR(>=, Mask)
#undef SPALL_ARITHMETIC
#undef SPALL_OPERATOR
  [[gnu::always_inline]] friend inline LanePair operator-(const LanePair& a) {
    return {-a.low, -a.high};
  }
  [[gnu::always_inline]] friend inline LanePair operator~(const LanePair& a) {
    return {~a.low, ~a.high};
  }
};

inline constexpr std::size_t register_bytes = 32;
template <class T, std::size_t n>
struct VectorOrPair {
  using Type = std::conditional_t<(n * sizeof(T) > register_bytes), LanePair<T, n>,
                                  typename VectorOf<T, n>::Type>;
};
template <class T, std::size_t n>
using Vector = typename VectorOrPair<T, n>::Type;

template <class V>
inline constexpr bool is_pair = false;
template <class T, std::size_t n>
inline constexpr bool is_pair<LanePair<T, n> > = true;

// --- conversions ---

template <class V>
[[gnu::always_inline]] inline auto low_of(const V& v) {
  if constexpr (is_pair<V>)
    return v.low;
  else
    return __builtin_shufflevector(v, v, 0, 1, 2, 3);
}
template <class V>
[[gnu::always_inline]] inline auto high_of(const V& v) {
  if constexpr (is_pair<V>)
    return v.high;
  else
    return __builtin_shufflevector(v, v, 4, 5, 6, 7);
}
template <class V, class Half>
[[gnu::always_inline]] inline V joined_halves(const Half& low, const Half& high) {
  if constexpr (is_pair<V>)
    return {low, high};
  else
    return __builtin_shufflevector(low, high, 0, 1, 2, 3, 4, 5, 6, 7);
}

/// Of vectors that fill a register or less. GCC writes some conversions as those of two numbers.
template <class To, class V>
[[gnu::always_inline]] inline To convert_register(const V& v) {
  using Floats = VectorOf<float, 4>::Type;
  using Doubles = VectorOf<double, 4>::Type;
  if constexpr (std::is_same_v<V, Floats> && std::is_same_v<To, Doubles>)
    return _mm256_cvtps_pd(v);
  else if constexpr (std::is_same_v<V, Doubles> && std::is_same_v<To, Floats>)
    return _mm256_cvtpd_ps(v);
  else
    return __builtin_convertvector(v, To);
}
template <class To, class V>
[[gnu::always_inline]] inline To convert_registers(const V& v) {
  if constexpr (is_pair<V> || is_pair<To>) {
    using HalfTo = decltype(low_of(std::declval<To>()));
    return joined_halves<To>(convert_register<HalfTo>(low_of(v)),
                             convert_register<HalfTo>(high_of(v)));
  } else {
    return convert_register<To>(v);
  }
}

// --- shuffles ---

/// The two registers that a part of a shuffle takes its numbers from.
struct Sources {
  int first = -1, second = -1;
};
/// Of numbers `from` registers of `width`; of more than two there is none.
template <std::size_t n>
constexpr Sources sources_of(const int (&from)[n], int width) {
  Sources sources;
  for (int k : from) {
    const int at = k / width;
    if (sources.first < 0) sources.first = at;
    if (at == sources.first) continue;
    if (sources.second < 0) sources.second = at;
    if (at != sources.second) return {};
  }
  if (sources.second < 0) sources.second = sources.first;
  return sources;
}

/// Numbers k of (a, b), as many as a register holds.
template <int... k, class V>
[[gnu::always_inline]] inline auto shuffle_to_register(const V& a, const V& b) {
  if constexpr (is_pair<V>) {
    constexpr int width = sizeof(a.low) / sizeof(a.low[0]);
    constexpr int from[] = {k...};
    constexpr Sources sources = sources_of(from, width);
    static_assert(sources.first >= 0, "of more than two registers: not one of a few instructions");
    const auto source = [&](int at) {
      return at == 0 ? a.low : at == 1 ? a.high : at == 2 ? b.low : b.high;
    };
    return __builtin_shufflevector(source(sources.first), source(sources.second),
                                   (k % width + (k / width == sources.first ? 0 : width))...);
  } else {
    return __builtin_shufflevector(a, b, k...);
  }
}
template <class To, int... k, class V, std::size_t... at>
[[gnu::always_inline]] inline To shuffle_to_pair(const V& a, const V& b,
                                                 std::index_sequence<at...>) {
  constexpr int from[] = {k...};
  return {shuffle_to_register<from[at]...>(a, b),
          shuffle_to_register<from[sizeof...(at) + at]...>(a, b)};
}
template <class To, int... k, class V>
[[gnu::always_inline]] inline To shuffle_registers(const V& a, const V& b) {
  if constexpr (is_pair<To>)
    return shuffle_to_pair<To, k...>(a, b, std::make_index_sequence<sizeof...(k) / 2>());
  else
    return shuffle_to_register<k...>(a, b);
}

// --- lanes packed one after another ---

/// How four doubles, or eight indices, of some lanes are put one after another and back: numbers of
/// 32 bits for a permutation.
struct LanePermutations {
  std::int32_t pack[16][8], unpack[16][8];  ///< of doubles, by bits
  std::uint8_t pack_indices[256][8];

  constexpr LanePermutations() : pack(), unpack(), pack_indices() {
    for (int bits = 0; bits < 16; ++bits)
      for (int l = 0, k = 0; l < 4; ++l)
        if (bits >> l & 1) {
          for (int part = 0; part < 2; ++part) {
            pack[bits][2 * k + part] = 2 * l + part;
            unpack[bits][2 * l + part] = 2 * k + part;
          }
          ++k;
        }
    for (int bits = 0; bits < 256; ++bits)
      for (int l = 0, k = 0; l < 8; ++l)
        if (bits >> l & 1) pack_indices[bits][k++] = static_cast<std::uint8_t>(l);
  }
};
inline constexpr LanePermutations lane_permutations;

inline __m256d permuted(__m256d v, const std::int32_t* by) {
  return _mm256_castsi256_pd(_mm256_permutevar8x32_epi32(
      _mm256_castpd_si256(v), _mm256_loadu_si256(reinterpret_cast<const __m256i*>(by))));
}
/// The first `count` of four lanes, as an instruction that reads or writes no others asks for them.
inline __m256i first_lanes(int count) {
  return _mm256_cmpgt_epi64(_mm256_set1_epi64x(count), _mm256_setr_epi64x(0, 1, 2, 3));
}

#endif
#endif

}  // namespace spall
