// Between rows (a body's numbers together) and lanes (eight pairs' numbers together).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>

#include "pairs/near_pairs.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// The numbers of the rows that begin at these places.
inline IndexLanes rows_at(const Index* places) {
  return load(places) >> std::countr_zero(static_cast<unsigned>(doubles_a_row));
}

/// Vectors, three doubles each, of the bodies whose rows begin at these places.
[[gnu::always_inline]] inline LaneVectors gather_vectors(const double* vectors,
                                                         const Index* places) {
  LaneVectors v;
  lanes_of_halves([&](int l) { return load_three(vectors + 3 * (places[l] / doubles_a_row)); },
                  &v.x, &v.y, &v.z);
  return v;
}

/// Adds lane l to the half row that begins at `half` + places[l], one after another: two lanes may
/// name the same row.
[[gnu::always_inline]] inline void add_lanes(const LaneVectors& v, const Lanes& last,
                                             const Index* places, double* half) {
  RowHalf lane[lane_count];
  halves_of_lanes(v.x, v.y, v.z, last, lane);
  for (int l : {0, 2, 1, 3, 4, 6, 5, 7}) *reinterpret_cast<RowHalf*>(half + places[l]) += lane[l];
}

}  // namespace spall
