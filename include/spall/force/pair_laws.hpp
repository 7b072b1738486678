// The pair potentials for eight pairs at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cmath>

#include "spall/force/lanes.hpp"
#include "spall/force/pair_potential.hpp"

namespace spall {

/// exp(x) to two units in the last place for |x| < 700: x = n ln 2 + f, Taylor's series of e^f.
inline Lanes exponential(const Lanes& x) {
  constexpr double shift = 0x1.8p52;  // adding it leaves the nearest integer in the lowest bits
  constexpr double log2_e = 1.4426950408889634074;
  constexpr double ln2_high = 0x1.62e42fefa38p-1, ln2_low = 0x1.ef35793c7673p-45;
  using Bits = std::int64_t __attribute__((vector_size(64)));
  const Lanes shifted = x * log2_e + shift;
  const Lanes n = shifted - shift;
  const Lanes f = (x - n * ln2_high) - n * ln2_low;
  const Lanes f2 = f * f, f4 = f2 * f2;
  const Lanes a = (1.0 + f) + f2 * (1 / 2. + f * (1 / 6.));
  const Lanes b = (1 / 24. + f * (1 / 120.)) + f2 * (1 / 720. + f * (1 / 5040.));
  const Lanes c = (1 / 40320. + f * (1 / 362880.)) +
                  f2 * (1 / 3628800. + f * (1 / 39916800.) + f2 * (1 / 479001600.));
  const Lanes series = a + f4 * (b + f4 * c);
  return std::bit_cast<Lanes>(std::bit_cast<Bits>(series) + (std::bit_cast<Bits>(shifted) << 52));
}

/// x^n, n >= 0.
inline Lanes power(Lanes x, int n) {
  Lanes result = spread(1);
  for (; n > 0; n /= 2, x *= x)
    if (n % 2 == 1) result *= x;
  return result;
}

/// Each law has the repulsive force over the distance, and the energy, of pairs r^2 apart, both
/// without regard to the cut-off.
struct LennardJonesLanes {
  explicit LennardJonesLanes(const PairPotential& p)
      : d2(p.distance * p.distance), depth(p.depth), twelve(12 * p.depth / d2) {}
  Lanes force_over_distance(const Lanes& r2) const {
    const Lanes s2 = d2 / r2, s6 = s2 * s2 * s2;
    return twelve * s2 * (s6 * s6 - s6);
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes s2 = d2 / r2, s6 = s2 * s2 * s2;
    return depth * (s6 * s6 - 2 * s6);
  }
  double d2, depth, twelve;
};

struct MieLanes {
  explicit MieLanes(const PairPotential& p)
      : d2(p.distance * p.distance),
        m(p.repulsive),
        n(p.attractive),
        energy_scale(p.depth / (m - n)),
        force_scale(energy_scale * m * n / d2) {}
  Lanes force_over_distance(const Lanes& r2) const {
    const Lanes s2 = d2 / r2, s = d * inverse_sqrt(r2), sn = power(s, n);
    return force_scale * s2 * sn * (power(s, m - n) - 1);
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes s = d * inverse_sqrt(r2);
    return energy_scale * (n * power(s, m) - m * power(s, n));
  }
  double d2, d = std::sqrt(d2);
  int m, n;
  double energy_scale, force_scale;
};

struct MorseLanes {
  explicit MorseLanes(const PairPotential& p)
      : d(p.distance), a(p.steepness / d), depth(p.depth), slope(2 * a * depth) {}
  Lanes force_over_distance(const Lanes& r2) const {
    const Lanes inverse = inverse_sqrt(r2), e = exponential(a * (d - r2 * inverse));
    return slope * inverse * (e * e - e);
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes e = exponential(a * (d - r2 * inverse_sqrt(r2)));
    return depth * (e * e - 2 * e);
  }
  double d, a, depth, slope;
};

/// `Repulsion` below the distance of rest, a spring above.
template <class Repulsion>
struct SpringBeyond {
  explicit SpringBeyond(const PairPotential& p) : repulsion(p), d(p.distance), tension(p.tension) {}
  Lanes force_over_distance(const Lanes& r2) const {
    const Lanes pull = tension * (d * inverse_sqrt(r2) - 1.0);
    return r2 < d * d ? repulsion.force_over_distance(r2) : pull;
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes stretch = r2 * inverse_sqrt(r2) - d;
    return r2 < d * d ? repulsion.energy(r2) + repulsion.depth : 0.5 * tension * stretch * stretch;
  }
  Repulsion repulsion;
  double d, tension;
};

/// `Law` up to r_1, from there the force goes to zero linearly at r_2: of bonds that hold. What is
/// not bound feels the repulsive part alone.
template <class Law>
struct Breaking {
  explicit Breaking(const PairPotential& p)
      : law(p),
        rest2(p.distance * p.distance),
        first((1 + p.breaking_strain) * p.distance),
        last((1 + 2 * p.breaking_strain) * p.distance),
        slope(law.force_over_distance(spread(first * first))[0] * first / (last - first)),
        offset(slope * (last - first) * (last - first) / 2 - law.energy(spread(first * first))[0]) {
  }
  Lanes force_over_distance(const Lanes& r2) const {
    const Lanes inverse = inverse_sqrt(r2);
    return r2 < first * first ? law.force_over_distance(r2) : slope * (last * inverse - 1.0);
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes left = last - r2 * inverse_sqrt(r2);
    return r2 < first * first ? law.energy(r2) + offset : 0.5 * slope * left * left;
  }
  Law law;
  double rest2, first, last, slope, offset;
};

/// Calls `f` with the lanes of the law that is asked for.
template <class F>
auto with_law(const PairPotential& p, F&& f) {
  const auto with = [&]<class Law>(const Law& law) {
    return p.breaking_strain > 0 ? f(Breaking<Law>(p)) : f(law);
  };
  if (p.law == PairLaw::morse)
    return p.tension > 0 ? with(SpringBeyond<MorseLanes>(p)) : with(MorseLanes(p));
  if (p.law == PairLaw::lennard_jones) return with(LennardJonesLanes(p));
  if (p.law == PairLaw::steinhauser) return with(SpringBeyond<LennardJonesLanes>(p));
  return with(MieLanes(p));
}

}  // namespace spall
