// From the constants of a solid to the law between the spheres that stand for it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "potential/pair_potential.hpp"
#include "state/material.hpp"

namespace spall {

/// What a law derived from a solid is to get right. The one stiffness of pairs alone sets shear and
/// bulk modulus both: with the bulk modulus right, the shear modulus is 1.8 times aluminium's.
enum class Match { solid, bulk };

/// Morse's law for the lattice of a solid, with its spall strength, where that is known, in a plane
/// wave, as it is measured: the mean over crystals turned at random, 0.725 of what they bear under
/// equal tension from all sides:
///
///   bulk:  k = 18 m c0^2 / (Z d^2),  a d = K' - 1 = 4 s - 2: bulk modulus and its slope
///   solid: below d k = 0.18 * 1.25 sqrt(2) G d, 0.18 of what would give the lattice Voigt's mean
///          of the shear modulus, but it does not yield, and a d = 1.3 (4 s - 2), for two bodies
///          alone to stop each other at hypervelocity; an embedding gives the rest of the
///          pressure: bulk modulus, Hugoniot and heat's, with half of Gruneisen's parameter.
///          Above d bonds are springs with the k of `bulk`: so much energy breaks them as the
///          solid's modulus says
///   D = k d^2 / (2 (a d)^2),  bonds break at the force F_b = 6 V sigma / (0.725 Z d).
///
/// `place` says in messages who asks. Throws Error where a constant is missing or a strength is
/// more than the whole law bears.
PairPotential morse_law(const Solid& solid, const Lattice& lattice, Match match,
                        const std::string& place);

/// Between bodies of two solids. A bond is two halves in series, each with twice the stiffness of a
/// whole one of its solid, so that to second order in the force
///
///   k = 2 k_a k_b/(k_a + k_b),  d = (d_a + d_b)/2,
///   s/d = 2 (k_b^2 s_a/d_a + k_a^2 s_b/d_b)/(k_a + k_b)^2,
///
/// pressed and, where they pull, stretched. Without `bonded` there is no force beyond d: bodies
/// that meet do not weld. With it bonds break at the smaller of the two forces. Each body keeps the
/// embedding of its own solid. Of equal laws it is theirs. Both must be Morse's.
PairPotential mixed_law(const PairPotential& a, const PairPotential& b, bool bonded);

/// Pa, plane tension that the lattice bears, mean over its directions: 0.725 Z F_b d / (6 V).
double plane_strength(const PairPotential& potential, const Lattice& lattice);

/// m/s, of long waves in an fcc lattice of central bonds to the nearest neighbours, C11 = 2 C12 =
/// 2 C44 = sqrt(2) k/d, where it is pressed, with what an embedding adds to C11 and C12. In a shear
/// wave half of the bonds are stretched.
struct LatticeSpeeds {
  double bulk = 0;
  double along_100 = 0, along_110 = 0, along_111 = 0;  ///< longitudinal
  double shear_100 = 0;
};
LatticeSpeeds sound_speeds(const PairPotential& potential, double mass);

}  // namespace spall
