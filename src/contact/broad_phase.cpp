// A body looks for partners on its own level and on coarser ones, where it meets few cells.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/contact/broad_phase.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace spall {
namespace {

using CellIndex = std::array<std::int64_t, 3>;

std::uint64_t mix(std::uint64_t x) {  // finaliser of splitmix64
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9;
  x ^= x >> 27;
  x *= 0x94d049bb133111eb;
  return x ^ x >> 31;
}

/// Bodies of one size class in cells of `edge`, at least as wide as any of their grown spheres.
class Level {
 public:
  Level(double edge, std::vector<Index> rows, const std::vector<Vec3>& position) : edge_(edge) {
    std::size_t slots = 16;
    while (slots < 2 * rows.size()) slots *= 2;
    table_.assign(slots, {});
    next_.resize(rows.size());
    rows_ = std::move(rows);
    // Backwards, so that each cell's chain is in ascending order of rows.
    for (Index k = static_cast<Index>(rows_.size()); k-- > 0;) {
      Slot& slot = find(cell(position[rows_[k]]));
      next_[k] = slot.first;
      slot.first = k;
    }
  }

  double edge() const { return edge_; }

  /// Calls `f(row)` for the bodies of all cells that a box of half-width `reach` around `center`
  /// meets.
  template <class F>
  void for_each_near(const Vec3& center, double reach, F&& f) {
    const CellIndex low = cell(center - Vec3::Constant(reach));
    const CellIndex high = cell(center + Vec3::Constant(reach));
    for (auto z = low[2]; z <= high[2]; ++z)
      for (auto y = low[1]; y <= high[1]; ++y)
        for (auto x = low[0]; x <= high[0]; ++x)
          for (Index k = find({x, y, z}).first; k >= 0; k = next_[k]) f(rows_[k]);
  }

 private:
  struct Slot {
    CellIndex cell{};
    Index first = -1;
  };

  CellIndex cell(const Vec3& x) const {
    return {static_cast<std::int64_t>(std::floor(x[0] / edge_)),
            static_cast<std::int64_t>(std::floor(x[1] / edge_)),
            static_cast<std::int64_t>(std::floor(x[2] / edge_))};
  }

  /// The cell's slot, or a free one that is its own from now on.
  Slot& find(const CellIndex& cell) {
    const std::uint64_t hash =
        mix(static_cast<std::uint64_t>(cell[0]) * 0x9e3779b97f4a7c15 +
            mix(static_cast<std::uint64_t>(cell[1]) + mix(static_cast<std::uint64_t>(cell[2]))));
    std::size_t at = hash & (table_.size() - 1);
    while (table_[at].first >= 0 && table_[at].cell != cell) at = (at + 1) & (table_.size() - 1);
    if (table_[at].first < 0) table_[at].cell = cell;
    return table_[at];
  }

  double edge_;
  std::vector<Index> rows_;
  std::vector<Index> next_;
  std::vector<Slot> table_;
};

std::uint64_t pair_key(BodyId i, BodyId j) {
  return mix(static_cast<std::uint64_t>(i) * 0x9e3779b97f4a7c15 + static_cast<std::uint64_t>(j));
}

BodyId partner_id(const Bodies& bodies, const Pairs& pairs, Index p) {
  return pairs.j[p] == ground ? -1 - pairs.plane[p] : bodies.id[pairs.j[p]];
}

}  // namespace

