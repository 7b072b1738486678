// One sweep over all pairs that may touch: forces, springs, and each body's motion as soon as its
// force is whole.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <bit>

#include "penalty/adhesions.hpp"
#include "penalty/laws.hpp"
#include "penalty/touch_pairs.hpp"
#include "state/contact_law.hpp"

namespace spall {

/// Vectors, or numbers, of the bodies whose rows begin at these places.
inline LaneVectors gather_body_vectors(const std::vector<Vec3>& vectors, const Index* places) {
  return gather_vectors(vectors.data()->data(), places);
}
inline Lanes gather_body_numbers(const std::vector<double>& numbers, const Index* places) {
  return gather(numbers.data(), rows_at(places));
}

/// Eight bodies as contacts see them.
struct BodyLanes {
  LaneVectors position, velocity, spin;
  Lanes radius, inverse_mass;
};

/// Springs of some lanes, the next ones of `springs`; zero in the other lanes.
inline LaneVectors load_springs(const SpringList& springs, std::size_t at, unsigned lanes) {
  return {load_packed(springs.x() + at, lanes), load_packed(springs.y() + at, lanes),
          load_packed(springs.z() + at, lanes)};
}
inline void store_springs(const LaneVectors& v, unsigned lanes, std::size_t at, SpringList& to) {
  store_packed(v.x, lanes, to.x() + at);
  store_packed(v.y, lanes, to.y() + at);
  store_packed(v.z, lanes, to.z() + at);
}

/// A law with all that a sweep asks of it at once; one for all lanes, or one for each.
template <bool rubs, bool rolls, template <class> class NormalOf, class Number>
struct ContactModel {
  using Normal = NormalOf<Number>;
  static constexpr bool frictional = rubs, rolling = rolls;
  LawConstants<Number> law;
  Normal normal;
  bool cohesive;  ///< somebody is
  double h;       ///< s

  ContactModel(const LawConstants<Number>& of, bool any_cohesion, double step)
      : law(of), normal(of), cohesive(any_cohesion), h(step) {}

  /// The model of eight pairs, whichever they are.
  template <class Pair>
  const ContactModel& of(Pair&&) const {
    return *this;
  }
  /// That of all pairs of bodies of a material.
  const ContactModel& of_material(std::int32_t) const { return *this; }

  /// Bodies touch where they overlap; where the law sticks, once they have until the neck ends.
  LaneMask touches(const Lanes& overlap, const Lanes& radius, unsigned before) const {
    LaneMask mask = overlap > 0.0;
    if constexpr (Normal::sticks)
      if (before != 0) mask |= mask_of_bits(before) & (overlap > normal.end_overlap(radius));
    return mask;
  }

  /// The force where bodies touch, attraction alone where they are within its range. `before` are
  /// the lanes that touched a step ago.
  ContactForce operator()(ContactLanes& c, const LaneMask& touching, unsigned before,
                          SpringLanes& spring) const {
    // Two bodies that never move do nothing to each other.
    const LaneMask attracts = (c.overlap > -law.cohesion_range) & (c.inverse_mass > 0.0);
    c.overlap = select(touching, c.overlap, Lanes{});
    ContactForce f = contact_force<frictional, rolling>(normal, law, c, h, spring);
    f.force = only(touching, f.force);
    f.power = select(touching, f.power, Lanes{});
    if (cohesive) {
      const Lanes pull = select(attracts & ~touching, lanes_of(-law.cohesion), Lanes{});
      f.force = f.force + pull * c.normal;
    }
    if constexpr (frictional) {
      f.lever = only(touching, f.lever);
      spring.sliding = only(touching, spring.sliding);
    }
    if constexpr (rolling) {
      f.rolling = only(touching, f.rolling);
      spring.rolling = only(touching, spring.rolling);
    }
    if constexpr (Normal::sticks) {
      // A neck forms and parts at once: what the energy jumps by is lost.
      const unsigned now = bits_of_mask(touching);
      if (now != before) {
        const Lanes formed =
            select(mask_of_bits(now & ~before), -normal.energy_at_start(c.radius), Lanes{});
        const Lanes parted =
            select(mask_of_bits(before & ~now), normal.energy_at_end(c.radius), Lanes{});
        f.power += (formed + parted) / h;
      }
    }
    return f;
  }

