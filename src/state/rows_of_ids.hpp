// Which row of a rank is which body.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "base/hash.hpp"
#include "spall/bodies.hpp"

namespace spall {

/// Rows of bodies by id: of the owned ones, or of the first `rows`; one of them where several have
/// the id, as images do. Ids of a rank are often a run of numbers: these find their rows
/// at a place of their own, in order, the others after a scatter.
class RowsOfIds {
 public:
  explicit RowsOfIds(const Bodies& bodies) : RowsOfIds(bodies, bodies.owned) {}
  RowsOfIds(const Bodies& bodies, Index rows)
      : bodies_(bodies), table_(std::bit_ceil(2 * static_cast<std::size_t>(rows) + 1), -1) {
    for (Index b = 0; b < rows; ++b) table_[place(bodies.id[b])] = b;
  }
  /// -1: not among them.
  Index find(BodyId id) const { return table_[place(id)]; }

 private:
  std::size_t place(BodyId id) const {
    const std::size_t last = table_.size() - 1;
    std::size_t at = static_cast<std::size_t>(id) & last;
    if (is(at, id)) return at;
    at = mix(static_cast<std::uint64_t>(id)) & last;
    while (!is(at, id)) at = (at + 1) & last;
    return at;
  }
  bool is(std::size_t at, BodyId id) const {
    return table_[at] < 0 || bodies_.id[table_[at]] == id;
  }

  const Bodies& bodies_;
  std::vector<Index> table_;
};

}  // namespace spall
