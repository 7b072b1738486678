// The pairs that may touch as a plain list, with the impulses that they carried.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "spall/bodies.hpp"
#include "state/contact_memory.hpp"
#include "state/walls.hpp"

namespace spall {

/// What the last contact of a pair carried.
struct CarriedImpulse {
  Index pair;
  std::int32_t of_i = 0, of_j = 0;  ///< of bodies with shapes: places in their lists of spheres
  Vec3 impulse;                     ///< N s, not 0
};

/// Pairs of rows (or a row and a plane) with at least one owned body, each once: first the
/// `boundary` pairs with a ghost, then the interior ones, each part in the order of the rows.
struct Pairs {
  Index boundary = 0;
  std::vector<Index> i, j;          ///< id(i) < id(j); j is `ground` at a plane
  std::vector<std::int32_t> plane;  ///< -1 between spheres
  /// In the order of the pairs, of which far more are near each other than touch.
  std::vector<CarriedImpulse> carried;

  Index size() const { return static_cast<Index>(i.size()); }
};

/// All pairs whose spheres, each grown by its `reach` (m, one a row), meet; walls are grown by that
/// of the body. None has carried
/// anything.
Pairs find_pairs(const Bodies& bodies, std::span<const double> reach,
                 const std::vector<Plane>& planes);

/// Impulses by id; each contact on one rank (that of row i) with `once`, else on every rank that
/// has it.
ContactMemory remember(const Bodies& bodies, const Pairs& pairs, bool once);

/// Gives the pairs the impulses that were remembered for them.
void recall(const Bodies& bodies, const ContactMemory& memory, Pairs& pairs);

}  // namespace spall
