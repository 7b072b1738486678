// The one vector layer: eight numbers worked on at once, lane by lane.
// SPDX-License-Identifier: BSD-3-Clause
//
// Vectors are those of GCC and Clang, or pairs of them where eight doubles fill two registers:
// operators act lane by lane. What these do not offer stands here. With SPALL_SCALAR lanes are
// arrays and operations loops: the same kernels, as an oracle for vectors.
//
// Highway was looked at and left: its vectors have no fixed size, so that they cannot be fields of
// blocks and rows as ours are, and each formula would be written in calls (MulAdd, IfThenElse).
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "spall/registers.hpp"

namespace spall {

inline constexpr std::size_t lane_count = 8;

#ifdef SPALL_SCALAR

template <class T, std::size_t n>
struct alignas(n * sizeof(T)) LaneArray {
  T at[n];

  LaneArray() = default;
  constexpr LaneArray(T value) {
    for (T& one : at) one = value;
  }
  template <class... U>
  requires(sizeof...(U) == n) constexpr LaneArray(U... value) : at{static_cast<T>(value)...} {}
  constexpr T& operator[](std::size_t l) { return at[l]; }
  constexpr const T& operator[](std::size_t l) const { return at[l]; }

  using Mask = LaneArray<std::conditional_t<sizeof(T) == 8, std::int64_t, std::int32_t>, n>;
#define SPALL_OPERATOR(op, Result, value)                                \
  friend Result operator op(const LaneArray& a, const LaneArray& b) {    \
    Result result;                                                       \
    for (std::size_t l = 0; l < n; ++l) result[l] = value(a[l] op b[l]); \
    return result;                                                       \
  }
#define SPALL_ARITHMETIC(op)                                           \
  SPALL_OPERATOR(op, LaneArray, )                                      \
  friend LaneArray& operator op##=(LaneArray& a, const LaneArray& b) { \
    return a = a op b;                                                 \
  }
  SPALL_ARITHMETIC(+)
  SPALL_ARITHMETIC(-)
  SPALL_ARITHMETIC(*)
  SPALL_ARITHMETIC(/)
  SPALL_ARITHMETIC(&)
  SPALL_ARITHMETIC(|)
  SPALL_ARITHMETIC(<<)
  SPALL_ARITHMETIC(>>)
  SPALL_OPERATOR(<, Mask, -)
  SPALL_OPERATOR(>, Mask, -)
  SPALL_OPERATOR(<=, Mask, -)
  SPALL_OPERATOR(>=, Mask, -)
  SPALL_OPERATOR(==, Mask, -)
  SPALL_OPERATOR(!=, Mask, -)
#undef SPALL_ARITHMETIC
#undef SPALL_OPERATOR
  friend LaneArray operator-(const LaneArray& a) {
    return a * T(-1);
  }
  friend LaneArray operator~(const LaneArray& a) {
    return T(-1) - a;
  }
};

template <class T, std::size_t n>
using Vector = LaneArray<T, n>;

#endif

using Lanes = Vector<double, lane_count>;
using FloatLanes = Vector<float, lane_count>;
using IndexLanes = Vector<std::int32_t, lane_count>;
using LongLanes = Vector<std::int64_t, lane_count>;

/// Half of a row of eight doubles, four numbers of a body.
using RowHalf = Vector<double, 4>;

/// As many of them as fill a register: what is worked on at once where values should stay there.
#if defined(SPALL_AVX512) || defined(SPALL_SCALAR)
inline constexpr std::size_t register_lanes = lane_count;
#else
inline constexpr std::size_t register_lanes = lane_count / 2;
#endif
using RegisterLanes = Vector<double, register_lanes>;

/// Lanes k, k + 1 ... of `v`, a multiple of register_lanes.
inline RegisterLanes& part_of(Lanes& v, std::size_t k) {
  return reinterpret_cast<RegisterLanes*>(&v)[k / register_lanes];
}

template <class Real>
using LanesOf = Vector<Real, lane_count>;
template <class Real>
using HalfOf = Vector<Real, lane_count / 2>;

/// What a comparison of lanes gives: all bits of a lane, or none.
using LaneMask = decltype(Lanes{} < Lanes{});

