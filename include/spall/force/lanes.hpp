// Eight doubles worked on at once, and the inverse square root that gravity is made of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#ifdef __AVX512F__
#include <immintrin.h>
#endif

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace spall {

inline constexpr std::size_t lane_count = 8;

/// GCC's and Clang's vector type: arithmetic and comparisons lane by lane on any machine.
using Lanes = double __attribute__((vector_size(lane_count * sizeof(double))));

inline Lanes spread(double value) {
  return Lanes{} + value;
}

/// What a comparison of lanes gives: all bits of a lane, or none.
using LaneMask = decltype(Lanes{} < Lanes{});

/// Bit l is lane l.
inline LaneMask mask_of_bits(std::uint8_t bits) {
#ifdef __AVX512DQ__
  return reinterpret_cast<LaneMask>(_mm512_movm_epi64(bits));
#else
  LaneMask mask;
  for (std::size_t l = 0; l < lane_count; ++l) mask[l] = -(bits >> l & 1);
  return mask;
#endif
}
inline std::uint8_t bits_of_mask(const LaneMask& mask) {
#ifdef __AVX512DQ__
  return _mm512_movepi64_mask(reinterpret_cast<__m512i>(mask));
#else
  std::uint8_t bits = 0;
  for (std::size_t l = 0; l < lane_count; ++l) bits |= (mask[l] & 1) << l;
  return bits;
#endif
}

/// Pairwise, so that round-off stays small and does not depend on the instruction set.
inline double sum_of_lanes(const Lanes& v) {
  return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
}

/// Row k of the result holds lane k of every row.
inline void transpose(Lanes (&v)[lane_count]) {
  Lanes a[8], b[8];
  for (int k = 0; k < 8; k += 2) {
    a[k] = __builtin_shufflevector(v[k], v[k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    a[k + 1] = __builtin_shufflevector(v[k], v[k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int k = 0; k < 2; ++k)
    for (int half = 0; half < 8; half += 4) {
      b[half + k] = __builtin_shufflevector(a[half + k], a[half + k + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      b[half + k + 2] =
          __builtin_shufflevector(a[half + k], a[half + k + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (int k = 0; k < 4; ++k) {
    v[k] = __builtin_shufflevector(b[k], b[k + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    v[k + 4] = __builtin_shufflevector(b[k], b[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

#ifdef __AVX512F__
/// 1/sqrt(v) to 2^-14; 0 where v is 0.
inline Lanes estimate_inverse_sqrt(const Lanes& v) {
  const __mmask8 positive = _mm512_cmp_pd_mask(v, _mm512_setzero_pd(), _CMP_GT_OQ);
  return _mm512_maskz_rsqrt14_pd(positive, v);
}
#endif

/// 1/sqrt(v) to the last bit or two; 0 where v is 0, so that coincident points do nothing.
/// Multiplying v by a power of four scales the result exactly.
inline Lanes inverse_sqrt(const Lanes& v) {
#ifdef __AVX512F__
  // The estimate y is good to 2^-14; with e = 1 - v y^2 the series of y / sqrt(1 - e) up to e^3
  // leaves 35/128 e^4 < 2^-53. One multiplication fewer than two Newton steps, and a shorter chain.
  const Lanes y = estimate_inverse_sqrt(v);
  const Lanes e = 1.0 - (v * y) * y;
  const Lanes series = e * (e * (e * 0.3125 + 0.375) + 0.5);
  return y + y * series;
#else
  Lanes result;
  for (std::size_t k = 0; k < lane_count; ++k) result[k] = v[k] > 0 ? 1.0 / std::sqrt(v[k]) : 0.0;
  return result;
#endif
}

/// sqrt(v) to a relative error below `estimate_error`.
inline constexpr double estimate_error = 0x1p-13;
inline Lanes estimate_sqrt(const Lanes& v) {
#ifdef __AVX512F__
  return v * estimate_inverse_sqrt(v);
#else
  Lanes result;
  for (std::size_t k = 0; k < lane_count; ++k) result[k] = std::sqrt(v[k]);
  return result;
#endif
}

}  // namespace spall
