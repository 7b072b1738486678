// The sweeps of a step over the pairs of one piece: shapes and velocities; then forces; and who
// meets whom how fast. The inner list of pairs that they go over.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "solid/rows.hpp"
#include "spall/bodies.hpp"
#include "spall/types.hpp"

namespace spall {

/// Bodies with their partners of the same piece, those within reach first. Groups of `pair_lanes`
/// bodies have about as many of these, or of brisk pairs about as many in all: lanes are full of
/// pairs that act, and slots of those in the skin are passed over. As in `NearWindow`, a body is
/// its own partner in slots that are left, and the last one of a window fills up its last group. A
/// body is partner in no window after its own.
struct PiecePairs {
  struct Window {
    std::size_t groups, bodies;  ///< of it and of those before
  };
  std::vector<Window> windows;
  std::vector<Index> bodies;    ///< each once
  std::vector<Index> rows;      ///< places, `pair_lanes` a group
  std::vector<Index> slots;     ///< of each group
  std::vector<Index> partners;  ///< places, `pair_lanes` a slot
  /// The inner list: those slots that may act before bodies have come nearer by its own, smaller
  /// skin (as Pall et al. prune theirs, J. Chem. Phys. 153 (2020) 134110). Sweeps go over these.
  std::vector<Index> inner_slots, inner_partners;
  double inner_at = -infinity;  ///< m, how much nearer bodies had come when it was made

  std::span<const Index> bodies_of(std::size_t window) const {
    const std::size_t from = window == 0 ? 0 : windows[window - 1].bodies;
    return std::span(bodies).subspan(from, windows[window].bodies - from);
  }
  void clear() {
    windows.clear();
    for (auto* numbers : {&bodies, &rows, &slots, &partners}) numbers->clear();
    inner_at = -infinity;
  }
};

/// Asks memory for rows, `width` doubles each, of the bodies of a slot some way ahead of this one:
/// the processor itself looks no further than a slot, less than memory takes to answer.
template <Index width>
[[gnu::always_inline]] inline void ask_ahead(const PiecePairs& pairs, const Index* slot,
                                             const double* rows) {
  constexpr std::ptrdiff_t slots = 4;
  const Index* const places = slot + slots * static_cast<std::ptrdiff_t>(pair_lanes);
  if (places >= pairs.inner_partners.data() + pairs.inner_partners.size()) return;
  for (std::size_t l = 0; l < pair_lanes; ++l)
    for (Index k = 0; k < width; k += doubles_a_row)
      __builtin_prefetch(rows + row_at<width>(places[l]) + k);
}

/// Where some bodies are, and their volumes.
struct PlaceLanes {
  PairLanes x, y, z, volume;

  [[gnu::always_inline]] PlaceLanes(const MotionRow* rows, const Index* places) {
    gather_half<doubles_a_row>(reinterpret_cast<const double*>(rows), places, &x, &y, &z, &volume);
  }
};
/// From some bodies to their partners, and who of these is within reach; nobody is its own.
struct GapLanes {
  PairLanes x, y, z, r2, share2;  ///< m, m^2; of the reach, squared
  PairMask acts;

  [[gnu::always_inline]] GapLanes(const PlaceLanes& i, const PlaceLanes& j,
                                  const PairLanes& inverse2)
      : x(j.x - i.x),
        y(j.y - i.y),
        z(j.z - i.z),
        r2(x * x + y * y + z * z),
        share2(r2 * inverse2),
        acts((share2 < 1.0) & (share2 > 0.0)) {}
};

/// Makes the inner list, of slots with partners that are within reach, or nearer to it than `skin`
/// (m).
inline void find_inner(PiecePairs& pairs, const double* reach, double skin, const MotionRow* rows) {
  pairs.inner_slots.clear();
  pairs.inner_partners.clear();
  const Index* partners = pairs.partners.data();
  for (std::size_t g = 0; g < pairs.slots.size(); ++g) {
    const Index* own = pairs.rows.data() + g * pair_lanes;
    const PlaceLanes at(rows, own);
    const PairLanes inverse = 1.0 / (gather_numbers(reach, own) + skin);
    const std::size_t before = pairs.inner_partners.size();
    for (Index s = 0; s < pairs.slots[g]; ++s, partners += pair_lanes)
      if (any_lane(GapLanes(at, PlaceLanes(rows, partners), inverse * inverse).acts))
        pairs.inner_partners.insert(pairs.inner_partners.end(), partners, partners + pair_lanes);
    pairs.inner_slots.push_back(
        static_cast<Index>((pairs.inner_partners.size() - before) / pair_lanes));
  }
}

/// How they move.
struct MotionLanes {
  PairLanes u, v, w, pressure;

