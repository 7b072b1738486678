// Central pair potentials: what a case asks for, their formulas, and the limits that they set.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>

#include "spall/pair_law.hpp"
#include "spall/types.hpp"

namespace spall {

/// program: of the program that uses Spall.
enum class PairLaw { lennard_jones, mie, morse, steinhauser, program };

/// What a solid's pressure is that its pairs alone do not give (potential/embedding.hpp).
struct Embedding {
  double bulk_modulus = 0;    ///< Pa, K, with the pairs' share; 0: pairs are all there is
  double hugoniot_slope = 0;  ///< s
  double gruneisen = 0;       ///< Gamma
  double density = 0;         ///< kg/m^3, of the solid at rest

  bool operator==(const Embedding&) const = default;
};

/// A potential U(r) with its minimum -depth at r = distance, with d = distance, D = depth:
///
///   Mie:   U = D/(m - n) [n (d/r)^m - m (d/r)^n]; m, n = 12, 6 for Lennard-Jones, whose
///          sigma is d/2^(1/6)
///   Morse: U = D [(1 - e)^2 - 1],  e = exp(-s (r/d - 1)); with a tension k: D (1 - e)^2 below d,
///          k/2 (r - d)^2 above
///   Steinhauser: U = D [(d/r)^12 - 2 (d/r)^6 + 1] below d, k/2 (r - d)^2 above, no force beyond
///          the cut-off (Steinhauser, Grass, Strassburger & Blumen, Int. J. Plasticity 25 (2009)
///          161: D = gamma R0^3, k = 2 lambda R0, cut-off alpha d)
///
/// cut at `cutoff`, from where U is counted; the force is not shifted. With a `breaking_strain` eps
/// the force beyond r_1 = (1 + eps) d goes to zero linearly at r_2 = (1 + 2 eps) d, the cut-off of
/// such a law: the bond breaks. Pairs nearer than d may be damped by a force -c u_n.
struct PairPotential {
  PairLaw law = PairLaw::lennard_jones;
  double depth = 0;            ///< J
  double distance = 0;         ///< m
  int repulsive = 12;          ///< m of Mie
  int attractive = 6;          ///< n of Mie
  double steepness = 0;        ///< s of Morse, often written a d
  double tension = 0;          ///< N/m, k of Steinhauser, and of Morse where not 0
  double cutoff = 0;           ///< m
  double breaking_strain = 0;  ///< eps; 0: no break
  double damping = 0;          ///< of critical: c = damping * 2 sqrt(k m/2), m the lightest body's
  bool bonds_groups = false;   ///< bonds that break are made between groups too, not in one alone
  Embedding embedding{};
  std::shared_ptr<const PairLawOfProgram> program{};  ///< of PairLaw::program

  /// Whether there is a law at all.
  bool given() const { return depth > 0 || law == PairLaw::program; }
  /// Whether it pulls: one that ends at the distance of rest only repels.
  bool attracts() const { return cutoff > distance; }
  bool operator==(const PairPotential&) const = default;
};

/// N/m at the distance of rest, below it: Mie m n D/d^2, Morse 2 D (s/d)^2.
double stiffness_pressed(const PairPotential& potential);
/// N/m, of the stiffer side.
double stiffness(const PairPotential& potential);

/// N, of the repulsion -dU/dr, and J; the damping apart.
double pair_force(const PairPotential& potential, double r);
double pair_energy(const PairPotential& potential, double r);

/// The strain at which the law without a break first pulls with `force` (N), or has stored `energy`
/// (J); 0 where it never does up to a strain of 1.
double strain_of_force(const PairPotential& potential, double force);
double strain_of_energy(const PairPotential& potential, double energy);

/// s, of steps for bodies of `mass` (kg, the lightest).
double longest_step(const PairPotential& potential, double mass);

/// Of two bodies, whichever a law acts between.
struct Encounter {
  double lightest;  ///< kg, a body's
  double reduced;   ///< kg, most of two: m_a m_b / (m_a + m_b)
  double speed;     ///< m/s, at which they meet at most
};

/// Throws Error, which tells the step that would do, where `h` (s) is too long for bodies that meet
/// so, or where they would pass through each other.
void check_step(const PairPotential& potential, double h, const Encounter& encounter,
                const std::string& place);

}  // namespace spall
