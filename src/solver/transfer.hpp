// Between rows (a body's numbers together) and lanes (eight contacts' numbers together).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver/contact_blocks.hpp"

namespace spall {

/// v_j - v_i (out[0..2]) and s_i + s_j (out[3..5]) of eight contacts.
template <class Real>
[[gnu::always_inline]] inline void load_relative(const Row<3, Real>* rows, const Index* i,
                                                 const Index* j, LanesOf<Real>* out) {
  const LanesOf<Real> opposite = {-1, -1, -1, -1, 1, 1, 1, 1};
  LanesOf<Real> contact[lane_count];
  for (std::size_t l = 0; l < lane_count; ++l)
    contact[l] = rows[j[l]].at + opposite * rows[i[l]].at;
  transpose(contact);
  for (int d = 0; d < 3; ++d) {
    out[d] = contact[d];
    out[3 + d] = contact[4 + d];
  }
}

/// Adds impulses in[0..2] to row j and takes them from row i; adds in[3..5] to both.
template <class Real>
[[gnu::always_inline]] inline void add_opposite(Row<3, Real>* rows, const Index* i, const Index* j,
                                                const LanesOf<Real>* in) {
  const LanesOf<Real> opposite = {-1, -1, -1, -1, 1, 1, 1, 1};
  LanesOf<Real> contact[lane_count] = {in[0], in[1], in[2], {}, in[3], in[4], in[5], {}};
  transpose(contact);
  for (std::size_t l = 0; l < lane_count; ++l) {
    rows[i[l]].at += opposite * contact[l];
    rows[j[l]].at += contact[l];
  }
}

/// v_j - v_i (out[0..2]), s_i (out[3..5]) and s_j (out[6..8]) of eight contacts.
template <class Real>
[[gnu::always_inline]] inline void load_both(const Row<levers, Real>* rows, const Index* i,
                                             const Index* j, LanesOf<Real>* out) {
  LanesOf<Real> first[lane_count], second[lane_count];
  for (std::size_t l = 0; l < lane_count; ++l) {
    first[l] = rows[i[l]].at;
    second[l] = rows[j[l]].at;
  }
  transpose(first);
  transpose(second);
  for (int d = 0; d < 3; ++d) {
    out[d] = second[d] - first[d];
    out[3 + d] = first[4 + d];
    out[6 + d] = second[4 + d];
  }
}

/// Adds impulses in[0..2] and turns in[6..8] to row j; takes the impulses and in[3..5] from row i.
template <class Real>
[[gnu::always_inline]] inline void add_both(Row<levers, Real>* rows, const Index* i, const Index* j,
                                            const LanesOf<Real>* in) {
  LanesOf<Real> first[lane_count] = {in[0], in[1], in[2], {}, in[3], in[4], in[5], {}};
  LanesOf<Real> second[lane_count] = {in[0], in[1], in[2], {}, in[6], in[7], in[8], {}};
  transpose(first);
  transpose(second);
  for (std::size_t l = 0; l < lane_count; ++l) {
    rows[i[l]].at -= first[l];
    rows[j[l]].at += second[l];
  }
}

/// v_j - v_i of eight contacts.
template <class Real>
[[gnu::always_inline]] inline void load_relative(const Row<1, Real>* rows, const Index* i,
                                                 const Index* j, LanesOf<Real>* out) {
  lanes_of_halves(
      [&](int l) __attribute__((always_inline)) { return rows[j[l]].at - rows[i[l]].at; }, out,
      out + 1, out + 2);
}

/// Adds impulses to row j and takes them from row i.
template <class Real>
[[gnu::always_inline]] inline void add_opposite(Row<1, Real>* rows, const Index* i, const Index* j,
                                                const LanesOf<Real>* in) {
  HalfOf<Real> contact[lane_count];
  halves_of_lanes(in[0], in[1], in[2], LanesOf<Real>{}, contact);
  for (std::size_t l = 0; l < lane_count; ++l) {
    rows[i[l]].at -= contact[l];
    rows[j[l]].at += contact[l];
  }
}

}  // namespace spall
