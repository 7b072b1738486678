// Pairs of one piece, their rows and ghosts, found again where bodies have come nearer than by the
// skin of the last search.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "solid/engine.hpp"
#include "state/world.hpp"

namespace spall {

/// Rows, volumes and reach of bodies, ghosts included; no impulses.
void fill_rows(const World& world, Elastoplastic& engine);
/// Owned bodies are where their rows are.
void take_positions(World& world, const Elastoplastic& engine);
double* doubles(auto& rows) {
  return reinterpret_cast<double*>(rows.data());
}

/// m. Collective.
double widest_spacing(const World& world);
/// How far bodies may act: neighbours of a piece by their spacing, those of two by the sum of their
/// radii. Collective.
PairReach reach_of_pieces(const World& world);

/// Makes pairs and ghosts current at the present places. Collective.
void update_pairs(World& world, Elastoplastic& engine);

/// Where a body of a group that rests has been set in motion, or a program's force acts since,
/// pairs are to be found anew, and how long parts may last. Collective.
void wake_what_moves(const World& world, Elastoplastic& engine);
/// All owned bodies that do not rest are brisk.
void forget_slow(const Bodies& bodies, Elastoplastic& engine);
/// Tells ghosts which bodies are slow, and finds the pairs with a brisk one. Collective.
void tell_slow(const Bodies& bodies, Elastoplastic& engine);

}  // namespace spall
