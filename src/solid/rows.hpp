// What sweeps need of a body, laid out for them: a row a body, a line of the cache or more.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "pairs/near_pairs.hpp"
#include "pairs/transfer.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// Of the spacing: up to which bodies are neighbours.
inline constexpr double neighbour_reach = 1.7;

/// Where a body is and how it moves.
struct alignas(64) MotionRow {
  RowHalf place;   ///< x, y, z (m), volume (m^3), no more than at rest: a weight in sums
  RowHalf motion;  ///< velocity (m/s), pressure (Pa); infinite: it has failed
};
static_assert(sizeof(MotionRow) == doubles_a_row * sizeof(double));

/// Sums over the neighbours that a body sees; x to the neighbour, v and p its velocity and pressure
/// less the body's own: K = sum w V x x, M = sum w V v x, S = sum w V r^2 p.
struct alignas(64) ShapeRow {
  RowHalf at[4];  ///< Kxx Kyy Kzz Kyz, Kzx Kxy Mxx Mxy, Mxz Myx Myy Myz, Mzx Mzy Mzz S
};
inline constexpr Index shape_width = sizeof(ShapeRow) / sizeof(double);

/// How a body answers: what its neighbours learn of it before forces. Volume and failure are those
/// that the sums were taken with.
struct alignas(64) ResponseRow {
  RowHalf at[6];  ///< sigma K^-1 by rows, times its volume over that weight (9); symmetric velocity
                  ///< gradient, as K (6); viscosity: rho c a and rho s a, a = 3/tr K, no more than
                  ///< in a lattice (2); velocity in the middle of the kick (3); volume (m^3); 1: it
                  ///< had failed, else 0; none (2)
};
inline constexpr Index response_width = sizeof(ResponseRow) / sizeof(double);

/// Force (N) and power that turns to heat (W); zero before a sweep.
using PushRow = RowHalf;

/// The halves `half` of the rows at these places, of `width` doubles each.
template <Index width>
[[gnu::always_inline]] inline void gather_half(const double* rows, const Index* places, Lanes* x,
                                               Lanes* y, Lanes* z, Lanes* w) {
  constexpr Index times = width / 4;
  const auto half = [&](int l) {
    return *reinterpret_cast<const RowHalf*>(rows +
                                             static_cast<std::ptrdiff_t>(places[l]) / 2 * times);
  };
  const auto a = joined(half(0), half(2)), b = joined(half(1), half(3));
  const auto c = joined(half(4), half(6)), d = joined(half(5), half(7));
  const auto even_ab = evens(a, b), even_cd = evens(c, d), odd_ab = odds(a, b), odd_cd = odds(c, d);
  *x = even_pairs(even_ab, even_cd);
  *y = even_pairs(odd_ab, odd_cd);
  *z = odd_pairs(even_ab, even_cd);
  if (w) *w = odd_pairs(odd_ab, odd_cd);
}

/// Adds lane l to the half row of the body at places[l], one after another.
template <Index width>
[[gnu::always_inline]] inline void add_half(const Lanes& x, const Lanes& y, const Lanes& z,
                                            const Lanes& w, const Index* places, double* rows) {
  constexpr Index times = width / 4;
  RowHalf lane[lane_count];
  halves_of_lanes(x, y, z, w, lane);
  for (int l : {0, 2, 1, 3, 4, 6, 5, 7})
    *reinterpret_cast<RowHalf*>(rows + static_cast<std::ptrdiff_t>(places[l]) / 2 * times) +=
        lane[l];
}

}  // namespace spall
