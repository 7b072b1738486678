// Adhesion in proportion to the area of contact: a law of penalty contact of one's own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "penalty/normal_force.hpp"
#include "spall/types.hpp"

namespace spall {

/// Hertz's law less an attraction of c (J/m^3) on the area of contact, pi a^2:
/// F = 4/3 E* a delta - c pi a^2, a = sqrt(R delta). It is zero at a = 3 pi c R/(4 E*).
template <class Number>
struct ContactAreaLanes : NoAdhesion {
  static constexpr AdhesionKey key{"cohesion_density", "attraction over the area of contact",
                                   dimension::pressure};
  static constexpr bool adheres = true;
  static void derive(double c, LawConstants<double>& law) { law.attraction = pi * c; }
  static double resting_contact(const LawConstants<double>& law, double radius) {
    return 0.75 * law.attraction * radius / law.normal;
  }

  explicit ContactAreaLanes(const LawConstants<Number>& law)
      : modulus(law.normal), kt(law.tangential), pull(law.attraction) {}
  NormalForce force(const Lanes& overlap, const Lanes& radius) const {
    const Lanes a2 = radius * overlap, a = root_of(a2), attraction = pull * a2;
    return {.force = (4 / 3.0 * modulus) * a * overlap - attraction,
            .slope = (2 * modulus) * a,
            .tangential = kt * a,
            .attraction = attraction,
            .growth = 0.5 / overlap};
  }
  Lanes energy(const Lanes& overlap, const Lanes& radius) const {
    const Lanes square = overlap * overlap;
    return (8 / 15.0 * modulus) * root_of(radius * overlap) * square - 0.5 * pull * radius * square;
  }
  Number modulus, kt, pull;
};

}  // namespace spall
