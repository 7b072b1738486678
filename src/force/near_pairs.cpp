// Cells as wide as the range, in the order of a space-filling curve; a cell's surroundings are
// copied once and compared with each of its bodies, eight candidates at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/near_pairs.hpp"

#include <algorithm>
#include <array>
#include <numeric>

#include "spall/base/require.hpp"
#include "spall/domain/halo.hpp"
#include "spall/domain/migration.hpp"
#include "spall/domain/morton.hpp"
#include "spall/force/lanes.hpp"

namespace spall {
namespace {

constexpr Index lane_rows = lane_count;
constexpr Index window_rows = 16 * lane_rows;  // their forces stay in the first cache

/// Bodies in the order of their cells' keys, owned ones first in each cell.
struct Order {
  std::vector<std::uint64_t> key;
  std::vector<Index> row;
};

/// Least significant digits first, only those in which keys differ.
Order sort_by_key(Order order, std::uint64_t largest) {
  constexpr int digit = 11;
  const std::size_t n = order.key.size();
  Order sorted{std::vector<std::uint64_t>(n), std::vector<Index>(n)};
  for (int shift = 0; shift < 64 && largest >> shift != 0; shift += digit) {
    std::array<std::size_t, (1 << digit) + 1> start{};
    const auto value = [&](std::uint64_t key) { return key >> shift & ((1 << digit) - 1); };
    for (std::uint64_t key : order.key) ++start[value(key) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t at = start[value(order.key[k])]++;
      sorted.key[at] = order.key[k];
      sorted.row[at] = order.row[k];
    }
    std::swap(order, sorted);
  }
  return order;
}

struct Grid {
  Vec3 low = Vec3::Constant(infinity);
  double edge;

  /// Positions beyond 2^21 cells share the outermost one.
  std::array<std::uint64_t, 3> cell(const Vec3& x) const {
    constexpr double last = (1 << 21) - 1;
    const auto place = [&](int k) {
      return static_cast<std::uint64_t>(std::max(0.0, std::min((x[k] - low[k]) / edge, last)));
    };
    return {place(0), place(1), place(2)};
  }
};

inline std::uint64_t key_of(const std::array<std::uint64_t, 3>& cell) {
  return spread_bits(cell[0]) | spread_bits(cell[1]) << 1 | spread_bits(cell[2]) << 2;
}

struct Cell {
  std::uint64_t key;
  Index first, ghosts, end;  // places in the order: owned bodies, then ghosts
};

/// Cells by key. Eight cells that form a cube stand together, as neighbours are asked for.
class CellTable {
 public:
  explicit CellTable(const std::vector<Cell>& cells) : cells_(cells) {
    std::size_t slots = 64;
    while (slots < 2 * cells.size()) slots *= 2;
    slot_.assign(slots, {0, -1});
    for (std::size_t c = 0; c < cells.size(); ++c) {
      std::size_t at = home(cells[c].key);
      while (slot_[at].cell >= 0) at = (at + 1) & (slot_.size() - 1);
      slot_[at] = {cells[c].key, static_cast<Index>(c)};
    }
  }
  const Cell* find(std::uint64_t key) const {
    for (std::size_t at = home(key);; at = (at + 1) & (slot_.size() - 1)) {
      if (slot_[at].cell < 0) return nullptr;
      if (slot_[at].key == key) return &cells_[slot_[at].cell];
    }
  }

 private:
  struct Slot {
    std::uint64_t key;
    Index cell;
  };
  std::size_t home(std::uint64_t key) const {
    std::uint64_t x = (key >> 3) * 0x9e3779b97f4a7c15;
    x ^= x >> 32;
    return (x << 3 | (key & 7)) & (slot_.size() - 1);
  }
  const std::vector<Cell>& cells_;
  std::vector<Slot> slot_;
};

/// Candidates for the bodies of a cell, coordinate by coordinate.
struct Candidates {
  std::vector<double> x, y, z;
  std::vector<Index> row;
  Index count = 0;

