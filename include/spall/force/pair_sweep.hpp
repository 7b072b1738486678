// One sweep over all near pairs: forces, and each body's motion as soon as its force is whole.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>

#include "spall/force/embedding.hpp"
#include "spall/force/lanes.hpp"
#include "spall/force/near_pairs.hpp"

namespace spall {

using RowHalf = double __attribute__((vector_size(4 * sizeof(double))));

/// What a sweep needs of a body, in one line of the cache.
struct alignas(64) PairRow {
  RowHalf place;  ///< x, y, z (m), inverse mass (1/kg)
  RowHalf force;  ///< on the body (N), and the power that it dissipates (W); zero before a sweep
};

struct LaneVectors {
  Lanes x, y, z;
};

/// Positions of the eight rows that begin at these places.
[[gnu::always_inline]] inline LaneVectors gather_positions(const PairRow* rows,
                                                           const Index* places) {
  const double* const all = reinterpret_cast<const double*>(rows);
  const auto two = [&](int low, int high) {
    return __builtin_shufflevector(*reinterpret_cast<const RowHalf*>(all + places[low]),
                                   *reinterpret_cast<const RowHalf*>(all + places[high]), 0, 1, 2,
                                   3, 4, 5, 6, 7);
  };
  const Lanes a = two(0, 4), b = two(1, 5), c = two(2, 6), d = two(3, 7);
  const Lanes ab = __builtin_shufflevector(a, b, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes cd = __builtin_shufflevector(c, d, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes ab_y = __builtin_shufflevector(a, b, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes cd_y = __builtin_shufflevector(c, d, 1, 9, 3, 11, 5, 13, 7, 15);
  return {__builtin_shufflevector(ab, cd, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab_y, cd_y, 0, 1, 8, 9, 4, 5, 12, 13),
          __builtin_shufflevector(ab, cd, 2, 3, 10, 11, 6, 7, 14, 15)};
}

/// Vectors, three doubles each, of the bodies whose rows begin at these places.
inline LaneVectors gather_vectors(const double* vectors, const Index* places) {
#ifdef __AVX512F__
  const __m256i row =
      _mm256_srli_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(places)), 3);
  const __m256i at = _mm256_add_epi32(row, _mm256_add_epi32(row, row));
  const auto gather = [&](const double* from) {
    return _mm512_mask_i32gather_pd(_mm512_setzero_pd(), 0xff, at, from, 8);
  };
  return {gather(vectors), gather(vectors + 1), gather(vectors + 2)};
#else
  LaneVectors v;
  for (std::size_t l = 0; l < lane_count; ++l) {
    const double* vector = vectors + 3 * (places[l] / doubles_a_row);
    v.x[l] = vector[0];
    v.y[l] = vector[1];
    v.z[l] = vector[2];
  }
  return v;
#endif
}

/// Adds lane l to the half row that begins at `half` + places[l], one after another: two lanes may
/// name the same row.
[[gnu::always_inline]] inline void add_lanes(const LaneVectors& v, const Lanes& last,
                                             const Index* places, double* half) {
  const Lanes xy = __builtin_shufflevector(v.x, v.y, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes xy_odd = __builtin_shufflevector(v.x, v.y, 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes zw = __builtin_shufflevector(v.z, last, 0, 8, 2, 10, 4, 12, 6, 14);
  const Lanes zw_odd = __builtin_shufflevector(v.z, last, 1, 9, 3, 11, 5, 13, 7, 15);
  const auto add = [&](int low, int high, const Lanes& pair) __attribute__((always_inline)) {
    *reinterpret_cast<RowHalf*>(half + places[low]) +=
        __builtin_shufflevector(pair, pair, 0, 1, 2, 3);
    *reinterpret_cast<RowHalf*>(half + places[high]) +=
        __builtin_shufflevector(pair, pair, 4, 5, 6, 7);
  };
  add(0, 2, __builtin_shufflevector(xy, zw, 0, 1, 8, 9, 2, 3, 10, 11));
  add(1, 3, __builtin_shufflevector(xy_odd, zw_odd, 0, 1, 8, 9, 2, 3, 10, 11));
  add(4, 6, __builtin_shufflevector(xy, zw, 4, 5, 12, 13, 6, 7, 14, 15));
  add(5, 7, __builtin_shufflevector(xy_odd, zw_odd, 4, 5, 12, 13, 6, 7, 14, 15));
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
#ifdef __AVX512F__
  static_assert(doubles_a_row == 4 * doubles_a_push);
  const __m256i at =
      _mm256_srli_epi32(_mm256_loadu_si256(reinterpret_cast<const __m256i*>(places)), 2);
  const auto gather = [&](const double* from) {
    return _mm512_mask_i32gather_pd(_mm512_setzero_pd(), 0xff, at, from, 8);
  };
  return {gather(&pushes->all), gather(&pushes->heat)};
#else
  PushLanes p;
  for (std::size_t l = 0; l < lane_count; ++l) {
    const EmbeddingLaw::Push& one = pushes[places[l] / doubles_a_row];
    p.all[l] = one.all;
    p.heat[l] = one.heat;
  }
  return p;
#endif
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

/// What damps pairs nearer than `distance`: a force -c u_n along the line of the centres.
struct PairDamping {
  double distance = 0;  ///< m
  double c = 0;         ///< kg/s
};

/// A law whose bonds break: what is bound pulls until it is `cutoff` apart and is then bound no
/// more; what is not bound only repels, nearer than the distance of rest.
template <class Law>
concept BreakingLaw = requires(const Law& law) {
  law.rest2;
};

/// Adds to the crowding of each owned body; that of ghosts means nothing.
inline void sweep_crowding(const std::vector<NearWindow>& windows, const CrowdingWeight& weight,
                           const PairRow* rows, double* crowding) {
  const double reach2 = weight.reach2();
  const CrowdingWeight of_pairs = weight;  // its own: what is written could else be a constant
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
        if (bits_of_mask(r2 < reach2) == 0) continue;
        const Lanes w = of_pairs(r2);
        sum += w;
        for (std::size_t l = 0; l < lane_count; ++l) crowding[partners[l] / doubles_a_row] += w[l];
      }
      for (std::size_t l = 0; l < lane_count; ++l) crowding[own[l] / doubles_a_row] += sum[l];
    }
  }
}

/// The embedding part of a sweep: what bodies press with, ghosts' too.
struct PairEmbedding {
  CrowdingWeight weight;
  const EmbeddingLaw::Push* pushes = nullptr;  ///< none: pairs are all there is
};

/// Adds the forces of all pairs nearer than `cutoff` to the rows, and those of the embedding;
/// calls `finish(body)` for each body of a window once nothing will be added to its row and neither
/// its position nor its velocity will be asked for again. The forces of ghosts mean nothing.
/// `velocity` is what is damped, and what heat does work by.
template <bool damped, bool embedded, class Law, class Finish>
void sweep_pairs(std::vector<NearWindow>& windows, const Law& of_pairs, double cutoff,
                 const PairDamping& damping, const PairEmbedding& embedding, const double* velocity,
                 PairRow* rows, Finish&& finish) {
  const Law law = of_pairs;  // its own: a bit that is written could else be one of its constants
  const CrowdingWeight weight = embedding.weight;
  const EmbeddingLaw::Push* const pushes = embedding.pushes;
  const double c = damping.c;
  const double cutoff2 = cutoff * cutoff,
               reach2 = embedded ? std::max(cutoff2, weight.reach2()) : cutoff2;
  const double damped2 = damping.distance * damping.distance;
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
        if (bits_of_mask((r2 < reach2) & (r2 > 0.0)) == 0) {
          if constexpr (BreakingLaw<Law>)
            if (*bound++ != 0) bound[-1] = 0;
          continue;
        }
        LaneMask acts = (r2 < cutoff2) & (r2 > 0.0);
        if constexpr (BreakingLaw<Law>) {
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
          const Lanes pull = c * u / r2;
          const auto near = acts & (r2 < damped2);
          f -= near ? pull : zero;
          taken = near ? 0.5 * pull * u : zero;
          power += taken;
        }
        f = acts ? f : zero;
        if constexpr (embedded) {
          const PushLanes push_j = gather_pushes(pushes, partners);
          const Lanes slope = weight.slope_over_distance(r2);
          f += (push_i.all + push_j.all) * slope;
          if constexpr (damped) {
            power -= push_i.heat * slope * u;
            taken -= push_j.heat * slope * u;
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

/// J, of all pairs nearer than `cutoff`; those with a ghost count half, as both ranks have them.
/// What is not bound has none at rest, as a bond that breaks.
template <class Law>
double sweep_energy(const std::vector<NearWindow>& windows, const Law& law, double cutoff,
                    const PairRow* rows, Index owned) {
  const double at_cutoff = law.energy(spread(cutoff * cutoff))[0];
  double energy = 0;
  for (const NearWindow& window : windows) {
    const Index* partners = window.partners.data();
    const std::uint8_t* bound = window.bound.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const LaneVectors xi = gather_positions(rows, window.rows.data() + g * lane_count);
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count) {
        const LaneVectors xj = gather_positions(rows, partners);
        const Lanes dx = xj.x - xi.x, dy = xj.y - xi.y, dz = xj.z - xi.z;
        const Lanes r2 = dx * dx + dy * dy + dz * dz;
        Lanes share;
        for (std::size_t l = 0; l < lane_count; ++l)
          share[l] = partners[l] / doubles_a_row < owned ? 1 : 0.5;
        Lanes u = law.energy(r2) - at_cutoff;
        if constexpr (BreakingLaw<Law>) {
          const Lanes pressed = law.energy(r2) - law.energy(spread(law.rest2));
          u = mask_of_bits(*bound++) ? u : r2 < law.rest2 ? pressed : Lanes{};
        }
        energy += sum_of_lanes((r2 < cutoff * cutoff) & (r2 > 0.0) ? share * u : Lanes{});
      }
    }
  }
  return energy;
}

}  // namespace spall