  [[gnu::always_inline]] MotionLanes(const MotionRow* rows, const Index* places) {
    gather_half<doubles_a_row>(reinterpret_cast<const double*>(rows) + 4, places, &u, &v, &w,
                               &pressure);
  }
  PairMask failed() const { return pressure >= infinity; }
};
/// v^2/R^2 (1/s^2) of those that act, v their velocity against each other; 0 of others.
[[gnu::always_inline]] inline PairLanes meeting2(const MotionLanes& i, const MotionLanes& j,
                                                 const PairMask& acts, const PairLanes& inverse2) {
  const PairLanes u = j.u - i.u, v = j.v - i.v, w = j.w - i.w;
  return select(acts, (u * u + v * v + w * w) * inverse2, PairLanes{});
}

/// What a pair adds to two `ShapeRow`s but for the weights, from the difference of their rows.
struct ShapeTerms {
  Lanes first, second;

  [[gnu::always_inline]] ShapeTerms(const Lanes& d, double r2p)
      : first(shuffle<0, 1, 2, 1, 2, 0, 4, 4>(d, d) * shuffle<0, 1, 2, 2, 0, 1, 0, 1>(d, d)),
        second(select(
            last(), spread(r2p),
            shuffle<4, 5, 5, 5, 6, 6, 6, 6>(d, d) * shuffle<2, 0, 1, 2, 0, 1, 2, 2>(d, d))) {}
  /// S alone changes sign with the side that is asked.
  [[gnu::always_inline]] Lanes second_of_partner() const { return select(last(), -second, second); }

 private:
  static LaneMask last() { return LaneMask{0, 0, 0, 0, 0, 0, 0, -1}; }
};

/// Adds to the sums of owned bodies; those of ghosts mean nothing. `reach` is R of each body (m). A
/// neighbour counts by `neighbour_weight`. Returns the largest v^2/R^2 of neighbours, v their
/// velocity against each other (1/s^2).
inline double sweep_shapes(const PiecePairs& pairs, const double* reach, const MotionRow* rows,
                           ShapeRow* shapes) {
  // Weights are found in lanes of pairs, then pairs are added one by one, all sums of one at once:
  // to put sixteen sums from lanes into rows would take more shuffles.
  constexpr std::size_t slots_at_once = 16;
  const double* const of_rows = reinterpret_cast<const double*>(rows);
  double* const sums = reinterpret_cast<double*>(shapes);
  const auto row = [&](Index place) { return *reinterpret_cast<const Lanes*>(of_rows + place); };
  const auto sum_row = [&](Index place) {
    return reinterpret_cast<Lanes*>(sums + row_at<shape_width>(place));
  };
  const PairLanes zero{};
  PairLanes fastest{}, of_own[slots_at_once], of_partner[slots_at_once], r2p[slots_at_once];
  const Index* slot[slots_at_once];
  const Index* partners = pairs.inner_partners.data();
  for (std::size_t g = 0; g < pairs.inner_slots.size(); ++g) {
    const Index* own = pairs.rows.data() + g * pair_lanes;
    const PlaceLanes at(rows, own);
    const MotionLanes i(rows, own);
    const PairLanes inverse = 1.0 / gather_numbers(reach, own), inverse2 = inverse * inverse;
    const PairMask failed = i.failed();
    const Index* const end = partners + pairs.inner_slots[g] * static_cast<Index>(pair_lanes);
    while (partners != end) {
      std::size_t slots = 0;
      for (; partners != end && slots < slots_at_once; partners += pair_lanes) {
        ask_ahead<doubles_a_row>(pairs, partners, of_rows);
        ask_ahead<shape_width>(pairs, partners, sums);
        const PlaceLanes beside(rows, partners);
        const auto [x, y, z, r2, share2, acts] = GapLanes(at, beside, inverse2);
        if (!any_lane(acts)) continue;
        const MotionLanes j(rows, partners);
        const PairLanes weight = select(acts, neighbour_weight(square_root(share2)), zero);
        // Who has not failed does not see who has: nothing holds it there.
        const PairMask partner_failed = j.failed();
        of_own[slots] = select(partner_failed & ~failed, zero, weight * beside.volume);
        of_partner[slots] = select(failed & ~partner_failed, zero, weight * at.volume);
        r2p[slots] = select(failed | partner_failed, zero, r2 * (j.pressure - i.pressure));
        fastest = larger(fastest, meeting2(i, j, acts, inverse2));
        slot[slots++] = partners;
      }
      for (std::size_t l = 0; l < pair_lanes; ++l) {
        const Lanes from = row(own[l]);
        Lanes first{}, second{};
        for (std::size_t s = 0; s < slots; ++s) {
          const Index partner = slot[s][l];
          const ShapeTerms terms(row(partner) - from, r2p[s][l]);
          first += of_own[s][l] * terms.first;
          second += of_own[s][l] * terms.second;
          Lanes* const its = sum_row(partner);
          its[0] += of_partner[s][l] * terms.first;
          its[1] += of_partner[s][l] * terms.second_of_partner();
        }
        Lanes* const its = sum_row(own[l]);
        its[0] += first;
        its[1] += second;
      }
    }
  }
  double most = 0;
  for (std::size_t l = 0; l < pair_lanes; ++l) most = std::max<double>(most, fastest[l]);
  return most;
}

/// Raises `most` of each body to the largest v^2/R^2 (1/s^2) of its neighbours, v their velocity
/// against its own.
inline void sweep_meetings(const PiecePairs& pairs, const double* reach, const MotionRow* rows,
                           double* most) {
  const Index* partners = pairs.inner_partners.data();
  for (std::size_t g = 0; g < pairs.inner_slots.size(); ++g) {
    const Index* own = pairs.rows.data() + g * pair_lanes;
    const PlaceLanes at(rows, own);
    const MotionLanes i(rows, own);
    const PairLanes inverse = 1.0 / gather_numbers(reach, own), inverse2 = inverse * inverse;
    PairLanes fastest{};
    for (Index s = 0; s < pairs.inner_slots[g]; ++s, partners += pair_lanes) {
      ask_ahead<doubles_a_row>(pairs, partners, reinterpret_cast<const double*>(rows));
      const PairMask near = GapLanes(at, PlaceLanes(rows, partners), inverse2).acts;
      if (!any_lane(near)) continue;
      const MotionLanes j(rows, partners);
      const PairLanes meets = meeting2(i, j, near, inverse2);
      fastest = larger(fastest, meets);
      for (std::size_t l = 0; l < pair_lanes; ++l) {
        double& its = most[partners[l] / doubles_a_row];
        its = std::max<double>(its, meets[l]);
      }
    }
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      double& its = most[own[l] / doubles_a_row];
      its = std::max<double>(its, fastest[l]);
    }
  }
}