  void add(const Bodies& bodies, const Order& order, Index first, Index end) {
    if (count + (end - first) + lane_rows > static_cast<Index>(row.size())) {
      const std::size_t size = 2 * (count + (end - first)) + 8 * lane_rows;
      for (auto* v : {&x, &y, &z}) v->resize(size);
      row.resize(size);
    }
    for (Index k = first; k < end; ++k) {
      const Index b = order.row[k];
      const Vec3& position = bodies.position[b];
      x[count] = position[0];
      y[count] = position[1];
      z[count] = position[2];
      row[count++] = b;
    }
  }
  /// Lanes beyond the last candidate are near nobody.
  void close() { std::fill_n(x.begin() + count, lane_rows, infinity); }
};

/// The candidates from `first` on that are nearer than `range`: those nearer than `reach` are
/// appended to `found`, the others to `further`.
void append_near(const Candidates& all, Index first, const Vec3& center, double reach, double range,
                 std::vector<Index>& found, std::vector<Index>& further) {
  const Lanes x = spread(center[0]), y = spread(center[1]), z = spread(center[2]);
  const Lanes inner = spread(reach * reach), limit = spread(range * range);
  std::size_t count = found.size(), more = further.size();
  found.resize(count + all.count - first + lane_rows);
  further.resize(more + all.count - first + lane_rows);
  const auto load = [](const std::vector<double>& from, Index at) {
    Lanes v;
    __builtin_memcpy(&v, &from[at], sizeof v);
    return v;
  };
  for (Index k = first; k < all.count; k += lane_rows) {
    const Lanes dx = load(all.x, k) - x, dy = load(all.y, k) - y, dz = load(all.z, k) - z;
    const Lanes r2 = dx * dx + dy * dy + dz * dz;
#ifdef __AVX512VL__
    const __mmask8 within = _mm512_cmp_pd_mask(r2, limit, _CMP_LT_OQ);
    const __mmask8 near = _mm512_mask_cmp_pd_mask(within, r2, inner, _CMP_LT_OQ);
    const __mmask8 beyond = within & ~near;
    const __m256i rows = _mm256_loadu_si256(reinterpret_cast<const __m256i*>(&all.row[k]));
    const auto store = [&](std::vector<Index>& to, std::size_t at, __mmask8 chosen) {
      _mm256_storeu_si256(reinterpret_cast<__m256i*>(&to[at]),
                          _mm256_maskz_compress_epi32(chosen, rows));
      return at + static_cast<unsigned>(__builtin_popcount(chosen));
    };
    count = store(found, count, near);
    more = store(further, more, beyond);
#else
    for (Index l = 0; l < lane_rows; ++l) {
      found[count] = further[more] = all.row[k + l];
      count += r2[l] < inner[l] && r2[l] < limit[l];
      more += r2[l] >= inner[l] && r2[l] < limit[l];
    }
#endif
  }
  found.resize(count);
  further.resize(more);
}

/// Rows as they are found, until there are enough for a window.
class WindowMaker {
 public:
  explicit WindowMaker(std::vector<NearWindow>& windows) : windows_(windows) {}

  std::vector<Index>& partners() { return partners_; }
  /// All partners since the last call belong to `row`.
  void end_row(Index row) {
    rows_.push_back({row, first_, static_cast<Index>(partners_.size()) - first_});
    first_ = static_cast<Index>(partners_.size());
    if (rows_.size() == window_rows) flush();
  }
  void finish() {
    if (!rows_.empty()) flush();
    windows_.resize(made_);
  }

 private:
  struct Row {
    Index row, first, count;
  };

