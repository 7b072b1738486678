// A cell's surroundings are copied once and compared with each of its bodies, eight candidates at a
// time. A body looks for partners on its own level and on coarser ones, where it meets few cells.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/grid.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numeric>

#include "base/hash.hpp"
#include "base/kernels.hpp"
#include "base/morton.hpp"
#include "base/sort_by_key.hpp"
#include "spall/lanes.hpp"

namespace spall {
namespace {

constexpr Index lane_rows = lane_count;
/// Cells around a body are visited in blocks of 4 x 4 x 4 where pairs are listed with lower rows.
constexpr int block_bits = 2;

struct Box {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
};

struct Cell {
  std::uint64_t key;
  Index first, ghosts, end;  // places in the level's rows: owned bodies, then ghosts
};

/// Bodies of one size in cells about as wide as they are when grown.
class Level {
 public:
  /// `rows` ascend.
  Level(const Bodies& bodies, const Reach& reach, std::vector<Index> rows, const Vec3& anchor)
      : anchor_(anchor) {
    double edge = 0;
    for (Index b : rows) {
      const double grown = reach.grown(bodies, b);
      edge += 2 * grown / static_cast<double>(rows.size());
      largest_ = std::max(largest_, grown);
      centres_.add(bodies.position[b]);
    }
    cells_a_metre_ = 1 / edge;
    std::vector<KeyedRow> order;
    order.reserve(rows.size());
    for (Index b : rows) {
      const auto c = cell(bodies.position[b]);
      order.push_back({interleave(c[0], c[1], c[2]), b});
    }
    sort_by_key(order);
    for (Index k = 0; k < std::ssize(order); ++k) {
      const auto [key, b] = order[k];
      if (cells_.empty() || cells_.back().key != key) cells_.push_back({key, k, k, k});
      cells_.back().end = k + 1;
      if (b < bodies.owned) cells_.back().ghosts = k + 1;
      rows[k] = b;
    }
    row_ = std::move(rows);
    std::size_t slots = 64;
    while (slots < 2 * cells_.size()) slots *= 2;
    slot_.assign(slots, {0, -1});
    for (std::size_t c = 0; c < cells_.size(); ++c) {
      std::size_t at = home(cells_[c].key);
      while (slot_[at].cell >= 0) at = (at + 1) & (slots - 1);
      slot_[at] = {cells_[c].key, static_cast<Index>(c)};
    }
  }

  const std::vector<Cell>& cells() const { return cells_; }
  Index row(Index place) const { return row_[place]; }

  /// Calls `f(cell)` for the cells in which a body of this level may be that meets one with its
  /// centre in `box` and of radius `grown` (m): block by block, z slowest.
  template <class F>
  void for_each_near(const Box& box, double grown, int bits, F&& f) const {
    const Vec3 reach = Vec3::Constant(grown + largest_);
    if ((box.high + reach - centres_.low).minCoeff() < 0 ||
        (centres_.high - box.low + reach).minCoeff() < 0)
      return;
    const auto low = cell(box.low - reach), high = cell(box.high + reach);
    std::array<std::uint64_t, 3> block, from, to;
    const auto for_each_block = [&](int k, auto&& inner) {
      for (block[k] = low[k] >> bits; block[k] <= high[k] >> bits; ++block[k]) {
        from[k] = std::max(low[k], block[k] << bits);
        to[k] = std::min(high[k], ((block[k] + 1) << bits) - 1);
        inner();
      }
    };
    for_each_block(2, [&] {
      for_each_block(1, [&] {
        for_each_block(0, [&] {
          for (std::uint64_t z = from[2]; z <= to[2]; ++z)
            for (std::uint64_t y = from[1]; y <= to[1]; ++y) {
              const std::uint64_t line = interleave(0, y, z);
              for (std::uint64_t x = from[0]; x <= to[0]; ++x)
                if (const Cell* near = find(line | spread_bits(x))) f(*near);
            }
        });
      });
    });
  }

 private:
  /// Positions beyond 2^20 cells share the outermost ones.
  std::array<std::uint64_t, 3> cell(const Vec3& x) const {
    constexpr double half = 1 << 20;
    const auto place = [&](int k) {
      const double at = std::floor((x[k] - anchor_[k]) * cells_a_metre_) + half;
      return static_cast<std::uint64_t>(std::max(0.0, std::min(at, 2 * half - 1)));
    };
    return {place(0), place(1), place(2)};
  }

  const Cell* find(std::uint64_t key) const {
    for (std::size_t at = home(key);; at = (at + 1) & (slot_.size() - 1)) {
      if (slot_[at].cell < 0) return nullptr;
      if (slot_[at].key == key) return &cells_[slot_[at].cell];
    }
  }
  /// Eight cells that form a cube stand together, as neighbours are asked for.
  std::size_t home(std::uint64_t key) const {
    return (mix(key >> 3) << 3 | (key & 7)) & (slot_.size() - 1);
  }