template <class V>
using NumberOf = std::remove_cvref_t<decltype(std::declval<V>()[0])>;
template <class V>
inline constexpr std::size_t size_of_vector = sizeof(V) / sizeof(NumberOf<V>);

inline Lanes spread(double value) {
  return Lanes{} + value;
}

/// Eight numbers that need not be aligned.
template <class T>
[[gnu::always_inline]] inline LanesOf<T> load(const T* from) {
  LanesOf<T> v;
#ifdef SPALL_TWO_REGISTERS
  if constexpr (is_pair<LanesOf<T>>) {  // register by register, or it goes through memory
    __builtin_memcpy(&v.low, from, sizeof v.low);
    __builtin_memcpy(&v.high, from + lane_count / 2, sizeof v.high);
    return v;
  }
#endif
  __builtin_memcpy(&v, from, sizeof v);
  return v;
}

/// Lane by lane: a where `mask` holds, else b. Also of single numbers.
template <class M, class T>
[[gnu::always_inline]] inline T select(const M& mask, const T& a, const T& b) {
#ifdef SPALL_SCALAR
  if constexpr (!std::is_same_v<M, bool>) {
    T result;
    for (std::size_t l = 0; l < size_of_vector<T>; ++l) result[l] = mask[l] ? a[l] : b[l];
    return result;
  } else
#endif
#ifdef SPALL_TWO_REGISTERS
      if constexpr (is_pair<T> && !std::is_same_v<M, bool>)
    return {mask.low ? a.low : b.low, mask.high ? a.high : b.high};
  else
#endif
    return mask ? a : b;
}
template <class T>
[[gnu::always_inline]] inline T larger(const T& a, const T& b) {
  return select(a > b, a, b);
}
template <class T>
[[gnu::always_inline]] inline T smaller(const T& a, const T& b) {
  return select(a < b, a, b);
}

/// The numbers of a vector as another type's.
template <class T, class V>
[[gnu::always_inline]] inline auto convert(const V& v) {
  using To = Vector<T, size_of_vector<V>>;
#ifdef SPALL_SCALAR
  To result;
  for (std::size_t l = 0; l < size_of_vector<V>; ++l) result[l] = static_cast<T>(v[l]);
  return result;
#elif defined(SPALL_TWO_REGISTERS)
  return convert_registers<To>(v);
#else
  return __builtin_convertvector(v, To);
#endif
}

/// Elements k of (a, b); those of b are counted from the size of a.
template <int... k, class V>
[[gnu::always_inline]] inline auto shuffle(const V& a, const V& b) {
#ifdef SPALL_SCALAR
  constexpr int n = size_of_vector<V>;
  return Vector<NumberOf<V>, sizeof...(k)>{(k < n ? a[k % n] : b[k % n])...};
#elif defined(SPALL_TWO_REGISTERS)
  return shuffle_registers<Vector<NumberOf<V>, sizeof...(k)>, k...>(a, b);
#else
  return __builtin_shufflevector(a, b, k...);
#endif
}

/// Bit l is lane l.
inline LaneMask mask_of_bits(std::uint8_t bits) {
#ifdef SPALL_AVX512
  return reinterpret_cast<LaneMask>(_mm512_movm_epi64(bits));
#elif defined(SPALL_TWO_REGISTERS)
  using Half = LaneMask::Half;
  const Half all = Half{} + bits, low{1, 2, 4, 8}, high{16, 32, 64, 128};
  return {(all & low) == low, (all & high) == high};
#else
  LaneMask mask;
  for (std::size_t l = 0; l < lane_count; ++l) mask[l] = -(bits >> l & 1);
  return mask;
#endif
}
inline std::uint8_t bits_of_mask(const LaneMask& mask) {
#ifdef SPALL_AVX512
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
#elif defined(SPALL_TWO_REGISTERS)
  return static_cast<std::uint8_t>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask.low)) |
                                   _mm256_movemask_pd(reinterpret_cast<__m256d>(mask.high)) << 4);
#else
  std::uint8_t bits = 0;
  for (std::size_t l = 0; l < lane_count; ++l) bits |= (mask[l] & 1) << l;
  return bits;
