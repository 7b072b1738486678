// Who is near whom: cells by size, a level of them for each half power of two. The search of all
// engines.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "spall/bodies.hpp"

namespace spall {

/// Partners are those whose spheres meet, each grown by its own reach.
struct Reach {
  double common = 0;                     ///< m, by which all grow
  std::span<const double> of_rows = {};  ///< m, and each row on top of that; may be empty
  bool points = false;                   ///< bodies have no radius of their own
  double skin = 0;                       ///< m: partners nearer by so much come first

  double grown(const Bodies& bodies, Index row) const {
    return (points ? 0 : bodies.radius[row]) + common + (of_rows.empty() ? 0 : of_rows[row]);
  }
};

/// With which of two bodies of one size their pair is listed. Of two sizes it is the smaller one,
/// of a ghost and an owned body the owned one.
enum class ListedWith {
  lower_row,  ///< partners come in the order of cells about the origin, which lasts over searches
  first_cell  ///< on a space-filling curve; owned rows come in its order, too
};

/// Called when all partners of a row have been appended; `near` of them, the first ones, are nearer
/// by the skin.
using EndRow = std::function<void(Index row, Index near)>;

/// Finds all partners of owned bodies: each pair once. Appends a body's partners to `partners`,
/// then calls `end_row`, which may take them away; smaller bodies come before larger ones.
/// Ghosts must be current.
void find_partners(const Bodies& bodies, const Reach& reach, ListedWith listed,
                   std::vector<Index>& partners, const EndRow& end_row);

}  // namespace spall
