// Who has which part of gravity's curve: each rank learns of those where it has bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "base/traffic.hpp"
#include "gravity/curve.hpp"
#include "gravity/octree.hpp"

namespace spall {

/// Keys [begin, end): the part of a rank.
struct CurvePart {
  std::uint64_t begin, end;
  int rank;
};

/// Along the curve, at least the parts that hold some of `rows`, which are sorted, and this rank's
/// own. Ranks get about equal numbers of bodies. `stretches` are those of all bodies. No stretch of
/// `leaf_size` bodies is divided. Collective.
std::vector<CurvePart> find_parts(const Comm& comm, std::span<const KeyedRow> rows,
                                  std::span<const Stretch> stretches, int leaf_size);

/// The parts of all planned ranks, and what each of them would send to find them.
std::vector<CurvePart> foretell_parts(const Comm& alone, std::span<const KeyedRow> rows,
                                      std::span<const Stretch> stretches, int leaf_size,
                                      PlannedRanks& ranks);

}  // namespace spall
