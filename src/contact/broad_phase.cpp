// A body looks for partners on its own level and on coarser ones, where it meets few cells.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/contact/broad_phase.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "spall/contact/rows_of_ids.hpp"

namespace spall {
namespace {

using CellIndex = std::array<std::int64_t, 3>;

/// A body's sphere, grown by its reach.
struct Grown {
  Vec3 center;
  double radius;
  Index row;
};

/// Spheres of one size class in cells about as wide as they are. Cells lie in blocks of
/// 4 x 4 x 4, so that a look at neighbouring cells seldom leaves a block; spheres lie in memory in
/// the order of their cells, and in a cell in that of their rows.
class Level {
 public:
  explicit Level(const std::vector<Grown>& spheres) : table_(64, none), spheres_(spheres.size()) {
    double edge = 0;
    for (const Grown& s : spheres) {
      edge += 2 * s.radius / static_cast<double>(spheres.size());
      largest_ = std::max(largest_, s.radius);
      low_ = low_.cwiseMin(s.center);
      high_ = high_.cwiseMax(s.center);
    }
    cells_a_metre_ = 1 / edge;
    std::vector<std::size_t> cell_of(spheres.size());
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const CellIndex c = cell(spheres[k].center);
      cell_of[k] = cells * add_block(key_of(block_of(c))) + inside(c);
    }
    start_.assign(cells * keys_.size() + 2, 0);
    for (std::size_t c : cell_of) ++start_[c + 2];
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    for (std::size_t k = 0; k < spheres.size(); ++k)
      spheres_[start_[cell_of[k] + 1]++] = spheres[k];
  }

  /// Calls `f(run)` with runs of spheres, among which are all that meet the given one.
  template <class F>
  void for_each_near(const Vec3& center, double radius, F&& f) const {
    const Vec3 reach = Vec3::Constant(radius + largest_);
    if ((center + reach - low_).minCoeff() < 0 || (high_ - center + reach).minCoeff() < 0) return;
    const CellIndex low = cell(center - reach), high = cell(center + reach);
    const CellIndex first = block_of(low), last = block_of(high);
    CellIndex b;
    for (b[2] = first[2]; b[2] <= last[2]; ++b[2])
      for (b[1] = first[1]; b[1] <= last[1]; ++b[1])
        for (b[0] = first[0]; b[0] <= last[0]; ++b[0]) {
          const Index block = table_[place(key_of(b))];
          if (block == none) continue;
          CellIndex from, to;
          for (int k = 0; k < 3; ++k) {
            from[k] = std::max(low[k], side * b[k]);
            to[k] = std::min(high[k], side * b[k] + side - 1);
          }
          CellIndex c{from[0], 0, 0};
          for (c[2] = from[2]; c[2] <= to[2]; ++c[2])
            for (c[1] = from[1]; c[1] <= to[1]; ++c[1]) {
              const Index* run = &start_[cells * block + inside(c)];
              const Index end = run[to[0] - from[0] + 1];
              f(std::span(spheres_).subspan(run[0], end - run[0]));
            }
        }
  }

 private:
  static constexpr std::int64_t side = 4;                   // of a block, in cells
  static constexpr std::size_t cells = side * side * side;  // of a block
  static constexpr Index none = -1;

  CellIndex cell(const Vec3& x) const {
    CellIndex c;
    for (int k = 0; k < 3; ++k) c[k] = static_cast<std::int64_t>(std::floor(x[k] * cells_a_metre_));
    return c;
  }
  static CellIndex block_of(const CellIndex& c) { return {c[0] >> 2, c[1] >> 2, c[2] >> 2}; }
  static std::size_t inside(const CellIndex& c) {
    return static_cast<std::size_t>((c[0] & 3) + side * (c[1] & 3) + side * side * (c[2] & 3));
  }
  /// The same for blocks 2^21 apart: their bodies are too far away to be mistaken for partners.
  static std::uint64_t key_of(const CellIndex& block) {
    constexpr std::uint64_t last = (1u << 21) - 1;
    return (static_cast<std::uint64_t>(block[0]) & last) |
           (static_cast<std::uint64_t>(block[1]) & last) << 21 |
           (static_cast<std::uint64_t>(block[2]) & last) << 42;
  }

  /// The table's place of the block, or the free one where it would be.
  std::size_t place(std::uint64_t key) const {
    std::size_t at = mix(key) & (table_.size() - 1);
    while (table_[at] != none && keys_[table_[at]] != key) at = (at + 1) & (table_.size() - 1);
    return at;
  }
  /// The block, made where there was none.
  std::size_t add_block(std::uint64_t key) {
    const std::size_t at = place(key);
    if (table_[at] != none) return table_[at];
    const std::size_t block = keys_.size();
    table_[at] = static_cast<Index>(block);
    keys_.push_back(key);
    if (2 * keys_.size() > table_.size()) {
      table_.assign(2 * table_.size(), none);
      for (std::size_t b = 0; b < keys_.size(); ++b)
        table_[place(keys_[b])] = static_cast<Index>(b);
    }
    return block;
  }