  /// J, elastic; attraction within its range included.
  Lanes energy(const Lanes& overlap, const Lanes& radius, unsigned before) const {
    const LaneMask touching = touches(overlap, radius, before);
    const Lanes within = overlap + law.cohesion_range;
    Lanes elastic =
        select(touching, normal.energy(select(touching, overlap, Lanes{}), radius), Lanes{});
    if constexpr (Normal::sticks) {
      // What the next force will book as lost is still there.
      const LaneMask touched = mask_of_bits(before);
      elastic -= select(touching & ~touched, normal.energy_at_start(radius), Lanes{});
      elastic += select(touched & ~touching, normal.energy_at_end(radius), Lanes{});
    }
    return elastic - select(within > 0.0, law.cohesion * within, Lanes{});
  }
};

/// Laws by pair of materials, looked up for each lane. Friction is everywhere, if only of none.
template <bool rolls, template <class> class NormalOf>
struct ContactModels {
  using Model = ContactModel<true, rolls, NormalOf, Lanes>;
  using Normal = typename Model::Normal;
  static constexpr bool frictional = true, rolling = rolls;
  const ByPair<PenaltyLaw>& laws;
  bool cohesive;
  double h;  ///< s

  /// `pair(l)`: the materials of lane l.
  template <class Pair>
  Model of(Pair&& pair) const {
    constexpr std::size_t count = sizeof(LawConstants<double>) / sizeof(double);
    using Row = std::array<double, count>;
    std::array<const LawConstants<double>*, lane_count> law;
    bool one_law = true;
    for (std::size_t l = 0; l < lane_count; ++l) {
      const auto [a, b] = pair(l);
      law[l] = &laws(a, b);
      one_law &= law[l] == law[0];
    }
    std::array<Lanes, count> lanes;
    const auto first = std::bit_cast<Row>(*law[0]);
    for (std::size_t k = 0; k < count; ++k) lanes[k] = spread(first[k]);
    for (std::size_t l = 1; l < lane_count && !one_law; ++l) {
      const auto row = std::bit_cast<Row>(*law[l]);
      for (std::size_t k = 0; k < count; ++k) lanes[k][l] = row[k];
    }
    return Model(std::bit_cast<LawConstants<Lanes>>(lanes), cohesive, h);
  }
  /// That of all pairs of bodies of a material, of one law then.
  ContactModel<true, rolls, NormalOf, double> of_material(std::int32_t material) const {
    return {laws(material, material), cohesive, h};
  }
};

/// Calls `f` with the model of the laws.
template <template <class> class NormalOf, class F>
auto with_normal_law(const ByPair<PenaltyLaw>& laws, double h, F&& f) {
  const bool friction = has_friction(laws), cohesion = has_cohesion(laws);
  const bool rolling = resists_rolling(laws);
  if (!laws.uniform()) {
    if (!rolling) return f(ContactModels<false, NormalOf>{laws, cohesion, h});
    return f(ContactModels<true, NormalOf>{laws, cohesion, h});
  }
  const PenaltyLaw& law = laws.common();
  // Grains that adhere have friction; a kernel without it would take longer to build than it saves.
  if constexpr (!NormalOf<double>::adheres)
    if (!friction) return f(ContactModel<false, false, NormalOf, double>(law, cohesion, h));
  if (!rolling) return f(ContactModel<true, false, NormalOf, double>(law, cohesion, h));
  return f(ContactModel<true, true, NormalOf, double>(law, cohesion, h));
}
template <class F>
auto with_contact_model(const ByPair<PenaltyLaw>& laws, double h, F&& f) {
  const PenaltyLaw& common = laws.common();
  if (common.model == PenaltyModel::hooke) return with_normal_law<HookeLanes>(laws, h, f);
  return with_adhesion(common.adhesion, [&]<template <class> class Law>() {
    return with_normal_law<Law>(laws, h, f);
  });
}

/// Of the bodies whose rows begin at these places.
inline auto materials_of(const Bodies& bodies, const Index* own, const Index* partners) {
  return [=, of = bodies.material.data()](std::size_t l) {
    return std::array{of[own[l] / doubles_a_row], of[partners[l] / doubles_a_row]};
  };
}

/// Asks for the bodies of the next window's pairs, a slot of them with each slot of this one: the
/// processor itself looks ahead only a few slots, far less than memory takes to answer.
class BodiesAhead {
 public:
  BodiesAhead(const NearWindow& next, const Bodies& bodies, const ForceRow* rows)
      : at_(next.partners.data()),
        end_(at_ + next.partners.size()),
        position_(bodies.position.data()),
        velocity_(bodies.velocity.data()),
        spin_(bodies.angular_velocity.data()),
        rows_(rows) {}
  void ask_for_slot() {
    if (at_ == end_) return;
    for (std::size_t l = 0; l < lane_count; ++l) {
      const Index row = at_[l] / doubles_a_row;
      __builtin_prefetch(position_ + row);
      __builtin_prefetch(velocity_ + row);
      __builtin_prefetch(spin_ + row);
      __builtin_prefetch(rows_ + row, 1);
    }
    at_ += lane_count;
  }

