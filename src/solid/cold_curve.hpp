// Pressure and energy of a solid that is compressed without heat.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
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
  /// At this density, of that at rest; there exactly 0.
  State at(double compression) const {
    const double asked = 1 - 1 / compression, eta = std::clamp(asked, first_, last_);
    const double place = eta / step_ + at_rest_;
    const std::size_t k = std::min(static_cast<std::size_t>(place), nodes_.size() - 2);
    const double t = place - static_cast<double>(k), u = 1 - t;
    const Node &a = nodes_[k], &b = nodes_[k + 1];
    const double energy = u * u * (1 + 2 * t) * a.energy + t * t * (3 - 2 * t) * b.energy +
                          step_ * t * u * (u * a.pressure - t * b.pressure);
    const double pressure = shock(eta) + gruneisen_ * energy;
    const double left = 1 - slope_ * eta, thinner = 1 - eta;
    return {.pressure = pressure,
            .energy = energy + pressure * (asked - eta),  // beyond the table the pressure stays
            .slope2 = bulk_modulus_ / density_ * thinner * thinner * (1 + slope_ * eta) /
                      (left * left * left)};
  }

 private:
  struct Node {
    double energy = 0, pressure = 0;
  };
  double shock(double eta) const {
    const double left = 1 - slope_ * eta;
    return bulk_modulus_ * eta / (left * left) * (1 - gruneisen_ * eta / 2);
  }

  double bulk_modulus_ = 0, density_ = 0, slope_ = 0, gruneisen_ = 0;
  double first_ = 0, last_ = 0, step_ = 1;  // eta
  double at_rest_ = 0;                      // the node
  std::vector<Node> nodes_;
};

}  // namespace spall
