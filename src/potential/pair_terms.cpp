// Most slots have bodies of one material, so that one law is found and worked out for all lanes.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/pair_terms.hpp"

#include <algorithm>

namespace spall {

LawTable::LawTable(const ByPair<PairPotential>& laws, const ByPair<double>& damping)
    : materials_(static_cast<std::size_t>(laws.materials())) {
  bool embedded = false;
  laws.for_each([&](const PairPotential& p) { embedded |= p.embedding.bulk_modulus > 0; });
  for (int a = 0; a < laws.materials(); ++a)
    for (int b = 0; b < laws.materials(); ++b) {
      const PairPotential& p = laws(a, b);
      const double d2 = p.distance * p.distance, cutoff2 = p.cutoff * p.cutoff;
      const auto share = [&](int of) {
        const double d = laws(of, of).distance;
        return d * d / d2;
      };
      const auto with = [&]<class Law>(const Law& law) {
        const double rest2 = BreakingLaw<Law> ? d2 : cutoff2, reach = crowding_reach * p.distance;
        reach2_ = std::max({reach2_, cutoff2, embedded ? reach * reach : 0});
        entries_.push_back({.law = law,
                            .cutoff2 = cutoff2,
                            .rest2 = rest2,
                            .damped2 = d2,
                            .c = damping(a, b),
                            .at_cutoff = law.energy(spread(cutoff2))[0],
                            .at_rest = law.energy(spread(rest2))[0],
                            .crowding = reach,
                            .of_own = share(b),
                            .of_partner = share(a)});
      };
      // Of pairs that are not there nothing is asked.
      p.given() ? with_law(p, with) : with(MorseLanes({.distance = 1}));
    }
}

LawTable::Slot::Slot(const LawTable& table, const std::int32_t* material, const Index* own,
                     const Index* partners) {
  for (std::size_t l = 0; l < lane_count; ++l) {
    const auto a = static_cast<std::size_t>(material[own[l] / doubles_a_row]);
    const auto b = static_cast<std::size_t>(material[partners[l] / doubles_a_row]);
    entries_[l] = &table.entries_[a * table.materials_ + b];
    one_law_ &= entries_[l] == entries_[0];
  }
  Lanes crowding{};
  for_each_law([&](const Entry& entry, const LaneMask& mask) {
    const auto set = [&](Lanes& term, double value) { term = select(mask, spread(value), term); };
    set(cutoff2, entry.cutoff2);
    set(rest2, entry.rest2);
    set(damped2, entry.damped2);
    set(c, entry.c);
    set(at_cutoff, entry.at_cutoff);
    set(at_rest, entry.at_rest);
    set(crowding, entry.crowding);
    set(own_share_, entry.of_own);
    set(partner_share_, entry.of_partner);
  });
  weight = BasicCrowdingWeight<Lanes>(crowding);
}

}  // namespace spall
