// Reads [pair_potential] of a case.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "section.hpp"
#include "spall/scene/case.hpp"

namespace spall {

/// With `derived` where the law follows from a material.
void read_pair_potential(Section& in, PairPotential& potential, std::optional<DerivedLaw>& derived);

/// What phases of pair potentials need of the rest of the case.
void check_potential(const Case& scene, const Phase& phase);

}  // namespace spall
