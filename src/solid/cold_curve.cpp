// One ordinary differential equation, dE/d eta = P(eta, E), solved once from rest both ways.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/cold_curve.hpp"

#include <algorithm>
#include <cmath>

namespace spall {
namespace {

constexpr int nodes_a_side = 512;
/// Of 1/s, where the shock's pressure has no end, and of 1, where the density has none.
constexpr double strongest = 0.85;
constexpr double most_stretched = -0.3;  // eta; solids fail long before

}  // namespace

ColdCurve::ColdCurve(const Solid& solid)
    : bulk_modulus_(solid.bulk_modulus()),
      density_(solid.density),
      slope_(solid.hugoniot_slope),
      gruneisen_(solid.gruneisen) {
  last_ = strongest / std::max(1.0, slope_);
  step_ = last_ / nodes_a_side;
  const int stretched = static_cast<int>(std::ceil(-most_stretched / step_));
  first_ = -stretched * step_;
  at_rest_ = stretched;
  nodes_.resize(stretched + nodes_a_side + 1);
  const auto slope_of_energy = [&](double eta, double energy) {
    return shock(eta) + gruneisen_ * energy;
  };
  for (int way : {1, -1}) {
    double energy = 0;
    for (int k = stretched; k >= 0 && k < std::ssize(nodes_); k += way) {
      const double eta = (k - stretched) * step_, h = way * step_;
      nodes_[k] = {energy, slope_of_energy(eta, energy)};
      const double k1 = nodes_[k].pressure;
      const double k2 = slope_of_energy(eta + h / 2, energy + h / 2 * k1);
      const double k3 = slope_of_energy(eta + h / 2, energy + h / 2 * k2);
      const double k4 = slope_of_energy(eta + h, energy + h * k3);
      energy += h / 6 * (k1 + 2 * k2 + 2 * k3 + k4);
    }
  }
}

}  // namespace spall