#endif
}
inline bool any_lane(const LaneMask& mask) {
#ifdef SPALL_AVX512
  return _mm512_test_epi64_mask((__m512i)mask, (__m512i)mask) != 0;
#else
  return bits_of_mask(mask) != 0;
#endif
}

/// Of half as many lanes, which fill a register of AVX2.
using HalfMask = decltype(RowHalf{} < RowHalf{});
inline std::uint8_t bits_of_mask(const HalfMask& mask) {
#if defined(__AVX__) && !defined(SPALL_SCALAR)
  return static_cast<std::uint8_t>(_mm256_movemask_pd(reinterpret_cast<__m256d>(mask)));
#else
  return static_cast<std::uint8_t>((mask[0] & 1) | (mask[1] & 2) | (mask[2] & 4) | (mask[3] & 8));
#endif
}
inline bool any_lane(const HalfMask& mask) {
  return bits_of_mask(mask) != 0;
}

/// Pairwise, so that round-off stays small and does not depend on the instruction set.
inline double sum_of_lanes(const Lanes& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}
inline double sum_of_lanes(const RowHalf& v) {
  return (v[0] + v[1]) + (v[2] + v[3]);
}
inline double largest_lane(const Lanes& v) {
  double result = v[0];
  for (std::size_t l = 1; l < lane_count; ++l) result = larger<double>(result, v[l]);
  return result;
}

// --- rows (a body's numbers together) and lanes (eight bodies' numbers together) ---

// Transposed in pairs of numbers, then in pairs of pairs, all by shuffles of one instruction.
template <class V>
[[gnu::always_inline]] inline V evens(const V& a, const V& b) {
  return shuffle<0, 8, 2, 10, 4, 12, 6, 14>(a, b);
}
template <class V>
[[gnu::always_inline]] inline V odds(const V& a, const V& b) {
  return shuffle<1, 9, 3, 11, 5, 13, 7, 15>(a, b);
}
template <class V>
[[gnu::always_inline]] inline V even_pairs(const V& a, const V& b) {
  return shuffle<0, 1, 4, 5, 8, 9, 12, 13>(a, b);
}
template <class V>
[[gnu::always_inline]] inline V odd_pairs(const V& a, const V& b) {
  return shuffle<2, 3, 6, 7, 10, 11, 14, 15>(a, b);
}
template <class Half>
[[gnu::always_inline]] inline auto joined(const Half& low, const Half& high) {
  return shuffle<0, 1, 2, 3, 4, 5, 6, 7>(low, high);
}
template <class V>
[[gnu::always_inline]] inline auto low_half(const V& v) {
  return shuffle<0, 1, 2, 3>(v, v);
}
/// Row k of the result holds lane k of every row. What is not asked for costs nothing.
template <class V>
[[gnu::always_inline]] inline void transpose(V (&v)[lane_count]) {
  V low[4], high[4];  // elements 0 2 4 6 and 1 3 5 7 of two rows
  for (int k = 0; k < 4; ++k) {
    low[k] = evens(v[2 * k], v[2 * k + 1]);
    high[k] = odds(v[2 * k], v[2 * k + 1]);
  }
  for (int odd = 0; odd < 2; ++odd) {
    const V* of = odd ? high : low;
    const V p0 = even_pairs(of[0], of[1]), p1 = even_pairs(of[2], of[3]);
    const V q0 = odd_pairs(of[0], of[1]), q1 = odd_pairs(of[2], of[3]);
    v[0 + odd] = even_pairs(p0, p1);
    v[4 + odd] = odd_pairs(p0, p1);
    v[2 + odd] = even_pairs(q0, q1);
    v[6 + odd] = odd_pairs(q0, q1);
  }
}

/// x, y, z of eight half rows: `half(l)` is that of lane l.
template <class Half>
[[gnu::always_inline]] inline void lanes_of_halves(Half&& half, auto* x, auto* y, auto* z) {
  const auto a = joined(half(0), half(2)), b = joined(half(1), half(3));
  const auto c = joined(half(4), half(6)), d = joined(half(5), half(7));
  const auto ab = evens(a, b), cd = evens(c, d);
  *x = even_pairs(ab, cd);
  *y = even_pairs(odds(a, b), odds(c, d));
  *z = odd_pairs(ab, cd);
}

