// A potential of each law, and what the textbooks say of its force.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "potential/pair_potential.hpp"

namespace spall {

inline const PairPotential lennard_jones{.depth = 0.7, .distance = 1.1, .cutoff = 1.75};
inline const PairPotential mie{.law = PairLaw::mie,
                               .depth = 0.7,
                               .distance = 1.1,
                               .repulsive = 9,
                               .attractive = 5,
                               .cutoff = 1.75};
inline const PairPotential morse{
    .law = PairLaw::morse, .depth = 0.7, .distance = 1.1, .steepness = 3.36, .cutoff = 1.75};
inline const PairPotential steinhauser{
    .law = PairLaw::steinhauser, .depth = 0.7, .distance = 1.1, .tension = 30, .cutoff = 1.3};
inline const PairPotential breaking{.law = PairLaw::morse,
                                    .depth = 0.7,
                                    .distance = 1.1,
                                    .steepness = 3.36,
                                    .cutoff = 1.1 * 1.1,
                                    .breaking_strain = 0.05};
inline const PairPotential sprung = [] {
  PairPotential p = morse;
  p.tension = 30;
  return p;
}();
inline const PairPotential embedded = [] {
  PairPotential p = breaking;
  p.tension = 30;
  p.embedding = {.bulk_modulus = 40, .hugoniot_slope = 1.3, .gruneisen = 1.2, .density = 1.1};
  return p;
}();
/// Bonds of any length, with the same embedding.
inline const PairPotential crowded = [] {
  PairPotential p = morse;
  p.embedding = embedded.embedding;
  return p;
}();

/// N, as written in the textbooks.
inline double textbook_force(const PairPotential& p, double r) {
  const double d = p.distance, eps = p.breaking_strain;
  if (r >= p.cutoff) return 0;
  if (eps > 0 && r > (1 + eps) * d) {
    PairPotential whole = p;
    whole.breaking_strain = 0;
    return textbook_force(whole, (1 + eps) * d) * ((1 + 2 * eps) * d - r) / (eps * d);
  }
  if (p.tension > 0 && r > d) return -p.tension * (r - d);
  if (p.law == PairLaw::morse) {
    const double e = std::exp(-p.steepness * (r / d - 1));
    return 2 * p.depth * p.steepness / d * e * (e - 1);
  }
  const double m = p.repulsive, n = p.attractive;
  return p.depth * m * n / (m - n) / r * (std::pow(d / r, m) - std::pow(d / r, n));
}

}  // namespace spall
