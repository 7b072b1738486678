// Cells in which several ranks have bodies: made by blocks of ranks, of blocks of blocks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <map>
#include <unordered_map>
#include <utility>
#include <vector>

#include "base/rank_blocks.hpp"
#include "base/traffic.hpp"
#include "gravity/cell_measures.hpp"
#include "gravity/cell_rows.hpp"
#include "gravity/curve.hpp"

namespace spall {

/// A cell that is not inside of one that a single rank has all bodies of.
struct TopCell {
  std::uint64_t last_key;  ///< of its bodies
  RankBlock known_to;      ///< who knows its halves; a single rank knows all inside
  Index parent = Cell::none;
};

template <int P>
class TopCells {
 public:
  TopCells(EssentialTree<P>& tree, CellMeasures<P>& measures) : tree_(tree), measures_(measures) {}

  /// The parts of a block tell each other the largest cells on their parts of the curve; each rank
  /// of it makes those above. Returns other ranks' cells whose inside is not known. Collective.
  std::vector<Index> climb(const Comm& comm);

  /// The same for all ranks by one, which has the parts of all; adds what each would send.
  void climb_for_all(std::vector<Traffic>& sent) {
    climb_for_all({0, static_cast<int>(sent.size())}, sent);
  }
  /// What `climb` would return on `rank`.
  std::vector<Index> unknown_to(int rank) const;

  const TopCell& operator[](Index c) const { return cells_.at(c); }

  /// A cell by its first and last key, as other ranks call it: no two cells share both.
  Index find(RowReader& name);
  void append_name(Index c, std::vector<double>& row) const {
    append_key(tree_.octree.cells[c].key, row);
    append_key(cells_.at(c).last_key, row);
  }
  /// What else there is to know of a cell of other ranks.
  void append_top(Index c, std::vector<double>& row) const {
    const TopCell& top = cells_.at(c);
    append_key(top.last_key, row);
    row.insert(row.end(),
               {static_cast<double>(top.known_to.first), static_cast<double>(top.known_to.count)});
  }
  void read_top(RowReader& row, Index c) {
    TopCell& top = cells_[c];
    top.last_key = row.key();
    top.known_to.first = row.index();
    top.known_to.count = row.index();
  }

 private:
  /// The largest cells on the part of the curve of a block, along it.
  struct Segment {
    std::uint64_t begin, end;  // keys
    std::vector<Index> cells{};
  };

  Segment own_segment(const Octree::Part& part, int rank);
  Segment joined(const RankBlock& block, const std::vector<Segment>& parts);
  void join(const RankBlock& block, std::span<const Index> cells, Segment& all);
  Segment climb_for_all(const RankBlock& block, std::vector<Traffic>& sent);
  std::vector<double> pack(const Segment& segment) const;
  Segment unpack(const std::vector<double>& row);

