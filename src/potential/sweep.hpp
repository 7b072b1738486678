// One sweep over all near pairs: forces, and each body's motion as soon as its force is whole.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>

#include "pairs/near_pairs.hpp"
#include "pairs/transfer.hpp"
#include "potential/pair_terms.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// What a sweep needs of a body, in one line of the cache.
struct alignas(64) PairRow {
  RowHalf place;  ///< x, y, z (m), inverse mass (1/kg)
  RowHalf force;  ///< on the body (N), and the power that it dissipates (W); zero before a sweep
};

/// Positions of the eight rows that begin at these places.
[[gnu::always_inline]] inline LaneVectors gather_positions(const PairRow* rows,
                                                           const Index* places) {
  const double* const all = reinterpret_cast<const double*>(rows);
  LaneVectors v;
  lanes_of_halves([&](int l) { return *reinterpret_cast<const RowHalf*>(all + places[l]); }, &v.x,
                  &v.y, &v.z);
  return v;
}

inline void add_forces(const Lanes& x, const Lanes& y, const Lanes& z, const Lanes& power,
                       const Index* places, PairRow* rows) {
  add_lanes({x, y, z}, power, places, reinterpret_cast<double*>(rows) + 4);
}

/// What a body presses with, by its crowding and its heat: J, all of it and the heat's.
using Pushes = std::vector<EmbeddingLaw::Push>;
inline constexpr Index doubles_a_push = 2;
static_assert(sizeof(EmbeddingLaw::Push) == doubles_a_push * sizeof(double));

/// Of the eight bodies whose rows begin at these places.
struct PushLanes {
  Lanes all, heat;
};
inline PushLanes gather_pushes(const EmbeddingLaw::Push* pushes, const Index* places) {
  const IndexLanes at = rows_at(places) * doubles_a_push;
  return {gather(&pushes->all, at), gather(&pushes->heat, at)};
}

/// Asks for the rows of the next window, a slot of them with each slot of this one: the processor
/// itself looks ahead only a few slots, far less than memory takes to answer.
class RowsAhead {
 public:
  RowsAhead(const NearWindow& next, const PairRow* rows)
      : at_(next.partners.data()),
        end_(at_ + next.partners.size()),
        all_(reinterpret_cast<const double*>(rows)) {}
  void ask_for_slot() {
    if (at_ == end_) return;
    for (std::size_t l = 0; l < lane_count; ++l) __builtin_prefetch(all_ + at_[l], 1);
    at_ += lane_count;
  }

 private:
  const Index* at_;
  const Index* end_;
  const double* all_;
};

/// Adds to the crowding of each owned body; that of ghosts means nothing.
template <class Terms>
void sweep_crowding(const std::vector<NearWindow>& windows, const Terms& of_pairs,
                    const PairRow* rows, double* crowding) {
  const Terms terms = of_pairs;  // its own: what is written could else be one of its constants
  for (std::size_t k = 0; k < windows.size(); ++k) {
    const NearWindow& window = windows[k];
    RowsAhead ahead(windows[std::min(k + 1, windows.size() - 1)], rows);
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * lane_count;
      const LaneVectors xi = gather_positions(rows, own);
      Lanes sum{};
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count) {
        ahead.ask_for_slot();
        const LaneVectors xj = gather_positions(rows, partners);
        const Lanes dx = xj.x - xi.x, dy = xj.y - xi.y, dz = xj.z - xi.z;
        const Lanes r2 = dx * dx + dy * dy + dz * dz;
        if (bits_of_mask(r2 < terms.reach2) == 0) continue;
        const auto& pair = terms.of(own, partners);
        const Lanes w = pair.weight(r2), w_partner = pair.of_partner(w);
        sum += pair.of_own(w);
        for (std::size_t l = 0; l < lane_count; ++l)
          crowding[partners[l] / doubles_a_row] += w_partner[l];
      }
      for (std::size_t l = 0; l < lane_count; ++l) crowding[own[l] / doubles_a_row] += sum[l];
    }
  }
}

