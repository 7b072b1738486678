// Pairs of bodies that hold together.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "domain/ghosts.hpp"
#include "spall/bodies.hpp"

namespace spall {

/// Pairs of rows of `bodies` that count as connected; a pair with a ghost is on both ranks, as in
/// `Contacts`.
struct Links {
  std::vector<Index> i, j;
};

/// The same, with a copy of the bodies and the ghosts that the rows belong to.
struct LinkedBodies {
  Bodies bodies;
  Ghosts ghosts;
  Links links;
};

}  // namespace spall
