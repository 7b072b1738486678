// Pressure and energy of a solid that is compressed without heat.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "state/material.hpp"

namespace spall {

/// The isentrope from rest of the equation of state of Mie and Gruneisen, Gamma rho constant. With
/// eta = 1 - rho0/rho and E = int P d eta (J/m^3 of the solid at rest),
///
///   P = P_H (1 - Gamma eta/2) + Gamma E,   P_H = K eta / (1 - s eta)^2,
///
/// also where the solid is stretched a little. (Meyers, Dynamic Behavior of Materials, ch. 5.) The
/// energy is a table, between whose nodes it is cubic with slopes P.
class ColdCurve {
 public:
  ColdCurve() = default;
  explicit ColdCurve(const Solid& solid);

  struct State {
    double pressure = 0;  ///< Pa
    double energy = 0;    ///< J/m^3 of the solid at rest
    double slope2 = 0;    ///< (m/s)^2, of the shock's pressure by density: bulk sound speed squared
  };
  /// At this density, of that at rest.
  State at(double compression) const;

 private:
  struct Node {
    double energy = 0, pressure = 0;
  };
  double shock(double eta) const;

  double bulk_modulus_ = 0, density_ = 0, slope_ = 0, gruneisen_ = 0;
  double first_ = 0, last_ = 0, step_ = 1;  // eta
  std::vector<Node> nodes_;
};

}  // namespace spall