  EssentialTree<P>& tree_;
  CellMeasures<P>& measures_;
  std::unordered_map<Index, TopCell> cells_;
  std::map<std::pair<std::uint64_t, std::uint64_t>, Index> by_name_;
  std::map<std::pair<int, int>, std::vector<Index>> of_block_;  // where one rank climbs for all
};

/// The ranks of the other parts of `block` that `rank`, of the part `own`, tells of its cells. Each
/// of them hears of one rank of each other part: its partner there.
inline std::vector<int> listeners(const RankBlock& block, const RankBlock& own, int rank) {
  std::vector<int> ranks;
  for (int k = 0; k < block.parts(); ++k)
    if (const RankBlock part = block.part(k); part.first != own.first)
      for (int to = 0; to < part.count; ++to)
        if (own.partner_of(to) == rank) ranks.push_back(part.first + to);
  return ranks;
}

template <int P>
TopCells<P>::Segment TopCells<P>::own_segment(const Octree::Part& part, int rank) {
  Segment segment{part.begin, part.end};
  for (const auto& [cell, last_key] : part.roots) {
    cells_[cell] = {last_key, {rank, 1}};
    segment.cells.push_back(cell);
  }
  return segment;
}

template <int P>
std::vector<Index> TopCells<P>::climb(const Comm& comm) {
  Segment segment = own_segment(tree_.octree.parts[0], comm.rank);
  const auto own_cells = static_cast<Index>(tree_.octree.cells.size());
  const std::vector<RankBlock> blocks = blocks_of(comm.rank, comm.size);
  for (int level = block_levels(comm.size); level-- > 0;) {
    const bool takes_part = level + 1 < std::ssize(blocks);
    ByRank<double> outgoing;
    if (takes_part) {
      const std::vector<double> row = pack(segment);
      for (int to : listeners(blocks[level], blocks[level + 1], comm.rank)) outgoing[to] = row;
    }
    const ByRank<double> incoming = comm.exchange(std::move(outgoing));
    if (!takes_part) continue;
    const RankBlock& own = blocks[level + 1];
    std::vector<Segment> parts;
    for (int k = 0; k < blocks[level].parts(); ++k) {
      const RankBlock part = blocks[level].part(k);
      parts.push_back(part.has(comm.rank)
                          ? std::move(segment)
                          : unpack(incoming.at(part.partner_of(comm.rank - own.first))));
    }
    segment = joined(blocks[level], parts);
  }
  tree_.octree.root = segment.cells[0];
  std::vector<Index> unknown;
  for (auto c = own_cells; c < std::ssize(tree_.octree.cells); ++c)
    if (!cells_.at(c).known_to.has(comm.rank)) unknown.push_back(c);
  return unknown;
}

template <int P>
TopCells<P>::Segment TopCells<P>::climb_for_all(const RankBlock& block,
                                                std::vector<Traffic>& sent) {
  Segment all;
  if (block.count == 1) {
    all = own_segment(tree_.octree.parts[block.first], block.first);
  } else {
    std::vector<Segment> parts;
    for (int k = 0; k < block.parts(); ++k) {
      const RankBlock part = block.part(k);
      parts.push_back(climb_for_all(part, sent));
      const auto bytes = static_cast<std::int64_t>(sizeof(double) * pack(parts.back()).size());
      for (int rank = part.first; rank < part.first + part.count; ++rank) {
        const auto messages = std::ssize(listeners(block, part, rank));
        sent[rank].messages += messages;
        sent[rank].bytes += messages * bytes;
      }
    }
    all = joined(block, parts);
  }
  of_block_[{block.first, block.count}] = all.cells;
  tree_.octree.root = all.cells.empty() ? 0 : all.cells[0];  // the last block is of all
  return all;
}

template <int P>
std::vector<Index> TopCells<P>::unknown_to(int rank) const {
  std::vector<Index> unknown;
  for (const RankBlock& block : blocks_of(rank, static_cast<int>(tree_.octree.parts.size())))
    for (int k = 0; k < block.parts() && block.count > 1; ++k)
      if (const RankBlock part = block.part(k); !part.has(rank)) {
        const std::vector<Index>& cells = of_block_.at({part.first, part.count});
        unknown.insert(unknown.end(), cells.begin(), cells.end());
      }
  return unknown;
}

template <int P>
Index TopCells<P>::find(RowReader& name) {
  if (by_name_.empty())
    for (const auto& [c, top] : cells_) by_name_[{tree_.octree.cells[c].key, top.last_key}] = c;
  const std::uint64_t first = name.key(), last = name.key();
  return by_name_.at({first, last});
}

template <int P>
std::vector<double> TopCells<P>::pack(const Segment& segment) const {
  std::vector<double> row;
  append_key(segment.begin, row);
  append_key(segment.end, row);
  row.push_back(static_cast<double>(segment.cells.size()));
  for (Index c : segment.cells) {
    const Outline& outline = measures_.outlines[c];
    append_cell(tree_, c, row);
    append_top(c, row);
    append(outline.box.low, row);
    append(outline.box.high, row);
    row.insert(row.end(),
               {outline.largest_leaf, outline.bodies, outline.spread[0], outline.spread[1]});
  }
  return row;
}

template <int P>
TopCells<P>::Segment TopCells<P>::unpack(const std::vector<double>& row) {
  RowReader reader(row.data());
  Segment segment;
  segment.begin = reader.key();
  segment.end = reader.key();
  segment.cells.resize(reader.index());
  for (Index& c : segment.cells) {
    c = read_cell(reader, tree_);
    read_top(reader, c);
    Outline& outline = measures_.outlines.emplace_back();
    outline.box.low = reader.vector();
    outline.box.high = reader.vector();
    for (double* value :
         {&outline.largest_leaf, &outline.bodies, &outline.spread[0], &outline.spread[1]})
      *value = reader.number();
  }
  return segment;
}

template <int P>
TopCells<P>::Segment TopCells<P>::joined(const RankBlock& block,
                                         const std::vector<Segment>& parts) {
  Segment all{parts.front().begin, parts.back().end};
  std::vector<Index> cells;
  for (const Segment& part : parts) cells.insert(cells.end(), part.cells.begin(), part.cells.end());
  if (!cells.empty()) join(block, cells, all);
  return all;
}

/// Adds the largest cells made of `cells` to `all`: those whose stretch of the curve is in its own.
/// In the rest of a longer one others may have bodies.
template <int P>
void TopCells<P>::join(const RankBlock& block, std::span<const Index> cells, Segment& all) {
  if (cells.size() == 1) return all.cells.push_back(cells[0]);
  const auto key_of = [&](Index c) { return tree_.octree.cells[c].key; };
  const Stretch stretch = stretch_of(key_of(cells.front()), cells_.at(cells.back()).last_key);
  const auto split = static_cast<std::size_t>(
      std::ranges::lower_bound(cells, stretch.middle(), {}, key_of) - cells.begin());
  join(block, cells.first(split), all);
  join(block, cells.subspan(split), all);
  if (stretch.low < all.begin || stretch.high > all.end) return;
  const auto whole = static_cast<Index>(tree_.octree.cells.size());
  const std::array halves{all.cells[all.cells.size() - 2], all.cells.back()};
  tree_.octree.cells.emplace_back().children = halves;
  tree_.moments.emplace_back();
  measures_.outlines.emplace_back();
  measures_.measure_inner(whole);
  cells_[whole] = {cells_.at(halves[1]).last_key, block};
  for (Index half : halves) cells_.at(half).parent = whole;
  all.cells.pop_back();
  all.cells.back() = whole;
}

}  // namespace spall
