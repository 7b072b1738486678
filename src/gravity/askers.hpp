// What a rank tells of its own cells to those whose cells they may have to open.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <set>
#include <vector>

#include "gravity/top_cells.hpp"

namespace spall {

/// A cell of the rank that asks; what it has is inside of `box`.
struct Asker {
  Cell cell;  ///< its children are places in a list of these
  Box box;
  double largest_leaf = 0;  ///< radius
};
/// The first is the tree's root; of the others, those that the rank has bodies in.
using Askers = std::vector<Asker>;

/// Calls `f(half)` for each child there is.
void for_each_half(const Cell& cell, auto&& f) {
  for (Index half : cell.children)
    if (half != Cell::none) f(half);
}

/// Those that have bodies in `own`, the largest cells of one rank: what is above, and enough
/// generations below for about `parts` equal numbers of bodies.
template <int P>
Askers askers_of(const EssentialTree<P>& tree, const CellMeasures<P>& measures,
                 const TopCells<P>& tops, const std::vector<Octree::Part::Root>& own) {
  constexpr double parts = 64;  // fewer would ask for much that is not needed
  Askers askers;
  if (own.empty()) return askers;
  std::set<Index> roots, above;
  double bodies = 0;
  for (const auto& root : own) {
    roots.insert(root.cell);
    bodies += measures.outlines[root.cell].bodies;
    Index c = tops[root.cell].parent;
    while (c != Cell::none && above.insert(c).second) c = tops[c].parent;
  }
  const auto add = [&](auto&& self, Index c, bool is_own) -> Index {
    is_own = is_own || roots.contains(c);
    const auto place = static_cast<Index>(askers.size());
    const Cell& cell = tree.octree.cells[c];
    const Outline& outline = measures.outlines[c];
    askers.push_back({cell, outline.box, outline.largest_leaf});
    askers[place].cell.children = {Cell::none, Cell::none};
    if (is_own && parts * outline.bodies <= bodies) return place;
    int halves = 0;
    for_each_half(cell, [&](Index half) {
      if (!is_own && !roots.contains(half) && !above.contains(half)) return;
      const Index added = self(self, half, is_own);
      askers[place].cell.children[halves++] = added;
    });
    return place;
  };
  add(add, tree.octree.root, false);
  return askers;
}

/// Whether the asker itself, as a whole, opens a cell.
template <int P>
bool opens_itself(const EssentialTree<P>& tree, const Asker& asker, const Cell& cell) {
  return !is_larger(asker.cell, cell) && !tree.are_far(measure_pair(asker.cell, cell));
}

/// Whether some cell inside of `askers[by]` may have to open `cell`. Only cells that are not larger
/// than `cell`, and leaves, open it.
template <int P>
bool is_opened(const EssentialTree<P>& tree, const Cell& cell, const Askers& askers, Index by = 0) {
  const Asker& asker = askers[by];
  constexpr double slack = 1 - 1e-12;  // for round-off
  const double largest = std::max(cell.radius, asker.largest_leaf);
  if (tree.are_far({cell.radius + largest, cell.extent + largest,
                    slack * asker.box.squared_distance(cell.center),
                    cell.mass / asker.cell.pull + asker.cell.mass / cell.pull}))
    return false;
  return !asker.cell.inner() || opens_itself(tree, asker, cell) ||
         std::ranges::any_of(asker.cell.children, [&](Index half) {
           return half != Cell::none && is_opened(tree, cell, askers, half);
         });
}

/// Seen from all of a cell an asker is so small that its halves need not be told apart.
inline bool is_small_from(const Cell& cell, const Asker& asker) {
  constexpr double resolved = 1;  // of the distance between them
  const double apart = std::sqrt(asker.box.squared_distance(cell.center)) - cell.radius;
  const double size = (asker.box.high - asker.box.low).norm();
  return size < resolved * apart;
}

/// Of `all` those that may open one of `cells`, and what is inside of one that does.
template <int P>
Askers askers_for(const EssentialTree<P>& tree, std::span<const Index> cells, const Askers& all) {
  Askers some;
  const auto add = [&](auto&& self, Index from, bool whole) -> Index {
    const auto place = static_cast<Index>(some.size());
    const Asker& asker = all[from];
    const auto any = [&](auto&& test) {
      return std::ranges::any_of(cells, [&](Index c) { return test(tree.octree.cells[c]); });
    };
    some.push_back(asker);
    some[place].cell.children = {Cell::none, Cell::none};
    whole = whole || any([&](const Cell& cell) { return opens_itself(tree, asker, cell); });
    const auto is_small = [&](Index c) { return is_small_from(tree.octree.cells[c], asker); };
    if (std::ranges::all_of(cells, is_small)) return place;
    int halves = 0;
    for_each_half(asker.cell, [&](Index half) {
      if (!whole && !any([&](const Cell& cell) { return is_opened(tree, cell, all, half); }))
        return;
      const Index added = self(self, half, whole);
      some[place].cell.children[halves++] = added;
    });
    return place;
  };
  add(add, 0, false);
  return some;
}

inline void append_askers(const Askers& askers, std::vector<double>& row) {
  for (const auto& [cell, box, largest_leaf] : askers) {
    for (const Vec3& x : {cell.center, box.low, box.high}) append(x, row);
    append_measure(cell, row);
    int halves = 0;
    for_each_half(cell, [&](Index) { ++halves; });
    row.insert(row.end(), {cell.mass, largest_leaf, static_cast<double>(halves)});
  }
}

inline Askers read_askers(RowReader& row) {
  Askers askers;
  const auto read = [&](auto&& self) -> Index {
    const auto place = static_cast<Index>(askers.size());
    Asker& asker = askers.emplace_back();
    for (Vec3* x : {&asker.cell.center, &asker.box.low, &asker.box.high}) *x = row.vector();
    read_measure(row, asker.cell);
    asker.cell.mass = row.number();
    asker.largest_leaf = row.number();
    const Index halves = row.index();
    for (Index k = 0; k < halves; ++k) {
      const Index half = self(self);
      askers[place].cell.children[k] = half;
    }
    return place;
  };
  read(read);
  return askers;
}

}  // namespace spall