  void flush() {
    if (made_ == windows_.size()) windows_.emplace_back();
    NearWindow& window = windows_[made_++];
    sort_by_count();
    window.count = static_cast<Index>(rows_.size());
    while (rows_.size() % lane_rows != 0) rows_.push_back({rows_.back().row, 0, 0});
    window.rows.clear();
    for (const Row& row : rows_) window.rows.push_back(doubles_a_row * row.row);
    window.slots.clear();
    Index slots = 0;
    for (std::size_t r = 0; r < rows_.size(); r += lane_rows) {
      window.slots.push_back(rows_[r].count);
      slots += rows_[r].count;
    }
    window.partners.clear();  // or it would grow to twice what it needs
    window.partners.resize(static_cast<std::size_t>(slots) * lane_rows);
    Index* at = window.partners.data();
    for (std::size_t r = 0; r < rows_.size(); r += lane_rows) {
      const Index longest = rows_[r].count;
      for (Index lane = 0; lane < lane_rows; ++lane) {
        const Row& row = rows_[r + lane];
        for (Index s = 0; s < longest; ++s)
          at[s * lane_rows + lane] =
              doubles_a_row * (s < row.count ? partners_[row.first + s] : row.row);
      }
      at += longest * lane_rows;
    }
    rows_.clear();
    partners_.clear();
    first_ = 0;
  }

  /// Most partners first.
  void sort_by_count() {
    start_.clear();
    for (const Row& row : rows_) {
      if (row.count >= static_cast<Index>(start_.size())) start_.resize(row.count + 1, 0);
      ++start_[row.count];
    }
    std::exclusive_scan(start_.rbegin(), start_.rend(), start_.rbegin(), 0);
    sorted_.resize(rows_.size());
    for (const Row& row : rows_) sorted_[start_[row.count]++] = row;
    rows_.swap(sorted_);
  }

