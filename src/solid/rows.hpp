// What sweeps need of a body, laid out for them: a row a body, a line of the cache or more.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pairs/near_pairs.hpp"
#include "pairs/transfer.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// Of the spacing: up to which bodies are neighbours.
inline constexpr double neighbour_reach = 1.7;

/// Of a neighbour at this share r/R of the reach; why so: docs/physics/solid.md.
template <class T>
constexpr T neighbour_weight(const T& share) {
  return 1.0 - share;
}

/// Where a body is and how it moves. Volume and pressure stay those that sums were taken with until
/// forces have been.
struct alignas(64) MotionRow {
  RowHalf place;   ///< x, y, z (m), volume (m^3), no more than at rest: a weight in sums
  RowHalf motion;  ///< velocity (m/s), pressure (Pa); infinite: it has failed
};
static_assert(sizeof(MotionRow) == doubles_a_row * sizeof(double));

/// Sums over the neighbours that a body sees; x to the neighbour, v and p its velocity and pressure
/// less the body's own: K = sum w V x x, M = sum w V v x, S = sum w V r^2 p.
struct alignas(64) ShapeRow {
  RowHalf at[4];  ///< Kxx Kyy Kzz Kyz, Kzx Kxy Mxx Mxy, Mxz Myx Myy Myz, Mzx Mzy Mzz S

  double trace() const { return at[0][0] + at[0][1] + at[0][2]; }  ///< of K; 0: it sees nobody
};
inline constexpr Index shape_width = sizeof(ShapeRow) / sizeof(double);

/// How a body answers: what its neighbours learn of it before forces.
struct alignas(64) ResponseRow {
  RowHalf at[6];  ///< sigma K^-1 by rows, times its volume over that weight (9); symmetric velocity
                  ///< gradient, as K (6); viscosity: rho c a and rho s a, a = 3/tr K, no more than
                  ///< in a lattice (2); half of the kick that comes (m/s, 3); s, for which its
                  ///< stress and viscosity act now, and of that before and after now (3); none (1)

  double& half_kick(int k) { return at[4][1 + k]; }
  double time() const { return at[5][0]; }
  double before() const { return at[5][1]; }
  double after() const { return at[5][2]; }
  bool acts() const { return at[5][1] < infinity; }
  void rest() { at[5] = RowHalf{0, infinity, infinity, 0}; }
  void act(double before, double after) { at[5] = RowHalf{before + after, before, after, 0}; }
};
inline constexpr Index response_width = sizeof(ResponseRow) / sizeof(double);

/// Impulse (N s) and the energy that turns to heat (J); zero before a sweep.
using PushRow = RowHalf;
inline constexpr Index push_width = sizeof(PushRow) / sizeof(double);

/// So many pairs are worked on at once: as many as a register holds.
inline constexpr std::size_t pair_lanes = register_lanes;
using PairLanes = RegisterLanes;
using PairMask = decltype(PairLanes{} < PairLanes{});

inline PairLanes spread_pairs(double value) {
  return PairLanes{} + value;
}

/// Where the row of a body begins, of `width` doubles.
template <Index width>
[[gnu::always_inline]] inline std::ptrdiff_t row_at(Index place) {
  if constexpr (width % doubles_a_row == 0)
    return std::ptrdiff_t{place} * (width / doubles_a_row);
  else
    return static_cast<std::uint32_t>(place) / (doubles_a_row / width);
}

/// The halves `half` of the rows at these places, of `width` doubles each.
template <Index width>
[[gnu::always_inline]] inline void gather_half(const double* rows, const Index* places,
                                               PairLanes* x, PairLanes* y, PairLanes* z,
                                               PairLanes* w) {
  const auto half = [&](int l) {
    return *reinterpret_cast<const RowHalf*>(rows + row_at<width>(places[l]));
  };
  if constexpr (pair_lanes == lane_count) {
    const auto a = joined(half(0), half(2)), b = joined(half(1), half(3));
    const auto c = joined(half(4), half(6)), d = joined(half(5), half(7));
    const auto even_ab = evens(a, b), even_cd = evens(c, d);
    const auto odd_ab = odds(a, b), odd_cd = odds(c, d);
    *x = even_pairs(even_ab, even_cd);
    *y = even_pairs(odd_ab, odd_cd);
    *z = odd_pairs(even_ab, even_cd);
    if (w) *w = odd_pairs(odd_ab, odd_cd);
  } else {
    const RowHalf a = half(0), b = half(1), c = half(2), d = half(3);
    const auto even_ab = shuffle<0, 4, 2, 6>(a, b), even_cd = shuffle<0, 4, 2, 6>(c, d);
    const auto odd_ab = shuffle<1, 5, 3, 7>(a, b), odd_cd = shuffle<1, 5, 3, 7>(c, d);
    *x = shuffle<0, 1, 4, 5>(even_ab, even_cd);
    *y = shuffle<0, 1, 4, 5>(odd_ab, odd_cd);
    *z = shuffle<2, 3, 6, 7>(even_ab, even_cd);
    if (w) *w = shuffle<2, 3, 6, 7>(odd_ab, odd_cd);
  }
}

/// The half rows (x, y, z, w) of the lanes.
template <class V>
[[gnu::always_inline]] inline void halves_of_pairs(const V& x, const V& y, const V& z, const V& w,
                                                   RowHalf (&half)[size_of_vector<V>]) {
  if constexpr (size_of_vector<V> == lane_count) {
    halves_of_lanes(x, y, z, w, half);
  } else {
    const auto even_xy = shuffle<0, 4, 2, 6>(x, y), odd_xy = shuffle<1, 5, 3, 7>(x, y);
    const auto even_zw = shuffle<0, 4, 2, 6>(z, w), odd_zw = shuffle<1, 5, 3, 7>(z, w);
    half[0] = shuffle<0, 1, 4, 5>(even_xy, even_zw);
    half[1] = shuffle<0, 1, 4, 5>(odd_xy, odd_zw);
    half[2] = shuffle<2, 3, 6, 7>(even_xy, even_zw);
    half[3] = shuffle<2, 3, 6, 7>(odd_xy, odd_zw);
  }
}

/// Adds lane l to the half row of the body at places[l], one after another.
template <Index width>
[[gnu::always_inline]] inline void add_half(const PairLanes& x, const PairLanes& y,
                                            const PairLanes& z, const PairLanes& w,
                                            const Index* places, double* rows) {
  RowHalf half[pair_lanes];
  halves_of_pairs(x, y, z, w, half);
  for (std::size_t l = 0; l < pair_lanes; ++l)
    *reinterpret_cast<RowHalf*>(rows + row_at<width>(places[l])) += half[l];
}

/// numbers[b] of the bodies b at these places.
[[gnu::always_inline]] inline PairLanes gather_numbers(const double* numbers, const Index* places) {
  PairLanes v;
  for (std::size_t l = 0; l < pair_lanes; ++l) v[l] = numbers[places[l] / doubles_a_row];
  return v;
}

}  // namespace spall
