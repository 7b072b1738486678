// Between rows (a body's numbers together) and packs (eight contacts' numbers together).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/solver/contact_blocks.hpp"

namespace spall {

// Eight rows are transposed in pairs of numbers, then in pairs of pairs: 20 shuffles for what would
// be 48 single loads. A shuffle's result lists elements of (a, b), b's counted from 8.
namespace transfer {

template <class P>
P evens(P a, P b) {
  return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
}
template <class P>
P odds(P a, P b) {
  return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
}
template <class P>
P even_pairs(P a, P b) {
  return __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13);
}
template <class P>
P odd_pairs(P a, P b) {
  return __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15);
}
template <class P>
P low_halves(P a, P b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
}
template <class P>
P high_halves(P a, P b) {
  return __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}

}  // namespace transfer

/// v_j - v_i (out[0..2]) and s_i + s_j (out[3..5]) of eight contacts.
template <class Real>
[[gnu::always_inline]] inline void load_relative(const Row<3, Real>* rows, const Index* i,
                                                 const Index* j, Pack<Real>* out) {
  using namespace transfer;
  using P = Pack<Real>;
  constexpr P opposite = {-1, -1, -1, -1, 1, 1, 1, 1};
  P low[4], high[4];  // [x | z | sx | sz] and [y | 0 | sy | 0] of two contacts
  for (int k = 0; k < 4; ++k) {
    const int l = 2 * k, m = 2 * k + 1;
    const P a = rows[j[l]].at + opposite * rows[i[l]].at;
    const P b = rows[j[m]].at + opposite * rows[i[m]].at;
    low[k] = evens(a, b);
    high[k] = odds(a, b);
  }
  const P x_sx[2] = {even_pairs(low[0], low[1]), even_pairs(low[2], low[3])};
  const P z_sz[2] = {odd_pairs(low[0], low[1]), odd_pairs(low[2], low[3])};
  const P y_sy[2] = {even_pairs(high[0], high[1]), even_pairs(high[2], high[3])};
  out[0] = even_pairs(x_sx[0], x_sx[1]);
  out[1] = even_pairs(y_sy[0], y_sy[1]);
  out[2] = even_pairs(z_sz[0], z_sz[1]);
  out[3] = odd_pairs(x_sx[0], x_sx[1]);
  out[4] = odd_pairs(y_sy[0], y_sy[1]);
  out[5] = odd_pairs(z_sz[0], z_sz[1]);
}

/// Adds impulses in[0..2] to row j and takes them from row i; adds in[3..5] to both.
template <class Real>
[[gnu::always_inline]] inline void add_opposite(Row<3, Real>* rows, const Index* i, const Index* j,
                                                const Pack<Real>* in) {
  using namespace transfer;
  using P = Pack<Real>;
  constexpr P opposite = {-1, -1, -1, -1, 1, 1, 1, 1};
  P contact[lanes];
  for (int odd = 0; odd < 2; ++odd) {
    const auto pair = [odd](P a, P b) { return odd ? odds(a, b) : evens(a, b); };
    const P xy = pair(in[0], in[1]), z0 = pair(in[2], P{});
    const P rs = pair(in[3], in[4]), t0 = pair(in[5], P{});
    const P p[2] = {low_halves(xy, z0), high_halves(xy, z0)};
    const P q[2] = {low_halves(rs, t0), high_halves(rs, t0)};
    for (int half = 0; half < 2; ++half) {
      contact[4 * half + odd] = even_pairs(p[half], q[half]);
      contact[4 * half + 2 + odd] = odd_pairs(p[half], q[half]);
    }
  }
  for (int l = 0; l < lanes; ++l) {
    rows[i[l]].at += opposite * contact[l];
    rows[j[l]].at += contact[l];
  }
}

/// v_j - v_i of eight contacts.
template <class Real>
[[gnu::always_inline]] inline void load_relative(const Row<1, Real>* rows, const Index* i,
                                                 const Index* j, Pack<Real>* out) {
  using namespace transfer;
  using P = Pack<Real>;
  const auto two = [&](int l, int m) -> P {
    const HalfPack<Real> a = rows[j[l]].at - rows[i[l]].at;
    const HalfPack<Real> b = rows[j[m]].at - rows[i[m]].at;
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  };
  P low[2], high[2];  // [x | z | x | z] and [y | 0 | y | 0]
  for (int k = 0; k < 2; ++k) {
    const int l = 4 * k;
    const P a = two(l, l + 2), b = two(l + 1, l + 3);
    low[k] = evens(a, b);
    high[k] = odds(a, b);
  }
  out[0] = even_pairs(low[0], low[1]);
  out[1] = even_pairs(high[0], high[1]);
  out[2] = odd_pairs(low[0], low[1]);
}

/// Adds impulses to row j and takes them from row i.
template <class Real>
[[gnu::always_inline]] inline void add_opposite(Row<1, Real>* rows, const Index* i, const Index* j,
                                                const Pack<Real>* in) {
  using namespace transfer;
  using P = Pack<Real>;
  HalfPack<Real> contact[lanes];
  for (int odd = 0; odd < 2; ++odd) {
    const auto pair = [odd](P a, P b) { return odd ? odds(a, b) : evens(a, b); };
    const P xy = pair(in[0], in[1]), z0 = pair(in[2], P{});
    contact[0 + odd] = __builtin_shufflevector(xy, z0, 0, 1, 8, 9);
    contact[2 + odd] = __builtin_shufflevector(xy, z0, 2, 3, 10, 11);
    contact[4 + odd] = __builtin_shufflevector(xy, z0, 4, 5, 12, 13);
    contact[6 + odd] = __builtin_shufflevector(xy, z0, 6, 7, 14, 15);
  }
  for (int l = 0; l < lanes; ++l) {
    rows[i[l]].at -= contact[l];
    rows[j[l]].at += contact[l];
  }
}

}  // namespace spall