/// How some bodies answer.
struct ResponseLanes {
  PairLanes t[9], d[6], linear, square, u, v, w, time;

  [[gnu::always_inline]] ResponseLanes(const ResponseRow* rows, const Index* places) {
    const double* all = reinterpret_cast<const double*>(rows);
    gather_half<response_width>(all, places, &t[0], &t[1], &t[2], &t[3]);
    gather_half<response_width>(all + 4, places, &t[4], &t[5], &t[6], &t[7]);
    gather_half<response_width>(all + 8, places, &t[8], &d[0], &d[1], &d[2]);
    gather_half<response_width>(all + 12, places, &d[3], &d[4], &d[5], &linear);
    gather_half<response_width>(all + 16, places, &square, &u, &v, &w);
    PairLanes none, nothing;
    gather_half<response_width>(all + 20, places, &time, &none, &nothing, nullptr);
  }
  /// x . D x
  PairLanes stretching(const PairLanes& x, const PairLanes& y, const PairLanes& z) const {
    return x * (d[0] * x + 2.0 * d[5] * y) + y * (d[1] * y + 2.0 * d[3] * z) +
           z * (d[2] * z + 2.0 * d[4] * x);
  }
};

/// van Leer's limiter of two gradients: 1 where they are equal, 0 where their signs differ.
[[gnu::always_inline]] inline PairLanes limiter(const PairLanes& a, const PairLanes& b) {
  const PairLanes sum = a + b, product = 4.0 * a * b;
  return select(product > 0.0, product / (sum * sum), PairLanes{});
}

