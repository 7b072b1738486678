// The normal laws without a neck: Hooke's, Hertz's, and Hertz's with the attraction of Derjaguin,
// Muller and Toporov.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "penalty/normal_force.hpp"
#include "spall/types.hpp"

namespace spall {

/// Each law has: force, energy (J) as a function of overlap, and the energies (J) that are lost as
/// a contact forms and as it parts. Its constants are those of all lanes, doubles, or lanes.
template <class Number>
struct HookeLanes : NoAdhesion {
  explicit HookeLanes(const LawConstants<Number>& law) : k(law.normal), kt(law.tangential) {}
  NormalForce force(const Lanes& overlap, const Lanes&) const {
    return {k * overlap, lanes_of(k), lanes_of(kt), Lanes{}, Lanes{}};
  }
  Lanes energy(const Lanes& overlap, const Lanes&) const { return 0.5 * k * overlap * overlap; }
  Number k, kt;
};

template <bool dmt, class Number>
struct HertzLanes : NoAdhesion {
  explicit HertzLanes(const LawConstants<Number>& law)
      : modulus(law.normal), kt(law.tangential), pull(law.attraction) {}
  static constexpr AdhesionKey key = dmt ? work_of_adhesion : AdhesionKey{};
  static constexpr bool adheres = dmt;
  static void derive(double w, LawConstants<double>& law) {
    if (dmt) law.attraction = 2 * pi * w;
  }
  NormalForce force(const Lanes& overlap, const Lanes& radius) const {
    const Lanes inverse = inverse_sqrt(radius * overlap), attraction = pull * radius;
    const Lanes a = radius * overlap * inverse;
    Lanes f = (4 / 3.0 * modulus) * a * overlap;
    if constexpr (dmt) f -= attraction;
    return {f, (2 * modulus) * a, kt * a, attraction, 0.5 * radius * inverse * inverse};
  }
  Lanes energy(const Lanes& overlap, const Lanes& radius) const {
    const Lanes hertz = (8 / 15.0 * modulus) * root_of(radius * overlap) * overlap * overlap;
    return dmt ? hertz - pull * radius * overlap : hertz;
  }
  Number modulus, kt, pull;
};
template <class Number>
using PlainHertzLanes = HertzLanes<false, Number>;
template <class Number>
using DmtLanes = HertzLanes<true, Number>;

}  // namespace spall
