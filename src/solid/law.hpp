// What a step asks of the material of a solid: pressure, flow stress, failure.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <string>

#include "solid/cold_curve.hpp"
#include "state/material.hpp"

namespace spall {

/// alpha of pores that have been crushed so far, with what it was at rest; of numbers or lanes.
template <class T>
T distension_of(const T& at_rest, const T& crushed) {
  return 1.0 + (at_rest - 1.0) * (1.0 - crushed) * (1.0 - crushed);
}

/// Constants and curves of one material.
struct SolidLaw {
  double density = 0;          ///< kg/m^3, with its pores; 0: it is no solid
  double bulk = 0, shear = 0;  ///< Pa, with its pores
  double slope = 0;            ///< s of the shock speed c0 + s u_p
  double gruneisen = 0;
  double strength = infinity;             ///< Pa, tension from all sides that opens voids
  double fracture_energy = 0;             ///< J/m^2; 0: not known
  double specific_heat = 0, melting = 0;  ///< J/(kg K), K; 0: not known
  bool yields = true;
  JohnsonCook flow;
  SteinbergGuinan steinberg;  ///< in place of Johnson and Cook's flow stress, where it is known
  Weibull flaws;
  RockStrength rock;
  Pores pores;
  double filled = 1;       ///< the share of the volume at rest that is matter, 1/alpha0
  std::uint64_t seed = 0;  ///< of the flaws
  ColdCurve cold;

  double bulk_speed() const { return std::sqrt(bulk / density); }  ///< m/s
  double sound_speed() const;                                      ///< m/s, longitudinal
  double youngs_modulus() const { return 9 * bulk * shear / (3 * bulk + shear); }  ///< Pa
  bool brittle() const { return flaws.known(); }
  /// J/kg that warm it from 298 K to the melting point, infinite where that is not known. The heat
  /// of a body over it is its homologous temperature, from 0 to 1 (molten) and more.
  double melting_heat() const;
  /// What shear modulus and flow stress of Steinberg and Guinan's metals are of those at rest, with
  /// this pressure (Pa) and heat (J/kg); 0 where nothing is left.
  double stiffness(double compression, double pressure, double heat) const;
  /// The plastic strain at which it fails; infinite under a pressure that keeps it together.
  double failure_strain(double triaxiality, double rate, double homologous) const;
  /// The plastic strain from its beginning to its end over which a body of this volume at rest
  /// (m^3) fails, with the flow stress (Pa) of whole metal, over which the triaxiality is told.
  double parting_strain(double triaxiality, double flow_stress, double rest_volume) const;
  /// The share of voids at which a body of this volume at rest (m^3) bears nothing any more.
  double most_voids(double rest_volume) const;
  /// Pa, which no flow stress at this temperature is below, at the stiffness 1.
  double least_flow_stress(double homologous) const;
  /// Pa, von Mises' stress sqrt(3 J2) that intact rock bears at this pressure, and at which what
  /// has failed slides.
  double intact_strength(double pressure) const;
  double sliding_strength(double pressure) const;
  /// alpha, where pores have been crushed so far.
  double distension(double crushed) const { return distension_of(pores.distension, crushed); }
};

/// m^3 a body in a close-packed lattice of this spacing (m).
inline double volume_of_lattice(double spacing) {
  return spacing * spacing * spacing / std::sqrt(2.0);
}

/// Throws Error, which begins with `place`, where a constant is missing.
SolidLaw solid_law(const Solid& solid, bool yields, const std::string& place);

}  // namespace spall