/// The half rows (x, y, z, w) of lanes 0 to 7.
template <class V, class Half>
[[gnu::always_inline]] inline void halves_of_lanes(const V& x, const V& y, const V& z, const V& w,
                                                   Half (&half)[lane_count]) {
  for (int odd = 0; odd < 2; ++odd) {
    const V xy = odd ? odds(x, y) : evens(x, y), zw = odd ? odds(z, w) : evens(z, w);
    half[0 + odd] = shuffle<0, 1, 8, 9>(xy, zw);
    half[2 + odd] = shuffle<2, 3, 10, 11>(xy, zw);
    half[4 + odd] = shuffle<4, 5, 12, 13>(xy, zw);
    half[6 + odd] = shuffle<6, 7, 14, 15>(xy, zw);
  }
}

/// Three doubles and a zero.
inline RowHalf load_three(const double* from) {
#ifdef SPALL_AVX512
  return _mm256_maskz_loadu_pd(7, from);
#else
  return RowHalf{from[0], from[1], from[2], 0.0};
#endif
}

/// from[at[l]].
inline Lanes gather(const double* from, const IndexLanes& at) {
#ifdef SPALL_AVX512
  return _mm512_mask_i32gather_pd(_mm512_setzero_pd(), 0xff, (__m256i)at, from, 8);
#elif defined(SPALL_TWO_REGISTERS)
  return {RowHalf{from[at[0]], from[at[1]], from[at[2]], from[at[3]]},
          RowHalf{from[at[4]], from[at[5]], from[at[6]], from[at[7]]}};
#else
  Lanes v;
  for (std::size_t l = 0; l < lane_count; ++l) v[l] = from[at[l]];
  return v;
#endif
}

/// Numbers that stand one after another into the lanes of `bits`; zero in the others.
inline Lanes load_packed(const double* from, unsigned bits) {
#if defined(SPALL_AVX512)
  return _mm512_maskz_expandloadu_pd(static_cast<__mmask8>(bits), from);
#elif defined(SPALL_TWO_REGISTERS)
  const LaneMask wanted = mask_of_bits(static_cast<std::uint8_t>(bits));
  const auto half = [](const double* at, unsigned of, const LaneMask::Half& lanes) -> RowHalf {
    const RowHalf v = _mm256_maskload_pd(at, first_lanes(std::popcount(of)));
    return select(lanes, permuted(v, lane_permutations.unpack[of]), RowHalf{});
  };
  return {half(from, bits & 15, wanted.low),
          half(from + std::popcount(bits & 15), bits >> 4, wanted.high)};
#else
  Lanes v{};
  for (std::size_t l = 0; l < lane_count; ++l)
    if (bits >> l & 1) v[l] = *from++;
  return v;
#endif
}
inline void store_packed(const Lanes& v, unsigned bits, double* to) {
#if defined(SPALL_AVX512)
  const auto first = static_cast<__mmask8>((1u << std::popcount(bits)) - 1);
  _mm512_mask_storeu_pd(to, first,
                        _mm512_maskz_compress_pd(static_cast<__mmask8>(bits), (__m512d)v));
#elif defined(SPALL_TWO_REGISTERS)
  const auto store = [](double* at, unsigned of, const RowHalf& half) {
    _mm256_maskstore_pd(at, first_lanes(std::popcount(of)),
                        permuted(half, lane_permutations.pack[of]));
  };
  store(to, bits & 15, v.low);
  store(to + std::popcount(bits & 15), bits >> 4, v.high);
#else
  for (std::size_t l = 0; l < lane_count; ++l)
    if (bits >> l & 1) *to++ = v[l];
#endif
}
/// The indices of the lanes of `bits`, to a place with room for eight; returns how many.
inline std::size_t store_packed(const IndexLanes& v, unsigned bits, std::int32_t* to) {
#if defined(SPALL_AVX512)
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to),
                      _mm256_maskz_compress_epi32(static_cast<__mmask8>(bits), (__m256i)v));
  return static_cast<unsigned>(std::popcount(bits));
#elif defined(SPALL_TWO_REGISTERS)
  const __m256i by = _mm256_cvtepu8_epi32(
      _mm_loadl_epi64(reinterpret_cast<const __m128i*>(lane_permutations.pack_indices[bits])));
  _mm256_storeu_si256(reinterpret_cast<__m256i*>(to), _mm256_permutevar8x32_epi32((__m256i)v, by));
  return static_cast<unsigned>(std::popcount(bits));
