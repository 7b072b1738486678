// The pressure of some bodies at the end of a step: cold curve, heat, pores, voids.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "solid/lane_bodies.hpp"
#include "solid/lane_root.hpp"
#include "spall/bodies.hpp"

namespace spall {

/// How dense matter between voids may be, of what it is without them or at rest; the error (of the
/// bulk modulus) at which the search for it ends.
inline constexpr double most_matter = 2, tension_error = 1e-12;
/// Of the pressure at which no pores are left.
inline constexpr double crushing_error = 1e-9;

/// Some bodies between their trial and their final state. The trial stress of rock is that of what
/// is intact.
struct Group {
  LaneRows rows;
  LaneLaws laws;
  double h;
  double late;  ///< s, over which new stresses have worked
  PairLanes compression, volume, rest_volume;
  PairLanes stiffness;    ///< of their shear moduli at rest
  PairLanes mises;        ///< Pa, of the trial stress
  PairLanes around;       ///< Pa, mean of a body's pressure and that of its neighbours, before
  PairLanes sliding;      ///< Pa, von Mises' stress on cracks if they did not slide, at most
  PairLanes intact;       ///< the old stress of what is intact, of the body's
  PairLanes gained;       ///< J, by the power of old stresses
  PairLanes growth;       ///< tr L, 1/s
  PairLanes shear_power;  ///< s : L, W/m^3, of the trial stress
};

/// Matter of some bodies, which fills their volume but for pores and voids, at the end of a step.
/// Of their trial deviator the share `scale` is left, with the energy `sheared` (J).
struct Matter {
  const Group& group;
  PairLanes gruneisen, bulk, filled;  ///< as of a `SolidLaw`
  PairLanes x;                        ///< the density it has where it fills all, of that at rest
  PairLanes rest_volume;              ///< m^3
  PairLanes before, sheared;          ///< J: all but the work of its pressure; of shear
  PairLanes works;                    ///< m^3, over which the pressure works
  // At the density that `pressure_at` was asked for last:
  ColdCurve::State<PairLanes> cold;
  PairLanes pressure;  ///< Pa
  PairLanes per_heat;  ///< Pa/J
  PairLanes given;     ///< J, heat but for the work of the pressure

  Matter(const Bodies& bodies, const Group& g, const PairLanes& scale, const PairLanes& of_shear)
      : group(g),
        gruneisen(g.laws.of(&SolidLaw::gruneisen)),
        bulk(g.laws.of(&SolidLaw::bulk)),
        filled(g.laws.of(&SolidLaw::filled)),
        sheared(of_shear) {
    x = g.compression * filled;
    rest_volume = g.rest_volume * filled;
    const PairLanes acts = g.late * g.volume;
    works = acts * g.growth;
    before = g.rows.load(bodies.internal_energy) + g.gained + acts * scale * g.shear_power;
  }

  /// Pa, of bodies in which it has this density, of that at rest: P_c + Gamma rho Q, the share of
  /// it; Q depends on the work of P.
  PairLanes pressure_at(const PairLanes& at) {
    group.laws.for_each([&](const SolidLaw& law, const PairMask& own) {
      const auto of = law.cold.at(at);
      cold.pressure = select(own, of.pressure, cold.pressure);
      cold.energy = select(own, of.energy, cold.energy);
      cold.slope2 = select(own, of.slope2, cold.slope2);
      cold.by_eta = select(own, of.by_eta, cold.by_eta);
    });
    const PairLanes share = x / at;
    per_heat = share * gruneisen / rest_volume * smaller(spread_pairs(1), at);
    given = before - rest_volume * cold.energy - sheared;
    pressure = (share * cold.pressure + per_heat * given) / (1.0 + per_heat * works);
    return pressure;
  }

  /// Pa, dP/d(density) at the density that `pressure_at` was asked for last.
  PairLanes slope_at(const PairLanes& at) const {
    const PairLanes share = x / at;
    const PairLanes thinned = select(at > 1.0, per_heat / at, PairLanes{});
    return (share / at * (cold.by_eta / at - cold.pressure) - thinned * (given - pressure * works) -
            per_heat * rest_volume * cold.pressure / (at * at)) /
           (1.0 + per_heat * works);
  }
};

inline bool has_pores(const SolidLaw& law) {
  return law.pores.any();
}

/// The pores of some bodies.
struct PoreLanes {
  PairLanes distension, elastic, compacted;  ///< as in `Pores`

