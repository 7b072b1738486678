// Pressure and energy of a solid that is compressed without heat.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "spall/lanes.hpp"
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

  template <class T>
  struct State {
    T pressure{};  ///< Pa
    T energy{};    ///< J/m^3 of the solid at rest
    T slope2{};    ///< (m/s)^2, of the shock's pressure by density: bulk sound speed squared
    T by_eta{};    ///< Pa, dP/d eta; 0 beyond the table, where the pressure stays
  };
  /// At this density, of that at rest; there exactly 0. Of one or of lanes.
  template <class T>
  State<T> at(const T& compression) const {
    const T none{};
    const T asked = 1.0 - 1.0 / compression;
    const T eta = larger<T>(none + first_, smaller<T>(none + last_, asked));
    const auto [a, b, t] = nodes_at(T(eta / step_ + at_rest_));
    const T u = 1.0 - t;
    const T energy = u * u * (1.0 + 2.0 * t) * a.energy + t * t * (3.0 - 2.0 * t) * b.energy +
                     step_ * t * u * (u * a.pressure - t * b.pressure);
    const T pressure = shock(eta) + gruneisen_ * energy;
    const T left = 1.0 - slope_ * eta, thinner = 1.0 - eta;
    const T rise = bulk_modulus_ * (1.0 + slope_ * eta) / (left * left * left);  // of P_H
    const T by_eta = rise * (1.0 - gruneisen_ * eta / 2.0) + gruneisen_ * pressure -
                     gruneisen_ / 2 * bulk_modulus_ * eta / (left * left);
    return {.pressure = pressure,
            .energy = energy + pressure * (asked - eta),
            .slope2 = rise / density_ * thinner * thinner,
            .by_eta = select(asked == eta, by_eta, none)};
  }

 private:
  template <class T>
  struct Node {
    T energy{}, pressure{};
  };
  /// The nodes around a place, counted from the first one, and how far it is between them.
  template <class T>
  struct Interval {
    Node<T> a, b;
    T t;
  };
  Interval<double> nodes_at(double place) const {
    const std::size_t k = std::min(static_cast<std::size_t>(place), nodes_.size() - 2);
    return {nodes_[k], nodes_[k + 1], place - static_cast<double>(k)};
  }
  template <class V>
  Interval<V> nodes_at(const V& place) const {
    Interval<V> lanes;
    for (std::size_t l = 0; l < size_of_vector<V>; ++l) {
      const Interval<double> one = nodes_at(place[l]);
      lanes.a.energy[l] = one.a.energy;
      lanes.a.pressure[l] = one.a.pressure;
      lanes.b.energy[l] = one.b.energy;
      lanes.b.pressure[l] = one.b.pressure;
      lanes.t[l] = one.t;
    }
    return lanes;
  }
  template <class T>
  T shock(const T& eta) const {
    const T left = 1.0 - slope_ * eta;
    return bulk_modulus_ * eta / (left * left) * (1.0 - gruneisen_ * eta / 2.0);
  }

  double bulk_modulus_ = 0, density_ = 0, slope_ = 0, gruneisen_ = 0;
  double first_ = 0, last_ = 0, step_ = 1;  // eta
  double at_rest_ = 0;                      // the node
  std::vector<Node<double>> nodes_;
};

}  // namespace spall