  std::vector<NearWindow>& windows_;
  std::size_t made_ = 0;
  std::vector<Row> rows_, sorted_;
  std::vector<Index> start_;
  std::vector<Index> partners_;
  Index first_ = 0;
};

}  // namespace

void find_near_pairs(const Bodies& bodies, double reach, double range, const Giants& giants,
                     std::vector<NearWindow>& windows) {
  Grid grid{.edge = range};
  for (const Vec3& x : bodies.position) grid.low = grid.low.cwiseMin(x);
  Order order;
  order.key.reserve(bodies.size());
  order.row.reserve(bodies.size());
  std::vector<Index> giant;
  std::uint64_t largest = 0;
  for (Index b = 0; b < bodies.size(); ++b) {
    if (bodies.radius[b] > giants.above) {
      giant.push_back(b);
      continue;
    }
    order.key.push_back(key_of(grid.cell(bodies.position[b])));
    order.row.push_back(b);
    largest = std::max(largest, order.key.back());
  }
  const auto meets_giant = [&](Index g, Index b) {
    const double touch = bodies.radius[g] + bodies.radius[b] + giants.slack;
    return (bodies.position[g] - bodies.position[b]).squaredNorm() < touch * touch;
  };
  order = sort_by_key(std::move(order), largest);

  std::vector<Cell> cells;
  for (Index k = 0; k < static_cast<Index>(order.row.size()); ++k) {
    if (cells.empty() || cells.back().key != order.key[k]) cells.push_back({order.key[k], k, k, k});
    cells.back().end = k + 1;
    if (order.row[k] < bodies.owned) cells.back().ghosts = k + 1;
  }
  order.key = std::vector<std::uint64_t>();  // gives the memory back
  const CellTable table(cells);

  Candidates candidates;
  std::vector<Index> further;
  WindowMaker maker(windows);
  for (const Cell& cell : cells) {
    if (cell.first == cell.ghosts) continue;
    candidates.count = 0;
    candidates.add(bodies, order, cell.first, cell.end);
    for (std::uint64_t key : keys_around(cell.key)) {
      if (key == cell.key) continue;
      if (const Cell* near = table.find(key))
        candidates.add(bodies, order, key > cell.key ? near->first : near->ghosts, near->end);
    }
    candidates.close();
    for (Index k = cell.first; k < cell.ghosts; ++k) {
      const Index row = order.row[k];
      further.clear();
      append_near(candidates, k - cell.first + 1, bodies.position[row], reach, range,
                  maker.partners(), further);
      maker.partners().insert(maker.partners().end(), further.begin(), further.end());
      for (Index g : giant)
        if (meets_giant(g, row)) maker.partners().push_back(g);
      maker.end_row(row);
    }
  }
  // Giants come last, as partners of all others: theirs are giants after them, and ghosts.
  for (std::size_t k = 0; k < giant.size() && giant[k] < bodies.owned; ++k) {
    for (std::size_t other = k + 1; other < giant.size(); ++other)
      if (meets_giant(giant[k], giant[other])) maker.partners().push_back(giant[other]);
    for (Index b = bodies.owned; b < bodies.size(); ++b)
      if (bodies.radius[b] <= giants.above && meets_giant(giant[k], b))
        maker.partners().push_back(b);
    maker.end_row(giant[k]);
  }
  maker.finish();
}

namespace {
constexpr double slot_work = 0.1;  // of a pair, beside that of a body
}

std::vector<double> work_of(const Bodies& bodies, const NearPairs& near, double slot) {
  std::vector<double> work(bodies.owned, 1.0);
  if (near.skin == 0) return work;
  for (const NearWindow& window : near.windows)
    for (Index r = 0; r < window.count; ++r)
      work[window.rows[r] / doubles_a_row] += slot * window.slots[r / lane_rows];
  return work;
}

void book_search(const Comm& comm, const Bodies& bodies, bool cut, double slot, NearPairs& near) {
  near.moved = 0;
  near.steps = 0;
  double pairs = 0;
  for (const NearWindow& window : near.windows)
    pairs += static_cast<double>(window.partners.size());
  near.pairs = comm.sum(pairs);
  ++near.searches;
  const auto work = cut ? work_of(bodies, near, slot) : std::vector<double>();
  book_search(comm, cut, work, near.ghosts, near.last_cut);
}

void search_near_pairs(const Comm& comm, Bodies& bodies, double reach, double skin, double bonded,
                       NearPairs& near) {
  const bool bonds_break = bonded > 0;
  require(!bonds_break || bodies.has.bonds,
          "bonds that break need fields that the bodies were made without");
  auto work = work_of(bodies, near, slot_work);
  const bool cut = needs_cut(comm, work, near.ghosts, near.last_cut);
  std::optional<Bonds> bonds;
  if (bonds_break) bonds = bonds_of(bodies, near);
  near.found_at = std::vector<Vec3>();  // what comes needs the memory
  if (cut) {
    const std::vector<int> owner = partition(comm, bodies, work);
    SentBonds sent;
    if (bonds) sent = send_bonds(comm, bodies, *bonds, owner);
    ContactMemory none;
    migrate(comm, bodies, none, owner);
    if (bonds) bonds = arrange_bonds(bodies, sent);
  }
  work = std::vector<double>();
  near.bonds = {};
  near.bonds_break = bonds_break;
  near.reach = reach;
  near.skin = skin;
  {
    std::vector<double> halo(bodies.owned);
    for (Index b = 0; b < bodies.owned; ++b) halo[b] = (reach + skin) / 2 - bodies.radius[b];
    near.ghosts = make_halo(comm, bodies, halo);
  }
  near.found_at.assign(bodies.position.begin(), bodies.position.begin() + bodies.owned);
  near.cells = MotionCells(comm, near.found_at, motion_cell * (reach + skin));
  find_near_pairs(bodies, reach, reach + skin, {}, near.windows);
  if (bonds)
    recall_bonds(bodies, *bonds, near);
  else if (bonds_break)
    make_bonds(bodies, near, bonded);
  book_search(comm, bodies, cut, slot_work, near);
}

}  // namespace spall