/// Adds the impulses of pairs of one piece: by the forces
///
///   f = w V_i V_j (sigma_i K_i^-1 + sigma_j K_j^-1) x   (each where the body sees the other)
///       - w V_i V_j (a_i q_i + a_j q_j) x,   q = rho (c u + s u^2),
///
/// in which what is body i's own acts for its `ResponseRow::time` on both.
/// u > 0 the closing speed that is left where both velocities are extrapolated to the middle by the
/// bodies' gradients, limited (the limiter of Frontiere, Raskin & Owen, J. Comput. Phys. 332 (2017)
/// 160), and never more than that of the bodies themselves; c and s are the material's own, as
/// behind a shock rho (c + s u) u (Dukowicz, J. Comput. Phys. 61 (1985) 119). Calls `finish(body)`
/// once nothing will be added to its row and neither its place nor its answer will be asked for
/// again, and `ask(body)` a window before.
template <class Ask, class Finish>
void sweep_forces(const PiecePairs& pairs, const double* reach, const MotionRow* rows,
                  const ResponseRow* responses, PushRow* impulses, Ask&& ask, Finish&& finish) {
  const double* const of_rows = reinterpret_cast<const double*>(rows);
  const double* const of_responses = reinterpret_cast<const double*>(responses);
  double* const sums = reinterpret_cast<double*>(impulses);
  const PairLanes zero{};
  const Index* partners = pairs.inner_partners.data();
  for (std::size_t n = 0, g = 0; n < pairs.windows.size(); ++n) {
    for (; g < pairs.windows[n].groups; ++g) {
      const Index* own = pairs.rows.data() + g * pair_lanes;
      const PlaceLanes i(rows, own);
      const MotionLanes moves(rows, own);
      const ResponseLanes a(responses, own);
      const PairLanes inverse = 1.0 / gather_numbers(reach, own), inverse2 = inverse * inverse;
      const PairLanes own_u = moves.u + a.u, own_v = moves.v + a.v, own_w = moves.w + a.w;
      const PairMask failed = moves.failed();
      PairLanes fx{}, fy{}, fz{}, heat{};
      for (Index s = 0; s < pairs.inner_slots[g]; ++s, partners += pair_lanes) {
        ask_ahead<doubles_a_row>(pairs, partners, of_rows);
        ask_ahead<response_width>(pairs, partners, of_responses);
        ask_ahead<push_width>(pairs, partners, sums);
        const PlaceLanes j(rows, partners);
        const auto [x, y, z, r2, share2, acts] = GapLanes(i, j, inverse2);
        if (!any_lane(acts)) continue;
        const MotionLanes partner_moves(rows, partners);
        const ResponseLanes b(responses, partners);
        const PairLanes inverse_r = inverse_sqrt(r2);
        const PairLanes weight = neighbour_weight(r2 * inverse_r * inverse);
        const PairLanes w = select(acts, weight * i.volume * j.volume, zero);
        const PairLanes by_own = w * a.time, by_partner = w * b.time;
        const PairMask partner_failed = partner_moves.failed();
        const PairLanes from_own = select(partner_failed & ~failed, zero, by_own);
        const PairLanes from_partner = select(failed & ~partner_failed, zero, by_partner);
        PairLanes t[9];
        for (int k = 0; k < 9; ++k) t[k] = from_own * a.t[k] + from_partner * b.t[k];

        const PairLanes u = (partner_moves.u + b.u - own_u) * x +
                            (partner_moves.v + b.v - own_v) * y +
                            (partner_moves.w + b.w - own_w) * z;  // r dr/dt
        // Of one that does not act now the gradient is taken to be that of the other.
        PairLanes g_own = a.stretching(x, y, z), g_partner = b.stretching(x, y, z);
        g_own = select(a.time != 0.0, g_own, g_partner);
        g_partner = select(b.time != 0.0, g_partner, g_own);
        // Gradients may only lessen a closing speed: else parting bodies would turn heat into
        // motion.
        const PairLanes left = larger(u, u - 0.5 * limiter(g_own, g_partner) * (g_own + g_partner));
        const PairLanes mu = left * inverse_r;
        // Of a stride that ended early, stress is taken back; viscosity only warms.
        const PairLanes damps = larger(by_own, zero), partner_damps = larger(by_partner, zero);
        const PairLanes linear = damps * a.linear + partner_damps * b.linear;
        const PairLanes square = damps * a.square + partner_damps * b.square;
        const PairLanes q = select(mu < 0.0, mu * (linear - square * mu), zero);

        const PairLanes px = t[0] * x + t[1] * y + t[2] * z + q * x;
        const PairLanes py = t[3] * x + t[4] * y + t[5] * z + q * y;
        const PairLanes pz = t[6] * x + t[7] * y + t[8] * z + q * z;
        const PairLanes half = 0.5 * q * u;
        fx += px;
        fy += py;
        fz += pz;
        heat += half;
        add_half<push_width>(-px, -py, -pz, half, partners, sums);
      }
      add_half<push_width>(fx, fy, fz, heat, own, sums);
    }
    if (n + 1 < pairs.windows.size())
      for (const Index b : pairs.bodies_of(n + 1)) ask(b);
    std::ranges::for_each(pairs.bodies_of(n), finish);
  }
}

}  // namespace spall
