// What a fast impact throws out of the ground, by point-source theory: formulas and their keys.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "spall/types.hpp"

namespace spall {

class Section;

/// Against what launch angles are measured: the plane across the flight, or the ellipsoid that has
/// the target's moments of mass.
enum class LaunchSurface { plane, ellipsoid };

/// How the flow of an impact is handed to bodies, as a case asks for it. Constants of the ground
/// after Housen & Holsapple 2011, Icarus 211, 856, equations 14, 16, 18 and 19.
struct PointSource {
  std::string ground = {};  ///< a line of their Table 3; empty: own constants
  double mu = 0;            ///< exponent of the coupling parameter a U^mu delta^nu, in the speed
  double nu = 0.4;          ///< the same, in the density
  double C1 = 0;            ///< of launch speeds
  double k = 0;             ///< of launched mass
  double n1 = 1.2;          ///< nothing is launched within n1 a
  double n2 = 1, p = 0.3;   ///< at the rim: v ~ (1 - x/(n2 R))^p
  double density = 0;       ///< kg/m^3, rho: of the ground with its voids
  std::optional<double> crater_radius;  ///< m, R; without it nothing slows the flow at a rim
  double angle = 0.25 * pi;             ///< rad, of launches above the surface
  LaunchSurface surface = LaunchSurface::plane;
  double hand_over = 0;  ///< m, x from which on bodies get the flow
};

/// Reads the table `coupling` of an impactor.
void read_point_source(Section& in, PointSource& source);

/// What is launched between two distances from the site.
struct Launched {
  double mass = 0;      ///< kg
  double momentum = 0;  ///< kg m/s, sum of m |v|
  double energy = 0;    ///< J
};

/// The flow that one impactor starts. x is the distance, in m, from the site on the surface from
/// which matter is launched. Speeds are relative to the ground before the impact.
class LaunchFlow {
 public:
  /// `a`: m, radius of the impactor; `delta`: kg/m^3, its density; `U`: m/s, its speed.
  LaunchFlow(const PointSource& source, double a, double delta, double U);

  double begin() const { return begin_; }  ///< m, n1 a
  double end() const { return end_; }      ///< m, n2 R, or infinity
  /// m/s: C1 U [(x/a) (rho/delta)^nu]^(-1/mu) (1 - x/(n2 R))^p. x in [begin, end].
  double speed(double x) const;
  /// kg/m^2, what a unit of surface launches: dM / (2 pi x dx) = 3 k rho x / (2 pi).
  double column(double x) const;
  /// Between x = `from` and `to`, of dM = 3 k rho x^2 dx, which is M(x) = k rho (x^3 - (n1 a)^3).
  /// Relative error 1e-13 where n2 R is far, 1e-3 of the momentum of the last ring before it.
  Launched between(double from, double to) const;

 private:
  double k_rho_, scale_, exponent_, begin_, end_, p_;  // speed = scale x^-exponent (1 - x/end)^p
};

}  // namespace spall