#else
  std::size_t count = 0;
  for (std::size_t l = 0; l < lane_count; ++l) {
    to[count] = v[l];
    count += bits >> l & 1;
  }
  return count;
#endif
}

// --- functions ---

/// a b + c, rounded once where the machine can: a compiler may fuse a product and a sum or not.
inline RowHalf multiply_add(double a, const RowHalf& b, const RowHalf& c) {
#if defined(__FMA__) && !defined(SPALL_SCALAR)
  return _mm256_fmadd_pd(RowHalf{} + a, b, c);
#else
  return a * b + c;
#endif
}

inline double square_root(double v) {
  return std::sqrt(v);
}
template <class V>
[[gnu::always_inline]] inline V square_root(V v) {
  for (std::size_t l = 0; l < size_of_vector<V>; ++l) v[l] = std::sqrt(v[l]);
  return v;
}

#if defined(__AVX__) && !defined(SPALL_SCALAR)
inline RowHalf square_root(const RowHalf& v) {
  return _mm256_sqrt_pd(v);
}
#endif
#ifdef SPALL_TWO_REGISTERS
inline Lanes square_root(const Lanes& v) {
  return {square_root(v.low), square_root(v.high)};
}
#endif

#ifdef SPALL_AVX512
/// 1/sqrt(v) to 2^-14; 0 where v is 0.
inline Lanes estimate_inverse_sqrt(const Lanes& v) {
  const __mmask8 positive = _mm512_cmp_pd_mask(v, _mm512_setzero_pd(), _CMP_GT_OQ);
  return _mm512_maskz_rsqrt14_pd(positive, v);
}
#endif

/// 1/sqrt(v) to the last bit or two; 0 where v is 0, so that coincident points do nothing.
/// Multiplying v by a power of four scales the result exactly, while it is a normal float.
inline RowHalf inverse_sqrt(const RowHalf& v) {
#ifdef SPALL_TWO_REGISTERS
  // The machine estimates inverse roots of floats alone, to 3/2 2^-12.
  if (!any_lane((v < 0x1p-126) | (v > 0x1p127))) [[likely]] {
    const RowHalf y = _mm256_cvtps_pd(_mm_rsqrt_ps(_mm256_cvtpd_ps(v)));
    const RowHalf e = 1.0 - (v * y) * y;  // of the series below 63/256 e^5 < 2^-53 is left
    return y + y * (e * (e * (e * (e * 0.2734375 + 0.3125) + 0.375) + 0.5));
  }
#endif
  return select(v > 0.0, 1.0 / square_root(v), RowHalf{});
}
inline Lanes inverse_sqrt(const Lanes& v) {
#if defined(SPALL_AVX512)
  // The estimate y is good to 2^-14; with e = 1 - v y^2 the series of y / sqrt(1 - e) up to e^3
  // leaves 35/128 e^4 < 2^-53. One multiplication fewer than two Newton steps, and a shorter chain.
  const Lanes y = estimate_inverse_sqrt(v);
  const Lanes e = 1.0 - (v * y) * y;
  const Lanes series = e * (e * (e * 0.3125 + 0.375) + 0.5);
  return y + y * series;
#elif defined(SPALL_TWO_REGISTERS)
  return {inverse_sqrt(v.low), inverse_sqrt(v.high)};
#else
  return select(v > 0.0, 1.0 / square_root(v), Lanes{});
#endif
}

/// sqrt(v) of what is positive or zero.
inline Lanes root_of(const Lanes& v) {
  return v * inverse_sqrt(v);
}

inline RowHalf root_of(const RowHalf& v) {
  return square_root(v);
}

/// sqrt(v) to a relative error below `estimate_error`.
inline constexpr double estimate_error = 0x1p-13;
inline Lanes estimate_sqrt(const Lanes& v) {
#ifdef SPALL_AVX512
  return v * estimate_inverse_sqrt(v);
#else
  return square_root(v);
#endif
}

inline RowHalf estimate_sqrt(const RowHalf& v) {
  return square_root(v);
}

