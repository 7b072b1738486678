// What every normal law of penalty contact is, for eight contacts at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/units.hpp"
#include "penalty/penalty.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// A constant of one law for all lanes, or of one for each.
inline Lanes lanes_of(double constant) {
  return spread(constant);
}
inline const Lanes& lanes_of(const Lanes& constants) {
  return constants;
}

/// What the normal law says of a contact; see `PenaltyLaw`.
struct NormalForce {
  Lanes force;       ///< N, without damping
  Lanes slope;       ///< S, N/m
  Lanes tangential;  ///< k_t, N/m
  Lanes attraction;  ///< N, by which the friction bound exceeds the force
  Lanes growth;      ///< 1/m, of k_t with the overlap: d ln k_t/d delta
};

/// The key of [penalty] that tells how strong a law of adhesion is. Laws may share one.
struct AdhesionKey {
  const char *name = nullptr, *meaning = "";  ///< without a name there is none
  Dimension dimension{};
};
inline constexpr AdhesionKey work_of_adhesion{
    "work_of_adhesion", "of two surfaces, twice the surface energy", {0, 1, -2}};

/// Beside what a sweep asks, a law of adhesion has these; this one, which others derive from, has
/// no adhesion. R (m) is the reduced radius of a pair.
struct NoAdhesion {
  static constexpr AdhesionKey key{};
  static constexpr bool sticks = false;   ///< contacts have a neck, which forms and parts at once
  static constexpr bool adheres = false;  ///< always with friction: no kernel without it is built
  /// Sets `attraction` and `neck` of a law that has all else, by its strength, in the key's unit.
  static void derive(double, LawConstants<double>&) {}
  /// m, the widest gap at which a pair that has touched still holds; grows with R.
  static double reach(const LawConstants<double>&, double) { return 0; }
  /// m, of the contact of a pair that is pulled together by nothing but adhesion; 0: not needed.
  static double resting_contact(const LawConstants<double>&, double) { return 0; }
};

}  // namespace spall
