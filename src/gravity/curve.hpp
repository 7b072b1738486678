// The space-filling curve of gravity's tree: bodies' places on it, and its cuts known to all ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "base/morton.hpp"
#include "gravity/octree.hpp"
#include "spall/comm.hpp"

namespace spall {

constexpr int key_bits_per_axis = 21;
constexpr int key_bits = 3 * key_bits_per_axis;
constexpr std::uint64_t key_end = std::uint64_t{1} << key_bits;

/// Place along the Morton curve, which fills the cube of edge 2 `half` (m) about the origin; what
/// is beyond it, ejecta, lies on its faces.
inline std::uint64_t curve_key(const Vec3& x, double half) {
  constexpr double steps = 1 << key_bits_per_axis;
  const auto cell = [&](int k) {
    const double q = half > 0 ? (x[k] + half) / (2 * half) * steps : 0;
    return static_cast<std::uint64_t>(std::clamp(q, 0.0, steps - 1));
  };
  return interleave(cell(2), cell(1), cell(0));
}

struct KeyedRow {
  std::uint64_t key;
  Index row;
};

/// Stable, so that equal keys keep their order.
void radix_sort(std::vector<KeyedRow>& rows);

/// Of `count` bodies at `position_of(b)`, by keys.
std::vector<KeyedRow> sorted_keys(std::size_t count, auto&& position_of, double half) {
  std::vector<KeyedRow> rows(count);
  for (std::size_t b = 0; b < count; ++b)
    rows[b] = {curve_key(position_of(b), half), static_cast<Index>(b)};
  // Bodies that came from one rank only are in order.
  if (!std::ranges::is_sorted(rows, {}, &KeyedRow::key)) radix_sort(rows);
  return rows;
}

/// How many rows come before `key`.
inline std::size_t first_at(std::span<const KeyedRow> rows, std::uint64_t key) {
  return std::ranges::lower_bound(rows, key, {}, &KeyedRow::key) - rows.begin();
}

/// Keys [low, high) whose bits above `bit` agree.
struct Stretch {
  std::uint64_t low = 0, high = key_end;
  int bit = key_bits - 1;
  double bodies = 0;                                         ///< over all ranks
  std::array<Index, 2> children = {Cell::none, Cell::none};  ///< of the halves
  std::uint64_t middle() const { return low + (std::uint64_t{1} << bit); }
};

/// Halves the curve until no stretch holds more than `grain` of all `bodies`: the same on every
/// rank. Collective.
std::vector<Stretch> divide_curve(const Comm& comm, std::span<const KeyedRow> rows, double bodies,
                                  double grain);

/// The rank of each stretch without children, -1 of the others: equal numbers of bodies to each
/// rank, along the curve.
std::vector<int> deal_out(const Comm& comm, std::span<const Stretch> all);

}  // namespace spall
