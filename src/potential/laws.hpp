// The pair potentials for eight pairs at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <variant>

#include "potential/pair_potential.hpp"
#include "spall/error.hpp"
#include "spall/lanes.hpp"

namespace spall {

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
    return select(r2 < d * d, repulsion.force_over_distance(r2), pull);
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes stretch = r2 * inverse_sqrt(r2) - d;
    return select(r2 < d * d, repulsion.energy(r2) + repulsion.depth,
                  0.5 * tension * stretch * stretch);
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
    return select(r2 < first * first, law.force_over_distance(r2), slope * (last * inverse - 1.0));
  }
  Lanes energy(const Lanes& r2) const {
    const Lanes left = last - r2 * inverse_sqrt(r2);
    return select(r2 < first * first, law.energy(r2) + offset, 0.5 * slope * left * left);
  }
  Law law;
  double rest2, first, last, slope, offset;
};

/// A law of the program that uses Spall.
struct ProgramLanes {
  explicit ProgramLanes(const PairPotential& p) : law(p.program.get()) {
    require(law,
            "pair_potential.law = \"program\": a program must bring the law, by "
            "Scene::set_pair_law; `spall` itself has none");
  }
  Lanes force_over_distance(const Lanes& r2) const {
    Lanes result;
    law->force_over_distance(r2, result);
    return result;
  }
  Lanes energy(const Lanes& r2) const {
    Lanes result;
    law->energy(r2, result);
    return result;
  }
  const PairLawOfProgram* law;
};

/// Calls `f` with the lanes of the law that is asked for.
template <class F>
auto with_law(const PairPotential& p, F&& f) {
  const auto with = [&]<class Law>(const Law& law) {
    return p.breaking_strain > 0 ? f(Breaking<Law>(p)) : f(law);
  };
  switch (p.law) {
    case PairLaw::lennard_jones:
      return with(LennardJonesLanes(p));
    case PairLaw::mie:
      return with(MieLanes(p));
    case PairLaw::morse:
      return p.tension > 0 ? with(SpringBeyond<MorseLanes>(p)) : with(MorseLanes(p));
    case PairLaw::steinhauser:
      return with(SpringBeyond<LennardJonesLanes>(p));
    case PairLaw::program:
      break;
  }
  return f(ProgramLanes(p));  // its bonds do not break
}

template <class... Law>
using LawsThatMayBreak = std::variant<Law..., Breaking<Law>...>;
/// The lanes of any law.
using AnyLaw = LawsThatMayBreak<MorseLanes, SpringBeyond<MorseLanes>, LennardJonesLanes,
                                SpringBeyond<LennardJonesLanes>, MieLanes, ProgramLanes>;

}  // namespace spall