  struct Slot {
    std::uint64_t key;
    Index cell;
  };
  Vec3 anchor_;  // m, corner of a cell
  double cells_a_metre_ = 0, largest_ = 0;
  Box centres_;
  std::vector<Index> row_;
  std::vector<Cell> cells_;
  std::vector<Slot> slot_;
};

/// Bodies that may be near those of a cell, coordinate by coordinate.
struct Candidates {
  std::vector<double> x{std::vector<double>(lane_rows)}, y{x}, z{x}, grown{x};
  std::vector<Index> row{std::vector<Index>(lane_rows)};
  Index count = 0;
  bool equal;  ///< all bodies are of one size: `grown` is not needed

  void add(const Bodies& bodies, const Reach& reach, const Level& level, Index first, Index end) {
    if (count + (end - first) + lane_rows > static_cast<Index>(row.size())) {
      const std::size_t size = 2 * (count + (end - first)) + 8 * lane_rows;
      for (auto* v : {&x, &y, &z, &grown}) v->resize(size);
      row.resize(size);
    }
    double *const to_x = &x[count], *const to_y = &y[count], *const to_z = &z[count];
    for (Index k = first; k < end; ++k) {
      const Index b = level.row(k);
      const Vec3& position = bodies.position[b];
      to_x[k - first] = position[0];
      to_y[k - first] = position[1];
      to_z[k - first] = position[2];
      if (!equal) grown[count + k - first] = reach.grown(bodies, b);
      row[count + k - first] = b;
    }
    count += end - first;
  }
  /// Lanes beyond the last candidate are near nobody.
  void close() { std::fill_n(x.begin() + count, lane_rows, infinity); }
};

/// The candidates from `first` on whose spheres meet that of radius `grown` (m): those that still
/// meet it if they are nearer by `skin` (m) are appended to `found`, the others to `further`.
template <bool equal>
void append_near(const Candidates& all, Index first, const Vec3& center, double grown, double skin,
                 std::vector<Index>& found, std::vector<Index>& further) {
  const Lanes x = spread(center[0]), y = spread(center[1]), z = spread(center[2]);
  const double range = 2 * grown, reach = range - skin;
  Lanes limit = spread(range * range), inner = spread(reach * reach);
  std::size_t count = found.size(), more = further.size();
  found.resize(count + all.count - first + lane_rows);
  further.resize(more + all.count - first + lane_rows);
  for (Index k = first; k < all.count; k += lane_rows) {
    const Lanes dx = load(&all.x[k]) - x, dy = load(&all.y[k]) - y, dz = load(&all.z[k]) - z;
    const Lanes r2 = dx * dx + dy * dy + dz * dz;
    if constexpr (!equal) {
      const Lanes touch = load(&all.grown[k]) + grown, nearer = touch - skin;
      limit = touch * touch;
      inner = nearer * nearer;
    }
    const unsigned within = bits_of_mask(r2 < limit), near = within & bits_of_mask(r2 < inner);
    const IndexLanes rows = load(&all.row[k]);
    count += store_packed(rows, near, &found[count]);
    more += store_packed(rows, within & ~near, &further[more]);
  }
  found.resize(count);
  further.resize(more);
}

/// m: the sizes of all bodies when grown.
struct Sizes {
  double smallest = infinity, largest = 0;
  Sizes(const Bodies& bodies, const Reach& reach) {
    for (Index b = 0; b < bodies.size(); ++b) {
      const double grown = reach.grown(bodies, b);
      smallest = std::min(smallest, grown);
      largest = std::max(largest, grown);
    }
  }
  /// Half powers of two above the smallest.
  std::uint8_t class_of(double grown) const {
    return static_cast<std::uint8_t>(2 * std::log2(grown / smallest));
  }
};

/// Of each row; empty: all are of one.
std::vector<std::uint8_t> size_classes(const Bodies& bodies, const Reach& reach,
                                       const Sizes& sizes) {
  std::vector<std::uint8_t> classes;
  if (sizes.class_of(sizes.largest) == 0) return classes;
  classes.resize(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b) classes[b] = sizes.class_of(reach.grown(bodies, b));
  return classes;
}

std::vector<Level> levels_of(const Bodies& bodies, const Reach& reach, const Vec3& anchor,
                             const std::vector<std::uint8_t>& classes) {
  std::vector<std::vector<Index>> rows(1);
  if (classes.empty()) {
    rows[0].resize(bodies.size());
    std::iota(rows[0].begin(), rows[0].end(), 0);
  }
  for (Index b = 0; b < std::ssize(classes); ++b) {
    if (classes[b] >= rows.size()) rows.resize(classes[b] + 1);
    rows[classes[b]].push_back(b);
  }
  std::vector<Level> levels;
  for (auto& of_class : rows)
    if (!of_class.empty()) levels.emplace_back(bodies, reach, std::move(of_class), anchor);
  return levels;
}

struct Met {
  Index row, ghost;
};

/// Ghosts that meet larger owned bodies, by the row of these.
std::vector<Met> smaller_ghosts(const Bodies& bodies, const Reach& reach,
                                const std::vector<Level>& levels) {
  std::vector<Met> met;
  Candidates candidates{.equal = false};
  std::vector<Index> found, none;
  for (std::size_t l = 0; l + 1 < levels.size(); ++l)
    for (const Cell& cell : levels[l].cells())
      for (Index k = cell.ghosts; k < cell.end; ++k) {
        const Index ghost = levels[l].row(k);
        const double grown = reach.grown(bodies, ghost);
        const Box box{bodies.position[ghost], bodies.position[ghost]};
        candidates.count = 0;
        for (std::size_t m = l + 1; m < levels.size(); ++m)
          levels[m].for_each_near(box, grown, block_bits, [&](const Cell& near) {
            candidates.add(bodies, reach, levels[m], near.first, near.ghosts);
          });
        candidates.close();
        found.clear();
        append_near<false>(candidates, 0, bodies.position[ghost], grown, 0, found, none);
        for (Index row : found) met.push_back({row, ghost});
      }
  std::stable_sort(met.begin(), met.end(),
                   [](const Met& a, const Met& b) { return a.row < b.row; });
  return met;
}

/// `equal`: all bodies are of one size.
template <bool equal>
void find_of(const Bodies& bodies, const Reach& reach, const Sizes& sizes, ListedWith listed,
             std::vector<Index>& partners, const EndRow& end_row) {
  const bool by_cell = listed == ListedWith::first_cell;
  const int bits = by_cell ? 32 : block_bits;
  Vec3 anchor = Vec3::Zero();
  if (by_cell) {
    Box all;
    for (const Vec3& x : bodies.position) all.add(x);
    anchor = all.low;
  }
  const std::vector<std::uint8_t> classes = size_classes(bodies, reach, sizes);
  const std::vector<Level> levels = levels_of(bodies, reach, anchor, classes);
  const std::vector<Met> ghosts = smaller_ghosts(bodies, reach, levels);

  Candidates candidates{.equal = equal};
  std::vector<Index> further;
  for (std::size_t l = 0; l < levels.size(); ++l)
    for (const Cell& cell : levels[l].cells()) {
      if (cell.first == cell.ghosts) continue;
      Box box;
      double largest = 0;
      for (Index k = cell.first; k < cell.ghosts; ++k) {
        box.add(bodies.position[levels[l].row(k)]);
        largest = std::max(largest, reach.grown(bodies, levels[l].row(k)));
      }
      candidates.count = 0;
      if (by_cell) candidates.add(bodies, reach, levels[l], cell.first, cell.end);
      for (std::size_t m = l; m < levels.size(); ++m)
        levels[m].for_each_near(box, largest, bits, [&](const Cell& near) {
          Index first = near.first;
          if (by_cell && m == l) {
            if (near.key == cell.key) return;
            if (near.key < cell.key) first = near.ghosts;
          }
          candidates.add(bodies, reach, levels[m], first, near.end);
        });
      candidates.close();
      for (Index k = cell.first; k < cell.ghosts; ++k) {
        const Index row = levels[l].row(k);
        const auto begin = static_cast<std::ptrdiff_t>(partners.size());
        further.clear();
        append_near<equal>(candidates, by_cell ? k - cell.first + 1 : 0, bodies.position[row],
                           reach.grown(bodies, row), reach.skin, partners, further);
        const Index near = static_cast<Index>(std::ssize(partners) - begin);
        partners.insert(partners.end(), further.begin(), further.end());
        if (!by_cell)
          partners.erase(std::remove_if(partners.begin() + begin, partners.end(),
                                        [&](Index other) {
                                          return other <= row && (classes.empty() ||
                                                                  classes[other] == classes[row]);
                                        }),
                         partners.end());
        for (auto met = std::lower_bound(ghosts.begin(), ghosts.end(), row,
                                         [](const Met&m, Index r) { return m.row < r; });
             met != ghosts.end() && met->row == row; ++met)
          partners.push_back(met->ghost);
        end_row(row, near);
      }
    }
}

}  // namespace

SPALL_KERNEL(void, find_partners,
             (const Bodies& bodies, const Reach& reach, ListedWith listed,
              std::vector<Index>& partners, const EndRow& end_row),
             (bodies, reach, listed, partners, end_row)) {
  if (bodies.size() == 0) return;
  const Sizes sizes(bodies, reach);
  const auto find = sizes.smallest == sizes.largest ? find_of<true> : find_of<false>;
  find(bodies, reach, sizes, listed, partners, end_row);
}

}  // namespace spall