Pairs find_pairs(const Bodies& bodies, std::span<const double> reach,
                 const std::vector<Plane>& planes) {
  Pairs boundary, interior;
  auto add = [&](Index a, Index b, std::int32_t plane) {
    if (b >= 0 && bodies.id[a] > bodies.id[b]) std::swap(a, b);
    Pairs& part = a >= bodies.owned || b >= bodies.owned ? boundary : interior;
    part.i.push_back(a);
    part.j.push_back(b);
    part.plane.push_back(plane);
  };

  const Index count = bodies.size();
  if (count > 0) {
    double smallest = infinity;
    for (Index b = 0; b < count; ++b) smallest = std::min(smallest, bodies.radius[b] + reach[b]);
    std::vector<std::vector<Index>> rows_of_level;
    std::vector<int> level_of(count);
    for (Index b = 0; b < count; ++b) {
      // The level's cells are 2^(l + 1) times the smallest grown radius wide.
      const int level = std::max(0, std::ilogb((bodies.radius[b] + reach[b]) / smallest)) + 1;
      level_of[b] = level;
      if (level >= static_cast<int>(rows_of_level.size())) rows_of_level.resize(level + 1);
      rows_of_level[level].push_back(b);
    }
    std::vector<Level> levels;
    std::vector<int> slot(rows_of_level.size(), -1);
    for (std::size_t l = 0; l < rows_of_level.size(); ++l) {
      if (rows_of_level[l].empty()) continue;
      slot[l] = static_cast<int>(levels.size());
      levels.emplace_back(std::ldexp(2 * smallest, static_cast<int>(l)),
                          std::move(rows_of_level[l]), bodies.position);
    }
    for (Index a = 0; a < count; ++a) {
      const double grown = bodies.radius[a] + reach[a];
      for (int l = slot[level_of[a]]; l < static_cast<int>(levels.size()); ++l) {
        const bool same = l == slot[level_of[a]];
        levels[l].for_each_near(bodies.position[a], grown + levels[l].edge() / 2, [&](Index b) {
          if (same && b <= a) return;
          if (a >= bodies.owned && b >= bodies.owned) return;
          const double limit = grown + bodies.radius[b] + reach[b];
          if ((bodies.position[b] - bodies.position[a]).squaredNorm() <= limit * limit)
            add(a, b, -1);
        });
      }
    }
  }
  for (Index b = 0; b < bodies.owned; ++b)
    for (std::size_t k = 0; k < planes.size(); ++k)
      if (planes[k].normal.dot(bodies.position[b] - planes[k].point) <= bodies.radius[b] + reach[b])
        add(b, ground, static_cast<std::int32_t>(k));

  Pairs pairs = std::move(boundary);
  pairs.boundary = pairs.size();
  pairs.i.insert(pairs.i.end(), interior.i.begin(), interior.i.end());
  pairs.j.insert(pairs.j.end(), interior.j.begin(), interior.j.end());
  pairs.plane.insert(pairs.plane.end(), interior.plane.begin(), interior.plane.end());
  pairs.impulse.assign(pairs.size(), Vec3::Zero());
  return pairs;
}

ContactMemory remember(const Bodies& bodies, const Pairs& pairs, bool once) {
  ContactMemory memory;
  for (Index p = 0; p < pairs.size(); ++p) {
    if (pairs.impulse[p].isZero(0) || (once && pairs.i[p] >= bodies.owned)) continue;
    memory.add(bodies.id[pairs.i[p]], partner_id(bodies, pairs, p), pairs.impulse[p]);
  }
  return memory;
}

void recall(const Bodies& bodies, const ContactMemory& memory, Pairs& pairs) {
  // A table at most half full; who finds a place taken takes the next.
  constexpr Index none = -1;
  std::vector<Index> table(std::bit_ceil(2 * memory.i.size() + 1), none);
  const std::size_t last = table.size() - 1;
  for (std::size_t m = 0; m < memory.i.size(); ++m) {
    std::size_t at = pair_key(memory.i[m], memory.j[m]) & last;
    while (table[at] != none) at = (at + 1) & last;
    table[at] = static_cast<Index>(m);
  }
  for (Index p = 0; p < pairs.size(); ++p) {
    const BodyId i = bodies.id[pairs.i[p]], j = partner_id(bodies, pairs, p);
    for (std::size_t at = pair_key(i, j) & last; table[at] != none; at = (at + 1) & last)
      if (memory.i[table[at]] == i && memory.j[table[at]] == j)
        pairs.impulse[p] = memory.impulse[table[at]];
  }
}

}  // namespace spall
