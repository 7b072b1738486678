// What a case tells the engine of pair potentials.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "potential/constitutive.hpp"
#include "potential/pair_potential.hpp"
#include "state/by_pair.hpp"

namespace spall {

/// Laws that follow from the constants of materials and the lattices of the groups that are of
/// them.
struct DerivedLaw {
  std::vector<std::string> materials;
  std::string place;  ///< where the case asks for it, for messages
  Match match = Match::solid;
};

/// An exception for one pair of materials.
struct LawBetween {
  std::vector<std::string> materials;  ///< two
  std::string place;
  PairPotential law;  ///< by hand; else its breaking_strain and damping, where they are given
  bool by_hand = false;
  bool bonded = false;  ///< the pair pulls
};

struct PotentialSettings {
  ByPair<PairPotential> law;  ///< complete once derived
  PairPotential common;       ///< of [pair_potential] itself
  std::optional<DerivedLaw> derived;
  std::vector<LawBetween> between;
};

}  // namespace spall
