// Cells as they travel between ranks: numbers in a row.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <vector>

#include "gravity/essential_tree.hpp"

namespace spall {

inline void append(const Vec3& x, std::vector<double>& row) {
  row.insert(row.end(), x.begin(), x.end());
}
inline void append_key(std::uint64_t key, std::vector<double>& row) {
  row.push_back(std::bit_cast<double>(key));
}

/// Takes what was appended, in the same order.
class RowReader {
 public:
  explicit RowReader(const double* at) : at_(at) {}

  double number() { return *at_++; }
  Index index() { return static_cast<Index>(number()); }
  std::uint64_t key() { return std::bit_cast<std::uint64_t>(number()); }
  Vec3 vector() {
    const double x = number(), y = number(), z = number();
    return {x, y, z};
  }

 private:
  const double* at_;
};

/// All but centre and mass.
inline void append_measure(const Cell& cell, std::vector<double>& row) {
  row.insert(row.end(), {cell.radius, cell.extent, cell.pull});
  append_key(cell.key, row);
}
inline void read_measure(RowReader& row, Cell& cell) {
  for (double* value : {&cell.radius, &cell.extent, &cell.pull}) *value = row.number();
  cell.key = row.key();
}

template <int P>
void append_cell(const EssentialTree<P>& tree, Index c, std::vector<double>& row) {
  row.insert(row.end(), tree.moments[c].row.begin(), tree.moments[c].row.end());
  append_measure(tree.octree.cells[c], row);
}

/// Adds a cell of another rank to the tree.
template <int P>
Index read_cell(RowReader& row, EssentialTree<P>& tree) {
  const auto c = static_cast<Index>(tree.octree.cells.size());
  Cell& cell = tree.octree.cells.emplace_back();
  Moments<P>& moments = tree.moments.emplace_back();
  for (double& value : moments.row) value = row.number();
  read_measure(row, cell);
  cell.center = moments.center();
  cell.mass = moments.row[0];
  cell.holder = Cell::Holder::elsewhere;
  return c;
}

}  // namespace spall
