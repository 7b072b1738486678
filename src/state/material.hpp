// What bodies are made of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "spall/types.hpp"

namespace spall {

/// How a metal flows, sigma = (A + B eps^n) (1 + C ln(rate)) (1 - T*^m), rate in 1/s, not less than
/// 1, T* from 298 K (0) to the melting point (1); and at which plastic strain it fails,
/// (D1 + D2 exp(D3 triaxiality)) (1 + D4 ln(rate)) (1 + D5 T*), triaxiality = mean stress over that
/// of von Mises. (Johnson & Cook, 7th Int. Symp. on Ballistics, 1983; Eng. Fract. Mech. 21 (1985).)
struct JohnsonCook {
  double a = 0, b = 0;         ///< Pa; a = 0: not known
  double n = 1, c = 0, m = 1;  ///< -
  std::array<double, 5> d{};   ///< -; all 0: not known

  bool fails() const { return d != std::array<double, 5>{}; }
  bool operator==(const JohnsonCook&) const = default;
};

/// Shear modulus and flow stress that grow with pressure and fall with temperature: of their values
/// at rest, G0 and Y0 (1 + beta eps)^n but at most Ymax, the part 1 + A P/eta^(1/3) - B (T - 298 K)
/// at the compression eta. (Steinberg, Cochran & Guinan, J. Applied Physics 51 (1980) 1498.)
struct SteinbergGuinan {
  double y0 = 0, ymax = 0;  ///< Pa; 0: not known
  double beta = 0, n = 0;   ///< -
  double a = 0;             ///< 1/Pa
  double b = 0;             ///< 1/K

  bool known() const { return y0 > 0; }
  bool operator==(const SteinbergGuinan&) const = default;
};

/// Flaws of a brittle solid: k eps^m a volume that a tensile strain eps opens. (Weibull,
/// Ingvetensk. Akad. Handl. 151 (1939); Grady & Kipp, Int. J. Rock Mech. Min. Sci. 17 (1980) 147.)
struct Weibull {
  double k = 0;  ///< 1/m^3; 0: not known
  double m = 0;

  bool known() const { return k > 0; }
};

/// The shear stress, as sqrt(J2), that rock bears at a pressure p; the more, the harder it is
/// pressed. What is intact bears Y_i = Y0 + mu_i p/(1 + mu_i p/(Ym - Y0)), or Y0 in tension; what
/// has failed slides at Y_d = min(mu_d p, Y_i). (Lundborg, Int. J. Rock Mech. Min. Sci. 5 (1968)
/// 427; Collins, Melosh & Ivanov, Meteorit. Planet. Sci. 39 (2004) 217.)
struct RockStrength {
  double cohesion = 0;         ///< Pa, Y0
  double friction = 0;         ///< mu_i
  double limit = 0;            ///< Pa, Ym; 0: not known
  double failed_friction = 0;  ///< mu_d, of metals, too

  bool known() const { return limit > 0; }
};

/// Pores of a solid, whose volume is alpha times that of its matter. They stay as they are up to
/// the pressure Pe; then they are crushed, until none are left at Ps:
///
///   alpha = 1 + (alpha0 - 1) ((Ps - P)/(Ps - Pe))^2 .
///
/// (Herrmann, J. Appl. Phys. 40 (1969) 2490; Carroll & Holt, J. Appl. Phys. 43 (1972) 759.)
struct Pores {
  double distension = 1;              ///< alpha0; 1: none
  double elastic = 0, compacted = 0;  ///< Pa, Pe and Ps

  bool any() const { return distension > 1; }
};

inline constexpr double room_temperature = 298;  ///< K, of all bodies that have no heat

/// What handbooks say of a solid. 0: not known; a law that needs it says so.
struct Solid {
  double density = 0;             ///< kg/m^3, of its matter: without pores
  double sound_speed = 0;         ///< m/s, c0 of the shock speed U_s = c0 + s u_p
  double hugoniot_slope = 0;      ///< s
  double gruneisen = 0;           ///< Gruneisen's parameter
  double youngs_modulus = 0;      ///< Pa
  double poisson_ratio = 0;       ///< -
  double yield_strength = 0;      ///< Pa
  double tensile_strength = 0;    ///< Pa
  double spall_strength = 0;      ///< Pa
  double fracture_energy = 0;     ///< J/m^2, K_Ic^2 (1 - nu^2)/E of its toughness K_Ic
  double specific_heat = 0;       ///< J/(kg K)
  double melting_point = 0;       ///< K
  double melt_energy = 0;         ///< J/kg, from room temperature to liquid
  double sublimation_energy = 0;  ///< J/kg, enthalpy of sublimation
  JohnsonCook johnson_cook;
  SteinbergGuinan steinberg = {};
  Weibull weibull = {};
  RockStrength rock = {};
  Pores pores = {};

  double bulk_density() const { return density / pores.distension; }  ///< kg/m^3, with its pores
  /// Pa, of its matter.
  double bulk_modulus() const { return density * sound_speed * sound_speed; }
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

struct Material {
  std::string name;
  double density = 0;           ///< kg/m^3 of a sphere of it
  double youngs_modulus = 0;    ///< Pa; 0: not known
  double poisson_ratio = 0.25;  ///< -
  /// What it is a piece of: then `density` and the elastic constants are the solid's, and a sphere
  /// of a lattice has the mass of its cell.
  std::optional<Solid> solid = std::nullopt;
};

/// "rock and ice".
std::string pair_name(const std::vector<Material>& materials, int a, int b);

}  // namespace spall
