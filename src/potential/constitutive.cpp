// Formulas for central forces between the nearest neighbours of a lattice.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/constitutive.hpp"

#include <algorithm>
#include <cmath>

#include "spall/error.hpp"

namespace spall {
namespace {

/// What crystals turned at random bear in a plane wave, where only one direction is stretched and
/// bonds across it bear nothing, of what they bear under tension from all sides: mean over all
/// directions (0.62 along [110], 1 along [100] and [111]).
constexpr double plane_share = 0.725;

/// Of the shear modulus, where pressed: a perfect crystal does not yield where metal flows, and
/// weak shocks would run a fifth too fast with all of it (bench/run_solid.sh).
constexpr double shear_share = 0.18;
/// Of the steepness of the whole law: pairs so soft stop two bodies that meet alone at
/// hypervelocity only if they stiffen faster. The solid's pressure is the embedding's business.
constexpr double steepness_share = 1.3;
/// Of Gruneisen's parameter, by trial on two shots of cases/plate: heat is what dashpots book, and
/// bodies that move at random press on their own.
constexpr double gruneisen_share = 0.5;

}  // namespace

PairPotential morse_law(const Solid& solid, const Lattice& lattice, Match match,
                        const std::string& place) {
  require(solid.sound_speed > 0 && solid.hugoniot_slope > 0.5,
          "{} needs the material's sound_speed and its hugoniot_slope, which must be more than 0.5",
          place);
  require(lattice.neighbours >= 12,
          "{}: bonds between the nearest neighbours make no solid of a simple cubic lattice, which "
          "has no shear stiffness; take fcc or hcp",
          place);
  require(!solid.pores.any(), "{}: pairs have no pores; leave out the material's distension",
          place);
  const double Z = lattice.neighbours, d = lattice.distance, V = lattice.volume();
  const double all_k =
      18 * sphere_mass(solid, lattice) * solid.sound_speed * solid.sound_speed / (Z * d * d);
  double k = all_k;
  PairPotential p{.law = PairLaw::morse, .distance = d, .steepness = 4 * solid.hugoniot_slope - 2};
  if (match == Match::solid) {
    require(solid.gruneisen > 0 && solid.youngs_modulus > 0 && solid.poisson_ratio != 0 &&
                solid.spall_strength > 0,
            "{} needs the material's gruneisen, youngs_modulus, poisson_ratio and spall_strength; "
            "match = \"bulk\" does without",
            place);
    k = shear_share * 1.25 * std::sqrt(2.0) * solid.shear_modulus() * d;
    require(k < all_k,
            "{}: pairs with {:g} of the material's shear modulus, {:.3g} Pa, give more than its "
            "bulk modulus, {:.3g} Pa",
            place, shear_share, solid.shear_modulus(), solid.bulk_modulus());
    p.steepness *= steepness_share;
    p.tension = all_k;
    p.embedding = {.bulk_modulus = solid.bulk_modulus(),
                   .hugoniot_slope = solid.hugoniot_slope,
                   .gruneisen = gruneisen_share * solid.gruneisen,
                   .density = solid.density};
  }
  p.depth = k * d * d / (2 * p.steepness * p.steepness);
  // Half of the next shell's distance beyond: the whole law where it is not made to break.
  p.cutoff = (1 + std::sqrt(2.0)) / 2 * d;
  if (solid.spall_strength > 0) {
    const double most = plane_strength(p, lattice);
    require(solid.spall_strength < most,
            "{}: spall_strength = {:g} Pa is more than the {:.3g} Pa that bonds of this sound "
            "speed and Hugoniot slope can bear",
            place, solid.spall_strength, most);
    p.breaking_strain = strain_of_force(p, 6 * V * solid.spall_strength / (plane_share * Z * d));
    p.cutoff = (1 + 2 * p.breaking_strain) * d;
  }
  return p;
}

PairPotential mixed_law(const PairPotential& a, const PairPotential& b, bool bonded) {
  PairPotential p = a;
  if (a != b) {
    const double ka = stiffness_pressed(a), kb = stiffness_pressed(b);
    const double k = 2 * ka * kb / (ka + kb);
    p.distance = (a.distance + b.distance) / 2;
    p.steepness = 2 * p.distance *
                  (kb * kb * a.steepness / a.distance + ka * ka * b.steepness / b.distance) /
                  ((ka + kb) * (ka + kb));
    p.depth = k * p.distance * p.distance / (2 * p.steepness * p.steepness);
    p.tension = a.tension > 0 ? 2 * a.tension * b.tension / (a.tension + b.tension) : 0;
    p.damping = (a.damping + b.damping) / 2;
    p.cutoff = (1 + std::sqrt(2.0)) / 2 * p.distance;
    p.breaking_strain = 0;
    double weakest = infinity;
    for (const PairPotential* own : {&a, &b})
      if (own->breaking_strain > 0)
        weakest = std::min(weakest, -pair_force(*own, (1 + own->breaking_strain) * own->distance));
    if (bonded && weakest < infinity) {
      p.breaking_strain = strain_of_force(p, weakest);
      require(p.breaking_strain > 0, "a bond of two solids bears less than {:g} N, the weaker's",
              weakest);
      p.cutoff = (1 + 2 * p.breaking_strain) * p.distance;
    }
  }
  p.embedding = {};
  p.bonds_groups = bonded;
  if (!bonded) {
    p.breaking_strain = 0;
    p.cutoff = p.distance;
  }
  return p;
}

double plane_strength(const PairPotential& p, const Lattice& lattice) {
  // Without a break: where the whole law of Morse is strongest, or a spring as long as such a law,
  // which ends before the second neighbours.
  const double longest = p.tension > 0 ? (std::sqrt(2.0) - 1) / 2 : std::log(2.0) / p.steepness;
  const double strongest = p.breaking_strain > 0 ? p.breaking_strain : longest;
  PairPotential whole = p;
  whole.breaking_strain = 0;
  whole.cutoff = infinity;
  const double force = -pair_force(whole, (1 + strongest) * p.distance);
  return plane_share * lattice.neighbours * force * lattice.distance / (6 * lattice.volume());
}

LatticeSpeeds sound_speeds(const PairPotential& potential, double mass) {
  const double unit = potential.distance * potential.distance / mass;
  const double k = stiffness_pressed(potential), c11 = unit * k;
  const Embedding& e = potential.embedding;
  // Of the bodies' own mass, which total_mass may have scaled.
  const double density = std::sqrt(2.0) * mass / std::pow(potential.distance, 3);
  const double added = e.bulk_modulus > 0 ? e.bulk_modulus / density - 2 * c11 / 3 : 0;
  return {.bulk = std::sqrt(2 * c11 / 3 + added),
          .along_100 = std::sqrt(c11 + added),
          .along_110 = std::sqrt(5 * c11 / 4 + added),
          .along_111 = std::sqrt(4 * c11 / 3 + added),
          .shear_100 = std::sqrt(unit * (k + (potential.tension > 0 ? potential.tension : k)) / 4)};
}

}  // namespace spall
