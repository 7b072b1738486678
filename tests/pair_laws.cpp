// The laws of pair potentials against the textbooks and against each other.
// SPDX-License-Identifier: BSD-3-Clause
#include "pair_potentials.hpp"
#include "testing.hpp"

namespace spall {
namespace {

TEST(PairPotential, force_is_the_textbook_s_and_minus_the_slope_of_the_energy) {
  for (const PairPotential& p : {lennard_jones, mie, morse, breaking}) {
    for (double r = 0.7 * p.distance; r < p.cutoff; r += 0.0137) {
      const double scale = stiffness(p) * p.distance;
      EXPECT_NEAR(pair_force(p, r), textbook_force(p, r),
                  1e-14 * (scale + std::abs(textbook_force(p, r))))
          << r;
      // The slope over 2 dr: its error is dr^2 of the third derivative and round-off over dr.
      const double dr = 1e-5;
      const double slope = (pair_energy(p, r + dr) - pair_energy(p, r - dr)) / (2 * dr);
      if (r + dr < p.cutoff) {
        EXPECT_NEAR(pair_force(p, r), -slope, 1e-6 * (scale + std::abs(slope))) << r;
      }
    }
    EXPECT_NEAR(pair_force(p, p.distance), 0, 1e-14 * stiffness(p) * p.distance);
    const double dr = 1e-5 * p.distance;
    EXPECT_NEAR((pair_force(p, p.distance - dr) - pair_force(p, p.distance + dr)) / (2 * dr),
                stiffness(p), 1e-6 * stiffness(p));
    EXPECT_EQ(pair_force(p, p.cutoff), 0);
    EXPECT_NEAR(pair_energy(p, p.cutoff * (1 - 1e-12)), 0, 1e-10 * p.depth);
  }
  // To the bottom of the well from a cut-off where nothing is left of it.
  PairPotential wide = lennard_jones;
  wide.cutoff = 1000;
  EXPECT_NEAR(pair_energy(wide, wide.distance), -wide.depth, 1e-14 * wide.depth);
}

TEST(PairPotential, steinhauser_joins_its_pieces_without_a_jump_and_repels_like_lennard_jones) {
  const PairPotential& p = steinhauser;
  const double d = p.distance, at_end = p.tension / 2 * (p.cutoff - d) * (p.cutoff - d);
  EXPECT_NEAR(pair_energy(p, d), -at_end, 1e-14);
  EXPECT_NEAR(pair_energy(p, 1.05 * d), p.tension / 2 * 0.0025 * d * d - at_end, 1e-14);
  PairPotential lj = p;
  lj.law = PairLaw::lennard_jones;
  for (double r : {0.8, 0.9, 0.99}) {
    EXPECT_EQ(pair_force(p, r * d), pair_force(lj, r * d)) << r;
    EXPECT_NEAR(pair_energy(p, r * d) + at_end, pair_energy(lj, r * d) - pair_energy(lj, d), 1e-13);
  }
  EXPECT_EQ(stiffness(p), 72 * p.depth / (d * d));
}

TEST(PairPotential, bonds_that_break_at_a_force_or_an_energy_break_at_its_strain) {
  for (PairPotential p : {lennard_jones, mie, morse, steinhauser}) {
    p.cutoff = 10;
    const double force = 0.02 * stiffness(p) * p.distance, strain = strain_of_force(p, force);
    EXPECT_NEAR(-textbook_force(p, (1 + strain) * p.distance), force, 1e-12 * force);
    const double stored = 0.1 * p.depth, at = strain_of_energy(p, stored);
    EXPECT_NEAR(pair_energy(p, (1 + at) * p.distance) - pair_energy(p, p.distance), stored,
                1e-12 * p.depth);
    p.breaking_strain = strain;
    EXPECT_GT(-pair_force(p, (1 + 0.99 * strain) * p.distance), 0.9 * force);
    EXPECT_LT(-pair_force(p, (1 + 1.99 * strain) * p.distance), 0.02 * force);
  }
  // More than the law ever pulls: Morse s D/(2 d).
  EXPECT_EQ(strain_of_force(morse, 1.01 * 3.36 * morse.depth / (2 * morse.distance)), 0);
  EXPECT_GT(strain_of_force(morse, 0.99 * 3.36 * morse.depth / (2 * morse.distance)), 0);
  EXPECT_EQ(strain_of_energy(morse, 1.01 * morse.depth), 0);
}

}  // namespace
}  // namespace spall
