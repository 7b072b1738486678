// The embedding part against the solid that it stands for.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/embedding.hpp"

#include <cmath>

#include "pair_potentials.hpp"
#include "testing.hpp"

namespace spall {
namespace {

struct Lattice {
  double crowding = 0, pair_energy = 0;  // of a body; J
};
/// An fcc crystal of spacing s d, by the sum over a cube of it.
Lattice lattice(const PairPotential& p, double s) {
  Lattice sums;
  const double reach = crowding_reach * p.distance;
  for (int i = -5; i <= 5; ++i)
    for (int j = -5; j <= 5; ++j)
      for (int k = -5; k <= 5; ++k) {
        if ((i + j + k) % 2 != 0 || (i == 0 && j == 0 && k == 0)) continue;
        const double r = s * p.distance * Vec3(i, j, k).norm() / std::sqrt(2.0);
        if (r < reach) sums.crowding += (1 - r / reach) * (1 - r / reach);
        sums.pair_energy += pair_energy(p, r) / 2;
      }
  return sums;
}

/// Bonds between nearest neighbours only, at any compression.
const PairPotential solid = embedded;
const Embedding& part = solid.embedding;
const double cell = std::pow(solid.distance, 3) / std::sqrt(2.0);

/// Pa, of the crystal under even pressure.
double cold_pressure(const EmbeddingLaw& law, double s) {
  const auto energy = [&](double spacing) {
    const Lattice at = lattice(solid, spacing);
    return at.pair_energy + cell * law.energy(at.crowding);
  };
  const double ds = 1e-5;
  return -(energy(s + ds) - energy(s - ds)) / (2 * ds) / (3 * s * s * cell);
}

TEST(Embedding, crystal_has_the_solid_s_hugoniot) {
  const EmbeddingLaw law(solid);
  // The energy of the isentrope from rest; what the shock's is more is heat.
  double cold = 0, before = 0, at = 0;
  for (double s = 1; s > 0.80; s -= 1e-4) {
    const double x = std::pow(s, -3), eta = 1 - 1 / x, pressure = cold_pressure(law, s);
    cold += (eta - at) * (pressure + before) / 2;
    at = eta;
    before = pressure;
    if (eta < 0.01) continue;
    const double left = 1 - part.hugoniot_slope * eta;
    const double wanted = part.bulk_modulus * eta / (left * left);
    const double heat = wanted * eta / 2 - cold;  // Rankine and Hugoniot's energy
    ASSERT_NEAR(pressure + part.gruneisen * heat, wanted, 1e-3 * wanted) << s;
  }
  // In tension bonds are all that holds.
  EXPECT_EQ(law.energy(lattice(solid, 1.01).crowding), 0);
  EXPECT_EQ(law.push(lattice(solid, 1.01).crowding, 0).all, 0);
}

TEST(Embedding, push_is_the_slope_of_the_energy) {
  const EmbeddingLaw law(solid);
  for (double n = 0.05; n < 5; n += 0.0377) {
    const double dn = 1e-6, slope = (law.energy(n + dn) - law.energy(n - dn)) / (2 * dn);
    EXPECT_NEAR(law.push(n, 0).all, slope, 1e-6 * (part.bulk_modulus + slope)) << n;
  }
}

TEST(Embedding, materials_of_any_slope_have_a_table_that_ends_soundly) {
  for (double slope : {0.55, 0.77, 1.0, 1.5, 3.0}) {
    PairPotential p = solid;
    p.embedding.hugoniot_slope = slope;
    const EmbeddingLaw law(p);
    double before = 0;
    for (double n = lattice(p, 0.999).crowding; n < 20; n *= 1.01) {
      const auto [all, heat] = law.push(n, 1);
      ASSERT_TRUE(std::isfinite(all) && std::isfinite(law.energy(n))) << slope << " " << n;
      ASSERT_GT(heat, 0) << slope << " " << n;
      ASSERT_GE(all, heat) << slope << " " << n;
      ASSERT_GE(law.energy(n), before) << slope << " " << n;
      before = law.energy(n);
    }
  }
}

TEST(Embedding, heat_presses_by_gruneisen_until_cohesion_holds_it) {
  const EmbeddingLaw law(solid);
  const double heat = 6;  // J/m^3
  const auto pressure = [&](double s) {
    const double ds = 1e-4, x = std::pow(s, -3), n = lattice(solid, s).crowding;
    const double dx = std::pow(s + ds, -3) - std::pow(s - ds, -3);
    const double dn = lattice(solid, s + ds).crowding - lattice(solid, s - ds).crowding;
    return law.push(n, heat).heat * x * x * dn / dx;
  };
  for (double s : {0.82, 0.9, 0.97}) {
    const double wanted = part.gruneisen * heat;
    EXPECT_NEAR(pressure(s), wanted, 1e-3 * wanted) << s;
  }
  // Gamma Q/v = K (1 - x): until there it presses, and not beyond.
  const double s = std::cbrt(1 / (1 - part.gruneisen * heat / part.bulk_modulus));
  ASSERT_LT(s, 1.1);
  EXPECT_GT(pressure(s - 0.002), 0);
  EXPECT_EQ(pressure(s + 0.002), 0);
}

}  // namespace
}  // namespace spall
