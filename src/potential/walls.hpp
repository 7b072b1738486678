// Pair potentials at walls, which repel as bodies do that are pressed.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "potential/pair_potential.hpp"
#include "potential/sweep.hpp"
#include "state/by_pair.hpp"
#include "state/world.hpp"

namespace spall {

/// An owned body near a wall. The wall acts as a body of the pair's law whose surface it is: with d
/// the law's distance of rest, a body h above the wall feels the law at r = h + d/2 where r < d. So
/// the wall repels, without damping, and never pulls.
struct AtWall {
  Index row;
  std::int32_t wall;
};

/// Those that may act on a wall until they have come nearer to it by `skin` (m).
std::vector<AtWall> bodies_at_walls(const World& world, const ByPair<PairPotential>& laws,
                                    double skin);

/// Adds the walls' forces (N) to the rows, at the rows' places. The walls receive the opposite over
/// `h` (s).
void push_from_walls(World& world, const ByPair<PairPotential>& laws,
                     const std::vector<AtWall>& pairs, double h, PairRow* rows);

/// J, of all these bodies at walls; none at rest.
double energy_at_walls(const World& world, const ByPair<PairPotential>& laws,
                       const std::vector<AtWall>& pairs, const PairRow* rows);

}  // namespace spall
