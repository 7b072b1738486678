// What acts between the eight pairs of a slot: the same for all pairs, or by their materials.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <bit>
#include <vector>

#include "pairs/near_pairs.hpp"
#include "potential/embedding.hpp"
#include "potential/laws.hpp"
#include "state/by_pair.hpp"

namespace spall {

/// A law whose bonds break: what is bound pulls until it is `cutoff` apart and is then bound no
/// more; what is not bound only repels, nearer than the distance of rest.
template <class Law>
concept BreakingLaw = requires(const Law& law) {
  law.rest2;
};

/// How bodies of one kind crowd each other.
struct OneCrowding {
  explicit OneCrowding(double reach) : weight(reach), reach2(weight.reach2()) {}
  const OneCrowding& of(const Index*, const Index*) const { return *this; }
  static const Lanes& of_own(const Lanes& x) { return x; }
  static const Lanes& of_partner(const Lanes& x) { return x; }

  CrowdingWeight weight;
  double reach2;  ///< m^2, up to which pairs matter at all
};

/// One law for all pairs. Squares of distances (m^2): `cutoff2`, beyond which there is no force;
/// `rest2`, beyond which what is not bound has none; `damped2`, up to which a force -c u_n damps.
template <class Law>
struct OneLaw : OneCrowding {
  static constexpr bool breaks = BreakingLaw<Law>;

  OneLaw(const PairPotential& p, const Law& of_lanes, double damping)
      : OneCrowding(crowding_reach * p.distance),
        law(of_lanes),
        cutoff2(p.cutoff * p.cutoff),
        rest2(breaks ? p.distance * p.distance : cutoff2),
        damped2(p.distance * p.distance),
        c(damping),
        at_cutoff(law.energy(spread(cutoff2))[0]),
        at_rest(law.energy(spread(rest2))[0]) {
    reach2 = p.embedding.bulk_modulus > 0 ? std::max(cutoff2, reach2) : cutoff2;
  }
  const OneLaw& of(const Index*, const Index*) const { return *this; }
  Lanes force_over_distance(const Lanes& r2) const { return law.force_over_distance(r2); }
  Lanes energy(const Lanes& r2) const { return law.energy(r2); }

  Law law;
  double cutoff2, rest2, damped2;
  double c;                   ///< kg/s
  double at_cutoff, at_rest;  ///< J, of the law there
};

/// A law for each pair of materials.
class LawTable {
 public:
  struct Entry {
    AnyLaw law;
    double cutoff2, rest2, damped2, c, at_cutoff, at_rest;  ///< as of OneLaw
    double crowding;            ///< m, up to which the two crowd each other
    double of_own, of_partner;  ///< of the weight: in the crowding of the own body, the partner's
  };

  LawTable(const ByPair<PairPotential>& laws, const ByPair<double>& damping);

  /// The terms of eight pairs, lane by lane.
  class Slot {
   public:
    Slot(const LawTable& table, const std::int32_t* material, const Index* own,
         const Index* partners);
    Lanes force_over_distance(const Lanes& r2) const {
      return each([&](const auto& law) { return law.force_over_distance(r2); });
    }
    Lanes energy(const Lanes& r2) const {
      return each([&](const auto& law) { return law.energy(r2); });
    }
    Lanes of_own(const Lanes& x) const { return x * own_share_; }
    Lanes of_partner(const Lanes& x) const { return x * partner_share_; }

    Lanes cutoff2{}, rest2{}, damped2{}, c{}, at_cutoff{}, at_rest{};
    BasicCrowdingWeight<Lanes> weight{Lanes{}};

   private:
    /// Calls `f(entry, mask)` for each law among the pairs.
    template <class F>
    void for_each_law(F&& f) const {
      if (one_law_) return f(*entries_[0], mask_of_bits(0xff));
      for (unsigned left = 0xff; left != 0;) {
        const Entry* const entry = entries_[static_cast<std::size_t>(std::countr_zero(left))];
        unsigned same = 0;
        for (std::size_t l = 0; l < lane_count; ++l) same |= (entries_[l] == entry) << l;
        f(*entry, mask_of_bits(static_cast<std::uint8_t>(same)));
        left &= ~same;
      }
    }
    template <class F>
    Lanes each(F&& f) const {
      Lanes result{};
      for_each_law([&](const Entry& entry, const LaneMask& mask) {
        result = select(mask, Lanes(std::visit(f, entry.law)), result);
      });
      return result;
    }

    std::array<const Entry*, lane_count> entries_;
    bool one_law_ = true;
    Lanes own_share_{}, partner_share_{};
  };

  double reach2() const { return reach2_; }

 private:
  std::size_t materials_;
  double reach2_ = 0;
  std::vector<Entry> entries_;
};

/// The table with the materials of the rows that a sweep goes over.
template <bool with_bonds>
struct MixedLaws {
  static constexpr bool breaks = with_bonds;

  MixedLaws(const LawTable& of_pairs, const std::int32_t* of_rows)
      : table(&of_pairs), material(of_rows), reach2(of_pairs.reach2()) {}
  LawTable::Slot of(const Index* own, const Index* partners) const {
    return {*table, material, own, partners};
  }

  const LawTable* table;
  const std::int32_t* material;
  double reach2;
};

}  // namespace spall
