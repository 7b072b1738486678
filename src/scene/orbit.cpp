// Vis-viva and Kepler's third law.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/orbit.hpp"

#include <cmath>

#include "spall/error.hpp"
#include "spall/types.hpp"

namespace spall {

Orbit new_orbit(const Binary& binary, double dv) {
  const double mu = binary.parameter, v = binary.speed + dv;
  Orbit orbit;
  orbit.a_new = -(mu / 2) / (v * v / 2 - mu / binary.separation);
  orbit.T_new = orbit_period(orbit.a_new, mu);
  orbit.dT = orbit.T_new - binary.period;
  return orbit;
}

double orbit_period(double a, double mu) {
  return a > 0 ? 2 * pi * std::sqrt(a * a * a / mu) : infinity;
}

void check_orbit(const Binary& binary) {
  const double period = new_orbit(binary, 0).T_new;
  require(std::isfinite(period), "{}: at this speed the target is not bound to its primary",
          binary.place);
  constexpr double as_told = 1e-4;  // relative; 4 s of 12 h
  require(
      std::abs(binary.period - period) <= as_told * period,
      "{}.period = {:g} s, but separation, speed and parameter make it {:.8g} s: the difference "
      "would be taken for the impact's",
      binary.place, binary.period, period);
}

}  // namespace spall
