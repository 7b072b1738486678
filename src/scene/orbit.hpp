// The orbit of a binary's secondary, and what a hit along its motion makes of it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene/case.hpp"

namespace spall {

/// After a velocity change along the motion (thesis eqs. 3.3, 3.4).
struct Orbit {
  double a_new = 0;  ///< m, semi-major axis; negative where the secondary escapes
  double T_new = 0;  ///< s; infinite where it escapes
  double dT = 0;     ///< s, T_new - T_old
};
Orbit new_orbit(const Binary& binary, double dv);

/// s, of an orbit with semi-major axis `a` (m) about `mu` (m^3/s^2); infinite where `a` is
/// negative.
double orbit_period(double a, double mu);

/// Throws Error unless the period is that of separation, speed and parameter: what it differs by
/// would be taken for the work of the impact.
void check_orbit(const Binary& binary);

}  // namespace spall