  double cells_a_metre_ = 0, largest_ = 0;
  Vec3 low_ = Vec3::Constant(infinity), high_ = Vec3::Constant(-infinity);  // of the centres
  std::vector<std::uint64_t> keys_;                                         // of blocks
  std::vector<Index> table_;                                                // blocks by their keys
  std::vector<Index> start_;  // of each block's cells, one after the other
  std::vector<Grown> spheres_;
};

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
    // A level for each half power of two in size.
    double smallest = infinity;
    for (Index b = 0; b < count; ++b) smallest = std::min(smallest, bodies.radius[b] + reach[b]);
    std::vector<std::vector<Grown>> of_size;
    std::vector<std::size_t> size(count);
    for (Index b = 0; b < count; ++b) {
      const Grown sphere{bodies.position[b], bodies.radius[b] + reach[b], b};
      size[b] = static_cast<std::size_t>(2 * std::log2(sphere.radius / smallest));
      if (size[b] >= of_size.size()) of_size.resize(size[b] + 1);
      of_size[size[b]].push_back(sphere);
    }
    std::vector<Level> levels;
    std::vector<std::size_t> level_of_size;
    for (auto& spheres : of_size) {
      level_of_size.push_back(levels.size());
      if (!spheres.empty()) levels.emplace_back(spheres);
      spheres = {};
    }
    std::vector<Index> met;
    for (Index a = 0; a < count; ++a) {
      const Vec3 center = bodies.position[a];
      const double grown = bodies.radius[a] + reach[a];
      const bool ghost = a >= bodies.owned;
      std::size_t meetings = 0;
      const std::size_t own = level_of_size[size[a]];
      for (std::size_t l = own; l < levels.size(); ++l) {
        const Index after = l == own ? a : -1;
        levels[l].for_each_near(center, grown, [&](std::span<const Grown> run) {
          // Without branches: half of them would be guessed wrong.
          if (met.size() < meetings + run.size()) met.resize(2 * (meetings + run.size()));
          for (const Grown& other : run) {
            const double limit = grown + other.radius;
            met[meetings] = other.row;
            meetings +=
                static_cast<std::size_t>(other.row > after) &
                static_cast<std::size_t>((other.center - center).squaredNorm() <= limit * limit);
          }
        });
      }
      for (std::size_t k = 0; k < meetings; ++k)
        if (!(ghost && met[k] >= bodies.owned)) add(a, met[k], -1);
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
  const auto is_kept = [&](Index p) {
    return !pairs.impulse[p].isZero(0) && !(once && pairs.i[p] >= bodies.owned);
  };
  std::size_t count = 0;
  for (Index p = 0; p < pairs.size(); ++p) count += is_kept(p);
  ContactMemory memory;
  memory.reserve(count);
  for (Index p = 0; p < pairs.size(); ++p)
    if (is_kept(p))
      memory.add(bodies.id[pairs.i[p]], partner_id(bodies, pairs, p), pairs.impulse[p]);
  return memory;
}

void recall(const Bodies& bodies, const ContactMemory& memory, Pairs& pairs) {
  // Entries lie with the owned body of the lower id: [start[b], start[b + 1]), by the other's id.
  const RowsOfIds rows(bodies);
  std::vector<Index> holder(memory.i.size()), start(bodies.owned + 2, 0);
  for (std::size_t m = 0; m < holder.size(); ++m) {
    holder[m] = rows.find(memory.i[m]);
    if (holder[m] < 0 && memory.j[m] >= 0) holder[m] = rows.find(memory.j[m]);
    if (holder[m] >= 0) ++start[holder[m] + 2];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  struct Entry {
    BodyId other;
    Index m;
  };
  std::vector<Entry> entries(start.back());
  for (std::size_t m = 0; m < holder.size(); ++m)
    if (holder[m] >= 0)
      entries[start[holder[m] + 1]++] = {
          bodies.id[holder[m]] == memory.i[m] ? memory.j[m] : memory.i[m], static_cast<Index>(m)};
  const auto before = [](const Entry& a, const Entry& b) {
    return a.other != b.other ? a.other < b.other : a.m < b.m;
  };
  for (Index b = 0; b < bodies.owned; ++b)
    std::sort(entries.begin() + start[b], entries.begin() + start[b + 1], before);

  for (Index p = 0; p < pairs.size(); ++p) {
    const bool lower = pairs.i[p] < bodies.owned;
    const Index b = lower ? pairs.i[p] : pairs.j[p];
    const BodyId other = lower ? partner_id(bodies, pairs, p) : bodies.id[pairs.i[p]];
    const auto end = entries.begin() + start[b + 1];
    const auto at = std::lower_bound(entries.begin() + start[b], end, Entry{other, 0}, before);
    if (at != end && at->other == other) pairs.impulse[p] = memory.impulse[at->m];
  }
}

}  // namespace spall
