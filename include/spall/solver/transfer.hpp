// Between rows (a body's numbers together) and packs (eight contacts' numbers together).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/solver/contact_blocks.hpp"

namespace spall {

// Eight rows are transposed in pairs of doubles, then in pairs of pairs: 20 shuffles for what would
// be 48 single loads. A shuffle's result lists elements of (a, b), b's counted from 8.
namespace transfer {

inline Pack evens(Pack a, Pack b) {
  return __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
}
inline Pack odds(Pack a, Pack b) {
  return __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
}
inline Pack even_pairs(Pack a, Pack b) {
  return __builtin_shufflevector(a, b, 0, 1, 4, 5, 8, 9, 12, 13);
}
inline Pack odd_pairs(Pack a, Pack b) {
  return __builtin_shufflevector(a, b, 2, 3, 6, 7, 10, 11, 14, 15);
}
inline Pack low_halves(Pack a, Pack b) {
  return __builtin_shufflevector(a, b, 0, 1, 2, 3, 8, 9, 10, 11);
}
inline Pack high_halves(Pack a, Pack b) {
  return __builtin_shufflevector(a, b, 4, 5, 6, 7, 12, 13, 14, 15);
}

inline Pack& as_pack(Row<3>& row) {
  return *reinterpret_cast<Pack*>(row.at);
}
inline const Pack& as_pack(const Row<3>& row) {
  return *reinterpret_cast<const Pack*>(row.at);
}
inline HalfPack& as_pack(Row<1>& row) {
  return *reinterpret_cast<HalfPack*>(row.at);
}
inline const HalfPack& as_pack(const Row<1>& row) {
  return *reinterpret_cast<const HalfPack*>(row.at);
}

inline constexpr Pack opposite = {-1, -1, -1, -1, 1, 1, 1, 1};

}  // namespace transfer

/// v_j - v_i (out[0..2]) and s_i + s_j (out[3..5]) of eight contacts.
[[gnu::always_inline]] inline void load_relative(const Row<3>* rows, const Index* i, const Index* j,
                                                 Pack* out) {
  using namespace transfer;
  Pack low[4], high[4];  // [x | z | sx | sz] and [y | 0 | sy | 0] of two contacts
  for (int k = 0; k < 4; ++k) {
    const int l = 2 * k, m = 2 * k + 1;
    const Pack a = as_pack(rows[j[l]]) + opposite * as_pack(rows[i[l]]);
    const Pack b = as_pack(rows[j[m]]) + opposite * as_pack(rows[i[m]]);
    low[k] = evens(a, b);
    high[k] = odds(a, b);
  }
  const Pack x_sx[2] = {even_pairs(low[0], low[1]), even_pairs(low[2], low[3])};
  const Pack z_sz[2] = {odd_pairs(low[0], low[1]), odd_pairs(low[2], low[3])};
  const Pack y_sy[2] = {even_pairs(high[0], high[1]), even_pairs(high[2], high[3])};
  out[0] = even_pairs(x_sx[0], x_sx[1]);
  out[1] = even_pairs(y_sy[0], y_sy[1]);
  out[2] = even_pairs(z_sz[0], z_sz[1]);
  out[3] = odd_pairs(x_sx[0], x_sx[1]);
  out[4] = odd_pairs(y_sy[0], y_sy[1]);
  out[5] = odd_pairs(z_sz[0], z_sz[1]);
}

/// Adds impulses in[0..2] to row j and takes them from row i; adds in[3..5] to both.
[[gnu::always_inline]] inline void add_opposite(Row<3>* rows, const Index* i, const Index* j,
                                                const Pack* in) {
  using namespace transfer;
  Pack contact[lanes];
  for (int odd = 0; odd < 2; ++odd) {
    const auto pair = [odd](Pack a, Pack b) { return odd ? odds(a, b) : evens(a, b); };
    const Pack xy = pair(in[0], in[1]), z0 = pair(in[2], Pack{});
    const Pack rs = pair(in[3], in[4]), t0 = pair(in[5], Pack{});
    const Pack p[2] = {low_halves(xy, z0), high_halves(xy, z0)};
    const Pack q[2] = {low_halves(rs, t0), high_halves(rs, t0)};
    for (int half = 0; half < 2; ++half) {
      contact[4 * half + odd] = even_pairs(p[half], q[half]);
      contact[4 * half + 2 + odd] = odd_pairs(p[half], q[half]);
    }
  }
  for (int l = 0; l < lanes; ++l) {
    as_pack(rows[i[l]]) += opposite * contact[l];
    as_pack(rows[j[l]]) += contact[l];
  }
}

/// v_j - v_i of eight contacts.
[[gnu::always_inline]] inline void load_relative(const Row<1>* rows, const Index* i, const Index* j,
                                                 Pack* out) {
  using namespace transfer;
  const auto two = [&](int l, int m) {
    const HalfPack a = as_pack(rows[j[l]]) - as_pack(rows[i[l]]);
    const HalfPack b = as_pack(rows[j[m]]) - as_pack(rows[i[m]]);
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  };
  Pack low[2], high[2];  // [x | z | x | z] and [y | 0 | y | 0]
  for (int k = 0; k < 2; ++k) {
    const int l = 4 * k;
    const Pack a = two(l, l + 2), b = two(l + 1, l + 3);
    low[k] = evens(a, b);
    high[k] = odds(a, b);
  }
  out[0] = even_pairs(low[0], low[1]);
  out[1] = even_pairs(high[0], high[1]);
  out[2] = odd_pairs(low[0], low[1]);
}

/// Adds impulses to row j and takes them from row i.
[[gnu::always_inline]] inline void add_opposite(Row<1>* rows, const Index* i, const Index* j,
                                                const Pack* in) {
  using namespace transfer;
  HalfPack contact[lanes];
  for (int odd = 0; odd < 2; ++odd) {
    const auto pair = [odd](Pack a, Pack b) { return odd ? odds(a, b) : evens(a, b); };
    const Pack xy = pair(in[0], in[1]), z0 = pair(in[2], Pack{});
    contact[0 + odd] = __builtin_shufflevector(xy, z0, 0, 1, 8, 9);
    contact[2 + odd] = __builtin_shufflevector(xy, z0, 2, 3, 10, 11);
    contact[4 + odd] = __builtin_shufflevector(xy, z0, 4, 5, 12, 13);
    contact[6 + odd] = __builtin_shufflevector(xy, z0, 6, 7, 14, 15);
  }
  for (int l = 0; l < lanes; ++l) {
    as_pack(rows[i[l]]) -= contact[l];
    as_pack(rows[j[l]]) += contact[l];
  }
}

}  // namespace spall