 private:
  const Index* at_;
  const Index* end_;
  const Vec3* position_;
  const Vec3* velocity_;
  const Vec3* spin_;
  const ForceRow* rows_;
};

/// Pairs of a window that are as near as to act on each other, or touched a step ago, one after
/// another: most of those that are listed are not, and contacts so fill their lanes.
struct ActingPairs {
  std::vector<Index> own, partners;  ///< where their rows begin
  std::vector<Index> place;          ///< 8 slot + lane
  std::size_t count = 0;
  SpringList sliding, rolling;  ///< of those that touch now
  double deepest = 0;           ///< largest overlap so far, over the smaller radius

  void begin(std::size_t most, bool rolls) {
    count = 0;
    for (std::vector<Index>* of : {&own, &partners, &place})
      if (of->size() < most + lane_count) of->resize(most + lane_count);
    sliding.make_room(most);
    if (rolls) rolling.make_room(most);
  }
  void add(const Index* own_rows, const Index* partner_rows, std::size_t slot, unsigned lanes) {
    constexpr IndexLanes numbers = {0, 1, 2, 3, 4, 5, 6, 7};
    store_packed(load(own_rows), lanes, &own[count]);
    store_packed(load(partner_rows), lanes, &partners[count]);
    count += store_packed(numbers + static_cast<Index>(slot * lane_count), lanes, &place[count]);
  }
  /// The lanes that are left over are pairs of a body with itself.
  void close() {
    for (std::size_t k = count; k % lane_count != 0; ++k) {
      own[k] = partners[k] = own[0];
      place[k] = place[0];
    }
  }
};

/// Adds the forces of a window's pairs to the rows and steps their springs; `gap` (m) is the widest
/// at which bodies act on each other. `equal`: its bodies and their partners have the size and mass
/// of the first, which is then read once. A function of its own: laws of all pairs and those by
/// pair of materials share it.
template <bool equal, class Model>
[[gnu::noinline, gnu::flatten]] void sweep_window(const Bodies& bodies, const Model& model,
                                                  double gap, const NearWindow& window,
                                                  const NearWindow& next, ActingPairs& acting,
                                                  WindowSprings& kept, ForceRow* rows) {
  double* const forces = reinterpret_cast<double*>(rows);
  const Index first = window.rows[0] / doubles_a_row;
  const Lanes equal_radius = spread(bodies.radius[first]);
  const Lanes equal_inverse_mass = spread(1 / bodies.mass[first]);
  const auto radius = [&](const Index* at) -> Lanes {
    return equal ? equal_radius : gather_body_numbers(bodies.radius, at);
  };
  const auto inverse_mass = [&](const Index* at) -> Lanes {
    return equal ? equal_inverse_mass : 1.0 / gather_body_numbers(bodies.mass, at);
  };
  // A row that is its own partner, in a slot that it does not need, is at distance 0.
  const auto is_near = [&](const Lanes& r2, const Lanes& radii) -> LaneMask {
    const Lanes reach = radii + gap;
    return (r2 < reach * reach) & (r2 > 0.0);
  };

  acting.begin(window.partners.size(), Model::rolling);
  BodiesAhead ahead(next, bodies, rows);
  const Index* partners = window.partners.data();
  std::size_t slot = 0;
  for (std::size_t g = 0; g < window.slots.size(); ++g) {
    if (window.slots[g] == 0) continue;
    const Index* own = window.rows.data() + g * lane_count;
    const LaneVectors xi = gather_body_vectors(bodies.position, own);
    const Lanes ri = radius(own);
    for (Index s = 0; s < window.slots[g]; ++s, ++slot, partners += lane_count) {
      ahead.ask_for_slot();
      const LaneVectors apart = gather_body_vectors(bodies.position, partners) - xi;
      const unsigned lanes = bits_of_mask(is_near(dot(apart, apart), ri + radius(partners))) |
                             unsigned{kept.touching[slot]};
      if (lanes != 0) acting.add(own, partners, slot, lanes);
    }
  }
  acting.close();

  std::size_t springs = 0, touch = 0;  // before and now
  for (std::size_t k = 0; k < acting.count; k += lane_count) {
    const Index *own = &acting.own[k], *other = &acting.partners[k];
    const LaneVectors apart =
        gather_body_vectors(bodies.position, other) - gather_body_vectors(bodies.position, own);
    const Lanes ri = radius(own), rj = radius(other);
    const Lanes r2 = dot(apart, apart), radii = ri + rj;
    const unsigned before = touched(kept, &acting.place[k], acting.count - k);
    ContactLanes c;
    const Lanes inverse = inverse_sqrt(r2), distance = r2 * inverse;
    const Lanes inverse_radii = 1.0 / radii;
    c.normal = inverse * apart;
    c.overlap = select(is_near(r2, radii), radii - distance, spread(-infinity));
    c.radius = ri * rj * inverse_radii;
    c.inverse_mass = inverse_mass(own) + inverse_mass(other);
    c.kappa = distance * inverse_radii;
    c.velocity =
        gather_body_vectors(bodies.velocity, other) - gather_body_vectors(bodies.velocity, own);
    SpringLanes spring;
    if constexpr (Model::frictional) {
      const LaneVectors spin_i = gather_body_vectors(bodies.angular_velocity, own);
      const LaneVectors spin_j = gather_body_vectors(bodies.angular_velocity, other);
      c.surface = ri * spin_i + rj * spin_j;
      c.twist = 0.5 * dot(spin_i + spin_j, c.normal);
      spring.sliding = load_springs(kept.sliding, springs, before);
      if constexpr (Model::rolling) {
        c.rolling = spin_j - spin_i;
        spring.rolling = load_springs(kept.rolling, springs, before);
      }
    }
    // Two bodies that never move do nothing to each other.
    const auto& law = model.of(materials_of(bodies, own, other));
    const LaneMask touching = law.touches(c.overlap, c.radius, before) & (c.inverse_mass > 0.0);
    const ContactForce f = law(c, touching, before, spring);
    const unsigned now = bits_of_mask(touching);
    const Lanes smaller = select(ri < rj, ri, rj);
    if (any_lane(touching & (c.overlap > acting.deepest * smaller)))
      for (std::size_t l = 0; l < lane_count; ++l)
        if (touching[l]) acting.deepest = std::max(acting.deepest, c.overlap[l] / smaller[l]);
    if (now != before) toggle_touched(now ^ before, &acting.place[k], kept);
    add_lanes(f.force, 0.5 * f.power, other, forces);
    add_lanes(spread(-1) * f.force, 0.5 * f.power, own, forces);
    if constexpr (Model::frictional) {
      store_springs(spring.sliding, now, touch, acting.sliding);
      LaneVectors on_j = rj * f.lever, on_i = ri * f.lever;
      if constexpr (Model::rolling) {
        store_springs(spring.rolling, now, touch, acting.rolling);
        on_j = on_j + f.rolling;
        on_i = on_i - f.rolling;
      }
      add_lanes(on_j, Lanes{}, other, forces + 4);
      add_lanes(on_i, Lanes{}, own, forces + 4);
    }
    springs += std::popcount(before);
    touch += std::popcount(now);
  }
  if constexpr (Model::frictional)
    kept.sliding.take(acting.sliding, touch);
  else
    kept.sliding.fill(touch, [](std::size_t) -> Vec3 { return Vec3::Zero(); });
  if constexpr (Model::rolling) kept.rolling.take(acting.rolling, touch);
}

/// The same for all windows; calls `finish(body)` for each body of a window once nothing will be
/// added to its row and none of its fields will be asked for again. The forces of ghosts mean
/// nothing. `equal`: of each window, whether its bodies and their partners have one size, mass and
/// material. Returns the largest overlap over the smaller radius.
template <class Model, class Finish>
double sweep_contacts(const Bodies& bodies, const Model& model, double gap,
                      const std::vector<NearWindow>& windows,
                      const std::vector<std::uint8_t>& equal, std::vector<WindowSprings>& springs,
                      ForceRow* rows, Finish&& finish) {
  ActingPairs acting;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const NearWindow& window = windows[w];
    const NearWindow& next = windows[std::min(w + 1, windows.size() - 1)];
    if (equal[w])
      sweep_window<true>(bodies, model.of_material(bodies.material[window.rows[0] / doubles_a_row]),
                         gap, window, next, acting, springs[w], rows);
    else
      sweep_window<false>(bodies, model, gap, window, next, acting, springs[w], rows);
    for (Index r = 0; r < window.count; ++r) {
      const Index row = next.rows[r % next.count] / doubles_a_row;
      __builtin_prefetch(bodies.position.data() + row);
      __builtin_prefetch(bodies.velocity.data() + row);
      __builtin_prefetch(bodies.angular_velocity.data() + row);
      __builtin_prefetch(rows + row, 1);
      finish(window.rows[r] / doubles_a_row);
    }
  }
  return acting.deepest;
}

