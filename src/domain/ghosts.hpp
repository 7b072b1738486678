// The ghost exchange: owned rows to the ranks with copies of them, by PETSc's star forest.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <initializer_list>
#include <memory>
#include <span>
#include <vector>

#include "spall/comm.hpp"
#include "spall/types.hpp"

namespace spall {

/// Where a ghost's original lives.
struct Origin {
  int rank;
  Index row;
};

/// The rows of one array: `width` doubles each.
struct FieldRows {
  double* rows;
  int width;
};

/// A communication plan. Ghost g is row `owned + g` on this rank. It is a copy of row
/// `origins[g].row` on rank `origins[g].rank`. Rows are arrays of doubles of any fixed width.
/// Collective to make, use and destroy.
class Ghosts {
 public:
  Ghosts();  ///< no ghosts at all; needs no communicator
  Ghosts(Comm comm, Index owned, std::span<const Origin> origins);
  ~Ghosts();
  Ghosts(Ghosts&&) noexcept;
  Ghosts& operator=(Ghosts&&) noexcept;

  Index owned() const;
  Index ghosts() const;
  const Comm& comm() const;

  /// Copies owned rows of `rows` into the ghost rows of the ranks that hold copies. `rows` has
  /// (owned + ghosts) x width doubles, row major. Between `begin` and `end` owned rows must not be
  /// written and ghost rows not read. One message to each neighbour.
  void gather_begin(double* rows, int width) const;
  void gather_end(double* rows, int width) const;
  void gather(double* rows, int width) const {
    gather_begin(rows, width);
    gather_end(rows, width);
  }

  /// The same of several arrays, still in one message to each neighbour.
  void gather(std::initializer_list<FieldRows> fields) const {
    gather(std::span(fields.begin(), fields.size()));
  }
  void gather(std::span<const FieldRows> fields) const;

 private:
  struct Plan;
  std::unique_ptr<Plan> plan_;
};

}  // namespace spall
