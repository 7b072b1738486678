// From the constants of a solid to the law between the spheres that stand for it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/base/types.hpp"
#include "spall/force/pair_potential.hpp"

namespace spall {

/// What handbooks say of a solid. 0: not known; a law that needs it says so.
struct Solid {
  double density = 0;             ///< kg/m^3
  double sound_speed = 0;         ///< m/s, c0 of the shock speed U_s = c0 + s u_p
  double hugoniot_slope = 0;      ///< s
  double gruneisen = 0;           ///< Gruneisen's parameter
  double youngs_modulus = 0;      ///< Pa
  double poisson_ratio = 0;       ///< -
  double yield_strength = 0;      ///< Pa
  double tensile_strength = 0;    ///< Pa
  double spall_strength = 0;      ///< Pa
  double specific_heat = 0;       ///< J/(kg K)
  double melting_point = 0;       ///< K
  double melt_energy = 0;         ///< J/kg, from room temperature to liquid
  double sublimation_energy = 0;  ///< J/kg

  double bulk_modulus() const { return density * sound_speed * sound_speed; }          ///< Pa
  double shear_modulus() const { return youngs_modulus / (2 * (1 + poisson_ratio)); }  ///< Pa
};

/// K, of a solid that had room temperature, 298 K, before it took up `heat` (J/kg): in proportion
/// to its specific heat but while it melts.
double temperature(const Solid& solid, double heat);

/// A lattice of equal spheres, by its nearest neighbours.
struct Lattice {
  int neighbours = 0;   ///< Z
  double cell = 0;      ///< volume of a sphere's cell over d^3
  double distance = 0;  ///< m, d
  double volume() const { return cell * distance * distance * distance; }  ///< m^3, V
};

/// kg, of a sphere that stands for its cell of the solid.
double sphere_mass(const Solid& solid, const Lattice& lattice);

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
///   D = k / (2 (a d)^2),  bonds break at the force F_b = 6 V sigma / (0.725 Z d).
///
/// `place` says in messages who asks. Throws Error where a constant is missing or a strength is
/// more than the whole law bears.
PairPotential morse_law(const Solid& solid, const Lattice& lattice, Match match,
                        const std::string& place);

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

/// How rigid spheres hold together like the solid.
struct Cohesion {
  double force = 0;     ///< N: tensile strength = phi Z F / (pi d^2), phi = (pi/6) / cell
  double range = 0;     ///< m: the stretch at which the elastic solid bears its tensile strength
  double friction = 0;  ///< shear over tensile strength: yield/sqrt(3) (von Mises) over tensile
};
Cohesion cohesion_of(const Solid& solid, const Lattice& lattice, const std::string& place);

}  // namespace spall
