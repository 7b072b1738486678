// Penalty contact: what a case asks for, the law that follows from it, and the limits that it sets.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "state/world.hpp"

namespace spall {

enum class PenaltyModel { hertz, hooke };
enum class Adhesion : int;  ///< penalty/adhesions.hpp; the first is none

/// What a case tells of a pair in [penalty]; friction, restitution and cohesion are those of
/// [contact], elastic constants those of the materials. All pairs share model and adhesion.
struct PenaltySettings {
  PenaltyModel model = PenaltyModel::hertz;
  double stiffness = 0;                        ///< N/m: hooke
  double tangential_ratio = 2 / 7.0;           ///< of the stiffness: hooke
  std::optional<double> tangential_damping{};  ///< c_t/c; none: sqrt(k_t/S)
  double rolling_friction = 0;                 ///< bound of the rolling torque over R_eff F_n
  Adhesion adhesion{};
  double adhesion_strength = 0;  ///< w of dmt and jkr: J/m^2, twice the surface energy
};

/// The law of a pair with overlap delta, 1/R = 1/r_i + 1/r_j, 1/m = 1/m_i + 1/m_j, contact radius
/// a:
///
///   Hooke: F = k delta, dF/ddelta = S = k, k_t = tangential_ratio k
///   Hertz: F = 4/3 E* a delta, a = sqrt(R delta), S = 2 E* a; Mindlin: k_t = 8 G* a
///   DMT:   Hertz - 2 pi w R                    (Derjaguin, Muller & Toporov 1975)
///   JKR:   F = 4 E* a^3/(3 R) - sqrt(8 pi w E* a^3), delta = a^2/R - sqrt(2 pi w a/E*), down to
///          where dF/ddelta ends, -3/2 pi w R at fixed load (Johnson, Kendall & Roberts 1971)
///
/// with 1/E* the sum of (1 - nu^2)/E over both bodies and 1/G* that of 2 (2 - nu)(1 + nu)/E
/// (Johnson, Contact Mechanics, 1985, eqs. 4.20, 7.43). Added to it: -c u_n, c = damping sqrt(S
/// m), and the constant attraction of [contact] up to its range. Tangential: -k_t xi - c_t u_t with
/// |F_t| <= friction |F_n + attraction|, c_t = sqrt(k_t/S) c unless it is given; the spring xi
/// grows with u_t, turns with the pair and is cut back with the force (Cundall & Strack 1979;
/// Luding 2008).
template <class Number>
struct LawConstants {
  Number normal{};              ///< hooke: k, N/m; hertz: E*, Pa
  Number tangential{};          ///< hooke: k_t, N/m; hertz: 8 G*, Pa
  Number damping{};             ///< c / sqrt(S m)
  Number tangential_damping{};  ///< c_t / c
  Number friction{};
  Number rolling_friction{};
  Number cohesion{};        ///< N, attraction at gaps below the range
  Number cohesion_range{};  ///< m
  Number attraction{};      ///< of adhesion; dmt: 2 pi w, jkr: 3 pi w, N/m, of R
  Number neck{};            ///< of adhesion; jkr: (2 pi w/E*)^(1/3), m^(1/3), of R^(2/3)

  bool operator==(const LawConstants&) const = default;
};
struct PenaltyLaw : LawConstants<double> {
  PenaltyModel model = PenaltyModel::hertz;
  Adhesion adhesion{};

  bool operator==(const PenaltyLaw&) const = default;
};

/// Of bodies of materials `a` and `b`, with the damping that gives the restitution e. Hooke: 2
/// beta, beta = -ln e/sqrt(pi^2 + ln^2 e); Hertz: 2 sqrt(5/6) beta, at any speed (Antypov &
/// Elliott, EPL 94 (2011) 50004, eq. 17).
PenaltyLaw penalty_law(const PenaltySettings& settings, const ContactLaw& contact,
                       const Material& a, const Material& b);

/// The laws between the materials that bodies and walls are of; pairs of others have constants of
/// zero. A single one where it serves all. Collective.
ByPair<PenaltyLaw> penalty_laws(const World& world, const ByPair<PenaltySettings>& settings);

/// m, the widest gap at which bodies of this radius (m) may act on each other: the range of
/// cohesion, or the neck of JKR.
double widest_gap(const PenaltyLaw& law, double radius);
double widest_gap(const ByPair<PenaltyLaw>& laws, double radius);

/// Whether springs against rolling are kept.
bool resists_rolling(const ByPair<PenaltyLaw>& laws);

/// Throws Error, which names the two bodies that set the limit and tells the step or stiffness that
/// would do, where `h` (s) does not resolve a collision at `speed` (m/s), the largest at which two
/// bodies may meet, or where bodies would pass through each other. Collective; `place` is for the
/// message.
void check_penalty_step(const World& world, const ByPair<PenaltySettings>& settings, double h,
                        double speed, const std::string& place);

}  // namespace spall
