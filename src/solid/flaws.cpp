// Flaws are counted, not stored: bodies in tension draw theirs again in each step.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/flaws.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "base/hash.hpp"

namespace spall {
namespace {

constexpr double most_counted = 64;
/// Splitmix64's step: `mix` scatters its multiples.
constexpr std::uint64_t golden = 0x9E3779B97F4A7C15u;

/// In (0, 1].
double uniform(std::uint64_t bits) {
  return static_cast<double>((bits >> 11) + 1) * 0x1p-53;
}

/// Pa, where these times the body's deviator and pressure are borne; 0 where there is no tension.
double largest_tension(const Bodies& bodies, Index row, double of_deviator, double of_pressure) {
  const Vec3 direct = of_deviator * bodies.direct_stress[row],
             shear = of_deviator * bodies.shear_stress[row];
  const double pressure = of_pressure * bodies.pressure[row];
  // No principal value of a deviator s is larger than sqrt(2/3) |s|.
  const double bound = std::sqrt(2.0 / 3 * (direct.squaredNorm() + 2 * shear.squaredNorm()));
  if (bound <= pressure) return 0;
  Eigen::Matrix3d s;
  s << direct[0], shear[2], shear[1], shear[2], direct[1], shear[0], shear[1], shear[0], direct[2];
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> of;
  of.computeDirect(s, Eigen::EigenvaluesOnly);
  return std::max(0.0, of.eigenvalues()[2] - pressure);
}

}  // namespace

double crack_speed(const SolidLaw& law) {
  return 0.4 * law.sound_speed();
}

double open_flaws(const SolidLaw& law, BodyId body, double volume, double strain) {
  const double expected = law.flaws.k * volume * std::pow(strain, law.flaws.m);
  if (expected > most_counted) return expected;
  std::uint64_t stream = mix(mix((law.seed + 1) * golden) + static_cast<std::uint64_t>(body));
  int opened = 0;
  for (double sum = 0; (sum -= std::log(uniform(mix(stream += golden)))) <= expected;) ++opened;
  return opened;
}

double strain_of_first_flaw(const SolidLaw& law, double spacing) {
  const double volume = volume_of_lattice(spacing);
  return std::pow(std::log(2.0) / (law.flaws.k * volume), 1 / law.flaws.m);
}

double grown_damage(const SolidLaw& law, const Bodies& bodies, Index row, double volume,
                    double intact, double h) {
  const double damage = bodies.damage[row];
  if (damage >= 1) return damage;
  const double pulled = bodies.pressure[row] < 0 ? 1 / (1 - damage) : 1;
  const double tension = largest_tension(bodies, row, intact, pulled);
  if (tension == 0) return damage;
  const double opened = open_flaws(law, bodies.id[row], volume, tension / law.youngs_modulus());
  if (opened == 0) return damage;
  const double radius = std::cbrt(3 * volume / (4 * pi));
  const double grown = std::cbrt(damage) + std::cbrt(opened) * crack_speed(law) * h / radius;
  return std::min(1.0, grown * grown * grown);
}

}  // namespace spall
