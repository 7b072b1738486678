// The space-filling curve of gravity's tree: bodies' places on it, and its stretches known to all
// ranks. SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "base/morton.hpp"
#include "base/sort_by_key.hpp"
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

/// Of `count` bodies at `position_of(b)`, by keys.
std::vector<KeyedRow> sorted_keys(std::size_t count, auto&& position_of, double half) {
  std::vector<KeyedRow> rows(count);
  for (std::size_t b = 0; b < count; ++b)
    rows[b] = {curve_key(position_of(b), half), static_cast<Index>(b)};
  // Bodies that came from one rank only are in order.
  if (!std::ranges::is_sorted(rows, {}, &KeyedRow::key)) sort_by_key(rows);
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

/// The shortest stretch that holds both keys: they lie in different halves of it. Of one key it has
/// no halves.
inline Stretch stretch_of(std::uint64_t first, std::uint64_t last) {
  const int bit = std::bit_width(first ^ last) - 1;
  const std::uint64_t low = first >> (bit + 1) << (bit + 1);
  return {low, low + (std::uint64_t{1} << (bit + 1)), bit};
}

/// Halves the curve until no stretch holds more than 1/512 of all `bodies`, or `leaf_size` of them:
/// the same on every rank. Collective.
std::vector<Stretch> divide_curve(const Comm& comm, std::span<const KeyedRow> rows, double bodies,
                                  int leaf_size);

/// Calls `f(stretch, begin, end)` for those without halves that hold some of `rows`, which are
/// sorted, along the curve.
void for_each_stretch(std::span<const Stretch> all, std::span<const KeyedRow> rows, auto&& f) {
  const auto visit = [&](auto&& self, Index s, std::size_t begin, std::size_t end) -> void {
    if (begin == end) return;
    if (all[s].children[0] == Cell::none) return f(s, begin, end);
    for (Index half : all[s].children) {
      const auto part = rows.subspan(begin, end - begin);
      self(self, half, begin + first_at(part, all[half].low),
           begin + first_at(part, all[half].high));
    }
  };
  visit(visit, 0, 0, rows.size());
}

}  // namespace spall