  explicit PoreLanes(const LaneLaws& laws)
      : distension(laws.of([](const SolidLaw& law) { return law.pores.distension; })),
        elastic(laws.of([](const SolidLaw& law) { return law.pores.elastic; })),
        compacted(laws.of([](const SolidLaw& law) { return law.pores.compacted; })) {}
  /// alpha, where they have been crushed so far.
  PairLanes alpha(const PairLanes& crushed) const { return distension_of(distension, crushed); }
  /// Pa, that crushes them further.
  PairLanes crushing_pressure(const PairLanes& crushed) const {
    return elastic + crushed * (compacted - elastic);
  }
  /// How far those that are asked for are crushed once what is left of them bears the pressure.
  PairLanes crushed_by(const PairMask& asked, const PairLanes& crushed, Matter& matter) const {
    const PairLanes all = spread_pairs(1);
    const PairMask partly = asked & (matter.pressure_at(matter.x) < compacted);
    const PairLanes found = root_within(
        partly, crushed, all, crushed, crushing_error * compacted,
        // Pressure falls, as pores close, and what crushes them grows.
        [&](const PairLanes& at) {
          return crushing_pressure(at) - matter.pressure_at(matter.x * alpha(at));
        },
        [&](const PairLanes& at) {
          const PairLanes stiffness = matter.bulk * distension / (alpha(at) * alpha(at));
          return 2.0 * stiffness * (distension - 1.0) * (1.0 - at) + compacted - elastic;
        });
    return select(asked, select(partly, found, all), crushed);
  }
};

/// The damage of rock whose pores have been crushed: D^(1/3) grows by that of the share of pores
/// that are closed (Jutzi, Benz & Michel, Icarus 198 (2008) 242).
inline double crushed_damage(const SolidLaw& law, double damage, double before, double after) {
  const auto closed = [&](double crushed) {
    return std::cbrt(1 - (law.distension(crushed) - 1) / (law.pores.distension - 1));
  };
  const double grown = std::cbrt(damage) + closed(after) - closed(before);
  return std::min(1.0, grown * grown * grown);
}

/// Pressure and energy of some bodies at the end of a step.
struct Pressed {
  PairLanes pressure{};
  PairLanes energy{}, heat{};  ///< J
  PairLanes sound_speed2{};    ///< (m/s)^2, of the bulk
  PairLanes damage{}, crushed{};
};

/// Crushes pores where `after` has more pressure than they bear. Returns the density of matter, of
/// that at rest, without voids.
inline PairLanes crush(const Bodies& bodies, Matter& matter, Pressed& after) {
  const Group& g = matter.group;
  if (!g.laws.any(has_pores)) return matter.x;
  const PoreLanes pores(g.laws);
  const PairLanes crushed = g.rows.load(bodies.crushed), crushes = g.laws.of(&SolidLaw::yields);
  const PairLanes open = matter.x * pores.alpha(crushed);
  const PairMask asked = (crushes > 0.0) & (open > matter.x) &
                         (matter.pressure_at(open) > pores.crushing_pressure(crushed));
  after.crushed = any_lane(asked) ? pores.crushed_by(asked, crushed, matter) : crushed;
  for (std::size_t l = 0; l < pair_lanes; ++l)
    if (g.laws[l].brittle() && after.crushed[l] > crushed[l])
      after.damage[l] = crushed_damage(g.laws[l], after.damage[l], crushed[l], after.crushed[l]);
  return matter.x * pores.alpha(after.crushed);
}

/// Opens voids in bodies that are asked for until they are pulled no more than is `bearable` (Pa).
/// `least`: the density of matter, of that at rest, without them.
inline void open_voids(const PairMask& asked, const PairMask& melted, const PairLanes& bearable,
                       const PairLanes& least, Matter& matter, Pressed& after) {
  const Group& g = matter.group;
  const PairLanes one = spread_pairs(1);
  const PairLanes whole_pressure = after.pressure, whole_energy = matter.cold.energy;
  // Matter between voids is less stretched: cold it is hardly so, hot it bears pressure before.
  // Where it is found if the cold curve is straight:
  const PairLanes heated = matter.gruneisen * (matter.before - matter.sheared) / matter.rest_volume;
  const PairLanes from = one - (heated + bearable / matter.x) * matter.filled / matter.bulk;
  const PairLanes density = root_within(
      asked, least, most_matter * larger(one, least), select(asked & (from > least), from, least),
      tension_error * matter.bulk,
      [&](const PairLanes& at) { return matter.pressure_at(at) + bearable; },
      [&](const PairLanes& at) { return matter.slope_at(at); });
  after.pressure = matter.pressure_at(density);
  const std::uint8_t lanes = bits_of_mask(asked), molten = bits_of_mask(melted);
  PairLanes opened = one;  // the share of a body that voids or cracks run through
  for (std::size_t l = 0; l < pair_lanes; ++l) {
    if (!(lanes >> l & 1)) continue;
    const SolidLaw& law = g.laws[l];
    const double damage = molten >> l & 1 ? 1 : std::min(1.0, after.damage[l]);
    after.damage[l] = damage;
    if (law.brittle()) {
      opened[l] = damage;
    } else if (law.yields && damage < 1) {
      const double voids = 1 - least[l] / density[l];
      after.damage[l] = std::clamp(voids / law.most_voids(g.rest_volume[l]), damage, 1.0);
    }
  }
  // The rest is stretched as if there were none.
  const PairMask partly = opened < 1.0;
  after.pressure =
      select(partly, opened * after.pressure + (1.0 - opened) * whole_pressure, after.pressure);
  matter.cold.energy = select(partly, opened * matter.cold.energy + (1.0 - opened) * whole_energy,
                              matter.cold.energy);
}

/// Of bodies of whose trial deviator the share `scale` is left, with the energy `sheared` (J).
inline Pressed pressed(const Bodies& bodies, const Group& g, const PairLanes& scale,
                       const PairLanes& sheared, const PairMask& melted) {
  const PairLanes none{};
  Matter matter(bodies, g, scale, sheared);
  Pressed after;
  const PairLanes strength = g.laws.of(&SolidLaw::strength);
  after.damage = g.rows.load(bodies.damage);
  const PairLanes cracks = after.damage * g.laws.of(&SolidLaw::brittle);
  const PairMask parted = (after.damage >= 1.0) | melted | (cracks > 0.0);
  // A body alone may be pulled more than its neighbours: the noise of pressure opens no voids.
  const PairLanes alone = larger(none, g.around - g.rows.load(bodies.pressure));
  const PairLanes bearable = select(parted, none, (1.0 - after.damage) * strength + alone);
  const PairLanes least = crush(bodies, matter, after);
  after.pressure = matter.pressure_at(least);
  const PairMask pulled = after.pressure < -bearable;
  if (any_lane(pulled)) open_voids(pulled, melted, bearable, least, matter, after);
  after.energy = matter.before - matter.works * after.pressure;
  after.heat = after.energy - matter.rest_volume * matter.cold.energy - sheared;
  after.sound_speed2 = matter.cold.slope2;
  return after;
}

}  // namespace spall