/// J, elastic, of all pairs; those with a ghost count half, as both ranks have them. Two bodies
/// that never move hold nothing.
template <class Model>
double sweep_contact_energy(const Bodies& bodies, const Model& model, double gap,
                            const std::vector<NearWindow>& windows,
                            const std::vector<WindowSprings>& springs) {
  double energy = 0;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const NearWindow& window = windows[w];
    const Index* partners = window.partners.data();
    std::size_t slot = 0;
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * lane_count;
      const LaneVectors xi = gather_body_vectors(bodies.position, own);
      const Lanes ri = gather_body_numbers(bodies.radius, own);
      for (Index s = 0; s < window.slots[g]; ++s, ++slot, partners += lane_count) {
        const LaneVectors apart = gather_body_vectors(bodies.position, partners) - xi;
        const Lanes rj = gather_body_numbers(bodies.radius, partners);
        const Lanes r2 = dot(apart, apart), radii = ri + rj, reach = radii + gap;
        const LaneMask near = (r2 < reach * reach) & (r2 > 0.0);
        if (!any_lane(near)) continue;
        Lanes share;
        for (std::size_t l = 0; l < lane_count; ++l) {
          const Index i = own[l] / doubles_a_row, j = partners[l] / doubles_a_row;
          const bool held = bodies.mass[i] == infinity && bodies.mass[j] == infinity;
          share[l] = held ? 0 : j < bodies.owned ? 1 : 0.5;
        }
        const Lanes u = model.of(materials_of(bodies, own, partners))
                            .energy(select(near, radii - root_of(r2), spread(-gap)),
                                    ri * rj / radii, springs[w].touching[slot]);
        energy += sum_of_lanes(select(near, share * u, Lanes{}));
      }
    }
  }
  return energy;
}

}  // namespace spall