inline constexpr double ln2_high = 0x1.62e42fefa38p-1, ln2_low = 0x1.ef35793c7673p-45;
/// Adding it leaves the nearest integer in the lowest bits.
inline constexpr double integer_shift = 0x1.8p52;

/// exp(x) to two units in the last place for |x| < 700: x = n ln 2 + f, Taylor's series of e^f.
template <class V>
[[gnu::always_inline]] inline V exponential(const V& x) {
  using Long = Vector<std::int64_t, size_of_vector<V>>;
  constexpr double log2_e = 1.4426950408889634074;
  const V shifted = x * log2_e + integer_shift;
  const V n = shifted - integer_shift;
  const V f = (x - n * ln2_high) - n * ln2_low;
  const V f2 = f * f, f4 = f2 * f2;
  const V a = (1.0 + f) + f2 * (1 / 2. + f * (1 / 6.));
  const V b = (1 / 24. + f * (1 / 120.)) + f2 * (1 / 720. + f * (1 / 5040.));
  const V c = (1 / 40320. + f * (1 / 362880.)) +
              f2 * (1 / 3628800. + f * (1 / 39916800.) + f2 * (1 / 479001600.));
  const V series = a + f4 * (b + f4 * c);
  return std::bit_cast<V>(std::bit_cast<Long>(series) + (std::bit_cast<Long>(shifted) << 52));
}

/// ln x to two units in the last place, of normal positive numbers: x = 2^n m with m between
/// sqrt(1/2) and sqrt(2); ln m = 2 artanh s = 2 (s + s^3/3 + ...), s = (m - 1)/(m + 1).
template <class V>
[[gnu::always_inline]] inline V logarithm(const V& x) {
  using Long = Vector<std::int64_t, size_of_vector<V>>;
  constexpr auto least = std::bit_cast<std::int64_t>(0.70710678118654752440);
  constexpr auto zero = std::bit_cast<std::int64_t>(integer_shift);
  const Long bits = std::bit_cast<Long>(x), exponent = (bits - least) >> 52;
  const V n = std::bit_cast<V>(exponent + zero) - integer_shift;
  const V m = std::bit_cast<V>(bits - (exponent << 52));
  const V s = (m - 1.0) / (m + 1.0), s2 = s * s, s4 = s2 * s2, s8 = s4 * s4;
  const V a = (1 / 3. + s2 * (1 / 5.)) + s4 * (1 / 7. + s2 * (1 / 9.));
  const V b = (1 / 11. + s2 * (1 / 13.)) + s4 * (1 / 15. + s2 * (1 / 17.));
  const V series = a + s8 * (b + s8 * (1 / 19. + s2 * (1 / 21.)));
  return n * ln2_high + (2.0 * s + (2.0 * s * s2 * series + n * ln2_low));
}

inline double logarithm(double x) {
  return std::log(x);
}

/// x^n of normal positive numbers, to |n ln x| units in the last place and three; what is less than
/// e^-700 is that, and what is more than e^700 wrong.
template <class V>
[[gnu::always_inline]] inline V power_of(const V& x, const V& n) {
  return exponential<V>(larger<V>(n * logarithm(x), V{} - 700.0));
}
inline double power_of(double x, double n) {
  return std::pow(x, n);
}

/// To a relative error of 1e-13, for normal positive numbers: a third of the exponent, then Halley.
inline Lanes cube_root(const Lanes& v) {
  constexpr double bias = 715094163.0 * 0x1p32;  // 2/3 of the exponent's, centred (Kahan)
  const Lanes third = convert<double>(std::bit_cast<LongLanes>(v)) / 3.0 + bias;
  Lanes r = std::bit_cast<Lanes>(convert<std::int64_t>(third));
  for (int k = 0; k < 2; ++k) {
    const Lanes r3 = r * r * r;
    r *= (r3 + 2.0 * v) / (2.0 * r3 + v);
  }
  return r;
}

/// x^n, n >= 0.
inline Lanes power(Lanes x, int n) {
  Lanes result = spread(1);
  for (; n > 0; n /= 2, x *= x)
    if (n % 2 == 1) result *= x;
  return result;
}

struct LaneVectors {
  Lanes x, y, z;
};

}  // namespace spall