/// Adds the forces of all pairs to the rows, and those of the embedding, by what bodies push with,
/// ghosts too; calls `finish(body)` for each body of a window once nothing will be added to its row
/// and neither its position nor its velocity will be asked for again. The forces of ghosts mean
/// nothing. `velocity` is what is damped, and what heat does work by.
template <bool damped, bool embedded, class Terms, class Finish>
void sweep_pairs(std::vector<NearWindow>& windows, const Terms& of_pairs,
                 const EmbeddingLaw::Push* pushes, const double* velocity, PairRow* rows,
                 Finish&& finish) {
  const Terms terms =
      of_pairs;  // its own: a bit that is written could else be one of its constants
  const Lanes zero{};
  for (std::size_t w = 0; w < windows.size(); ++w) {
    NearWindow& window = windows[w];
    const NearWindow& next = windows[std::min(w + 1, windows.size() - 1)];
    RowsAhead ahead(next, rows);
    const Index* partners = window.partners.data();
    std::uint8_t* bound = window.bound.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * lane_count;
      const LaneVectors xi = gather_positions(rows, own);
      LaneVectors vi{}, sum{};
      if constexpr (damped) vi = gather_vectors(velocity, own);
      PushLanes push_i{};
      if constexpr (embedded) push_i = gather_pushes(pushes, own);
      Lanes power{};
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count) {
        ahead.ask_for_slot();
        const LaneVectors xj = gather_positions(rows, partners);
        const Lanes dx = xj.x - xi.x, dy = xj.y - xi.y, dz = xj.z - xi.z;
        const Lanes r2 = dx * dx + dy * dy + dz * dz;
        // A row that is its own partner, in a slot that it does not need, is at distance 0.
        if (bits_of_mask((r2 < terms.reach2) & (r2 > 0.0)) == 0) {
          if constexpr (Terms::breaks)
            if (*bound++ != 0) bound[-1] = 0;
          continue;
        }
        const auto& law = terms.of(own, partners);
        LaneMask acts = (r2 < law.cutoff2) & (r2 > 0.0);
        if constexpr (Terms::breaks) {
          const LaneMask holds = acts & mask_of_bits(*bound);
          if (const std::uint8_t now = bits_of_mask(holds); now != *bound) *bound = now;
          ++bound;
          acts &= holds | (r2 < law.rest2);
        }
        Lanes f = law.force_over_distance(r2);
        Lanes taken{}, u{};
        if constexpr (damped) {
          const LaneVectors vj = gather_vectors(velocity, partners);
          u = (vj.x - vi.x) * dx + (vj.y - vi.y) * dy + (vj.z - vi.z) * dz;
          const Lanes pull = law.c * u / r2;
          const auto near = acts & (r2 < law.damped2);
          f -= select(near, pull, zero);
          taken = select(near, 0.5 * pull * u, zero);
          power += taken;
        }
        f = select(acts, f, zero);
        if constexpr (embedded) {
          const PushLanes push_j = gather_pushes(pushes, partners);
          const Lanes slope = law.weight.slope_over_distance(r2);
          f += (law.of_own(push_i.all) + law.of_partner(push_j.all)) * slope;
          if constexpr (damped) {
            power -= law.of_own(push_i.heat) * slope * u;
            taken -= law.of_partner(push_j.heat) * slope * u;
          }
        }
        const Lanes fx = f * dx, fy = f * dy, fz = f * dz;
        sum.x += fx;
        sum.y += fy;
        sum.z += fz;
        add_forces(fx, fy, fz, taken, partners, rows);
      }
      add_forces(-sum.x, -sum.y, -sum.z, power, own, rows);
    }
    for (Index r = 0; r < window.count; ++r) {
      if (r < next.count) __builtin_prefetch(velocity + 3 * (next.rows[r] / doubles_a_row), 1);
      finish(window.rows[r] / doubles_a_row);
    }
  }
}

/// J, of all pairs; those with a ghost count half, as both ranks have them. What is not bound has
/// none at rest, as a bond that breaks.
template <class Terms>
double sweep_energy(const std::vector<NearWindow>& windows, const Terms& terms, const PairRow* rows,
                    Index owned) {
  double energy = 0;
  for (const NearWindow& window : windows) {
    const Index* partners = window.partners.data();
    const std::uint8_t* bound = window.bound.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * lane_count;
      const LaneVectors xi = gather_positions(rows, own);
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count) {
        const LaneVectors xj = gather_positions(rows, partners);
        const Lanes dx = xj.x - xi.x, dy = xj.y - xi.y, dz = xj.z - xi.z;
        const Lanes r2 = dx * dx + dy * dy + dz * dz;
        Lanes share;
        for (std::size_t l = 0; l < lane_count; ++l)
          share[l] = partners[l] / doubles_a_row < owned ? 1 : 0.5;
        const auto& law = terms.of(own, partners);
        const Lanes all = law.energy(r2);
        Lanes u = all - law.at_cutoff;
        if constexpr (Terms::breaks)
          u = select(mask_of_bits(*bound++), u, select(r2 < law.rest2, all - law.at_rest, Lanes{}));
        energy += sum_of_lanes(select((r2 < law.cutoff2) & (r2 > 0.0), share * u, Lanes{}));
      }
    }
  }
  return energy;
}

}  // namespace spall
