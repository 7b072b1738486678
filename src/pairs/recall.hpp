// What pairs remembered before a search, found by the bodies that it listed.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "spall/bodies.hpp"
#include "state/contact_memory.hpp"
#include "state/rows_of_ids.hpp"

namespace spall {

/// Entries of a memory that are of owned bodies. Both must outlive it.
class Recall {
 public:
  Recall(const Bodies& bodies, const ContactMemory& memory);

  /// Of a pair of rows, at least one of them owned; -1: there is none. Where there are several it
  /// is the first.
  Index of_pair(Index i, Index j) const { return first(all_of_pair(i, j)); }
  /// Of an owned row and a wall or plane.
  Index of_wall(Index row, Index wall) const { return first(all_of_wall(row, wall)); }

  struct Entry {
    BodyId other;
    Index at;  ///< in the memory
  };
  /// The same, all of them, in the order of the memory.
  std::span<const Entry> all_of_pair(Index i, Index j) const {
    if (bodies_.id[i] > bodies_.id[j]) std::swap(i, j);
    // A ghost may be the image of a body that this rank owns.
    const Index lower = i < bodies_.owned ? i : rows_.find(bodies_.id[i]);
    return lower >= 0 ? find(lower, bodies_.id[j]) : find(j, bodies_.id[i]);
  }
  std::span<const Entry> all_of_wall(Index row, Index wall) const { return find(row, -1 - wall); }

 private:
  std::span<const Entry> find(Index row, BodyId other) const;
  static Index first(std::span<const Entry> found) { return found.empty() ? -1 : found[0].at; }

  const Bodies& bodies_;
  RowsOfIds rows_;
  // Row b's lie at [start[b], start[b + 1]): of the lower id, or of the other where that is owned
  // by another rank.
  std::vector<Index> start_;
  std::vector<Entry> entries_;
};

}  // namespace spall
