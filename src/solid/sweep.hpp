// The two sweeps of a step over the pairs of one piece: shapes and velocities; then forces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <compare>
#include <span>
#include <vector>

#include "solid/rows.hpp"
#include "spall/bodies.hpp"
#include "spall/types.hpp"

namespace spall {

/// Bodies of a window with their partners of the same piece, the nearest first. Groups of
/// `pair_lanes` bodies have about as many within reach: lanes are full of pairs that act, and slots
/// of those in the skin are passed over. As in `NearWindow`, a body is its own partner in slots
/// that are left, and the last one fills up the last group.
struct PieceWindow {
  std::vector<Index> bodies;    ///< each once
  std::vector<Index> rows;      ///< places, `pair_lanes` a group
  std::vector<Index> slots;     ///< of each group
  std::vector<Index> partners;  ///< places, `pair_lanes` a slot
};

/// The pairs of one piece of all that were found, with bodies where they were found. `reach` is R
/// of each body (m).
inline std::vector<PieceWindow> pairs_of_pieces(const Bodies& bodies, const double* reach,
                                                const std::vector<NearWindow>& windows) {
  struct Partner {
    double distance2;
    Index place;
    auto operator<=>(const Partner&) const = default;
  };
  struct Row {
    Index place;
    std::ptrdiff_t within;
    std::vector<Partner> partners;
  };
  std::vector<PieceWindow> pieces(windows.size());
  std::vector<Row> all;  // their partners keep their memory from window to window
  for (std::size_t n = 0; n < windows.size(); ++n) {
    const NearWindow& window = windows[n];
    all.resize(std::max(all.size(), window.rows.size()));
    for (std::size_t r = 0; r < window.rows.size(); ++r) {
      all[r].place = window.rows[r];
      all[r].partners.clear();
    }
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g)
      for (Index s = 0; s < window.slots[g]; ++s)
        for (std::size_t l = 0; l < lane_count; ++l) {
          Row& row = all[g * lane_count + l];
          const Index place = *partners++, i = row.place / doubles_a_row, j = place / doubles_a_row;
          if (place == row.place || bodies.group[i] != bodies.group[j]) continue;
          row.partners.push_back({(bodies.position[j] - bodies.position[i]).squaredNorm(), place});
        }
    const std::span rows(all.data(), static_cast<std::size_t>(window.count));
    PieceWindow& piece = pieces[n];
    for (Row& row : rows) {
      const double R = reach[row.place / doubles_a_row];
      std::ranges::sort(row.partners);
      row.within = std::ranges::lower_bound(row.partners, R * R, {}, &Partner::distance2) -
                   row.partners.begin();
      piece.bodies.push_back(row.place / doubles_a_row);
    }
    std::ranges::stable_sort(rows, [](const Row& a, const Row& b) { return a.within > b.within; });
    for (std::size_t first = 0; first < rows.size(); first += pair_lanes) {
      std::size_t most = 0;
      for (std::size_t l = 0; l < pair_lanes; ++l) {
        const std::size_t r = std::min(first + l, rows.size() - 1);
        piece.rows.push_back(rows[r].place);
        most = std::max(most, rows[r].partners.size());
      }
      piece.slots.push_back(static_cast<Index>(most));
      for (std::size_t s = 0; s < most; ++s)
        for (std::size_t r = first; r < first + pair_lanes; ++r) {
          const bool has = r < rows.size() && s < rows[r].partners.size();
          piece.partners.push_back(has ? rows[r].partners[s].place
                                       : rows[std::min(r, rows.size() - 1)].place);
        }
    }
  }
  return pieces;
}

/// Where some bodies are, and their volumes.
struct PlaceLanes {
  PairLanes x, y, z, volume;

  PlaceLanes(const MotionRow* rows, const Index* places) {
    gather_half<doubles_a_row>(reinterpret_cast<const double*>(rows), places, &x, &y, &z, &volume);
  }
};
/// How they move.
struct MotionLanes {
  PairLanes u, v, w, pressure;

  MotionLanes(const MotionRow* rows, const Index* places) {
    gather_half<doubles_a_row>(reinterpret_cast<const double*>(rows) + 4, places, &u, &v, &w,
                               &pressure);
  }
  PairMask failed() const { return pressure >= infinity; }
};

/// Adds to the sums of owned bodies; those of ghosts mean nothing. `reach` is R of each body (m). A
/// neighbour counts by `neighbour_weight`. Returns the largest v^2/R^2 of neighbours, v their
/// velocity against each other (1/s^2).
inline double sweep_shapes(const std::vector<PieceWindow>& windows, const double* reach,
                           const MotionRow* rows, ShapeRow* shapes) {
  double* const sums = reinterpret_cast<double*>(shapes);
  const PairLanes zero{};
  PairLanes fastest{};
  for (const PieceWindow& window : windows) {
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * pair_lanes;
      const PlaceLanes at(rows, own);
      const MotionLanes i(rows, own);
      const PairLanes inverse = 1.0 / gather_numbers(reach, own), inverse2 = inverse * inverse;
      const PairMask failed = i.failed();
      PairLanes sum[16] = {};
      for (Index s = 0; s < window.slots[g]; ++s, partners += pair_lanes) {
        const PlaceLanes beside(rows, partners);
        const PairLanes x = beside.x - at.x, y = beside.y - at.y, z = beside.z - at.z;
        const PairLanes r2 = x * x + y * y + z * z, share2 = r2 * inverse2;
        const PairMask acts = (share2 < 1.0) & (share2 > 0.0);
        if (!any_lane(acts)) continue;
        const MotionLanes j(rows, partners);
        const PairLanes weight = select(acts, neighbour_weight(square_root(share2)), zero);
        // Who has not failed does not see who has: nothing holds it there.
        const PairMask partner_failed = j.failed();
        const PairLanes of_own = select(partner_failed & ~failed, zero, weight * beside.volume);
        const PairLanes of_partner = select(failed & ~partner_failed, zero, weight * at.volume);
        const PairLanes p = select(failed | partner_failed, zero, j.pressure - i.pressure);
        const PairLanes u = j.u - i.u, v = j.v - i.v, w = j.w - i.w;
        fastest = larger(fastest, select(acts, (u * u + v * v + w * w) * inverse2, zero));
        // S alone changes sign with the side that is asked.
        const PairLanes term[16] = {x * x, y * y, z * z, y * z, z * x, x * y, u * x, u * y,
                                    u * z, v * x, v * y, v * z, w * x, w * y, w * z, r2 * p};
        for (int k = 0; k < 16; ++k) sum[k] += of_own * term[k];
        const auto add = [&](int k) {
          const PairLanes last = of_partner * term[k + 3];
          add_half<shape_width>(of_partner * term[k], of_partner * term[k + 1],
                                of_partner * term[k + 2], k < 12 ? last : -last, partners,
                                sums + k);
        };
        add(0), add(4), add(8), add(12);
      }
      for (int k = 0; k < 16; k += 4)
        add_half<shape_width>(sum[k], sum[k + 1], sum[k + 2], sum[k + 3], own, sums + k);
    }
  }
  double most = 0;
  for (std::size_t l = 0; l < pair_lanes; ++l) most = std::max<double>(most, fastest[l]);
  return most;
}

/// How some bodies answer.
struct ResponseLanes {
  PairLanes t[9], d[6], linear, square, u, v, w, volume, failed;

  ResponseLanes(const ResponseRow* rows, const Index* places) {
    const double* all = reinterpret_cast<const double*>(rows);
    gather_half<response_width>(all, places, &t[0], &t[1], &t[2], &t[3]);
    gather_half<response_width>(all + 4, places, &t[4], &t[5], &t[6], &t[7]);
    gather_half<response_width>(all + 8, places, &t[8], &d[0], &d[1], &d[2]);
    gather_half<response_width>(all + 12, places, &d[3], &d[4], &d[5], &linear);
    gather_half<response_width>(all + 16, places, &square, &u, &v, &w);
    PairLanes none;
    gather_half<response_width>(all + 20, places, &volume, &failed, &none, nullptr);
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

/// Adds the forces of all pairs of one piece,
///
///   f = w V_i V_j (sigma_i K_i^-1 + sigma_j K_j^-1) x   (each where the body sees the other)
///       - w V_i V_j (a_i q_i + a_j q_j) x,   q = rho (c u + s u^2),
///
/// u > 0 the closing speed that is left where both velocities are extrapolated to the middle by the
/// bodies' gradients, limited (the limiter of Frontiere, Raskin & Owen, J. Comput. Phys. 332 (2017)
/// 160), and never more than that of the bodies themselves; c and s are the material's own, as
/// behind a shock rho (c + s u) u (Dukowicz, J. Comput. Phys. 61 (1985) 119). Calls `finish(body)`
/// once nothing will be added to its row and neither its place nor its answer will be asked for
/// again.
template <class Finish>
void sweep_forces(const std::vector<PieceWindow>& windows, const double* reach,
                  const MotionRow* rows, const ResponseRow* responses, PushRow* forces,
                  Finish&& finish) {
  double* const sums = reinterpret_cast<double*>(forces);
  const PairLanes zero{};
  for (const PieceWindow& window : windows) {
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * pair_lanes;
      const PlaceLanes i(rows, own);
      const ResponseLanes a(responses, own);
      const PairLanes inverse = 1.0 / gather_numbers(reach, own), inverse2 = inverse * inverse;
      PairLanes fx{}, fy{}, fz{}, power{};
      for (Index s = 0; s < window.slots[g]; ++s, partners += pair_lanes) {
        const PlaceLanes j(rows, partners);
        const PairLanes x = j.x - i.x, y = j.y - i.y, z = j.z - i.z;
        const PairLanes r2 = x * x + y * y + z * z, share2 = r2 * inverse2;
        const PairMask acts = (share2 < 1.0) & (share2 > 0.0);
        if (!any_lane(acts)) continue;
        const ResponseLanes b(responses, partners);
        const PairLanes inverse_r = inverse_sqrt(r2);
        const PairLanes weight = neighbour_weight(r2 * inverse_r * inverse);
        const PairLanes w = select(acts, weight * a.volume * b.volume, zero);
        const PairLanes from_own = select(a.failed < b.failed, zero, w);
        const PairLanes from_partner = select(b.failed < a.failed, zero, w);
        PairLanes t[9];
        for (int k = 0; k < 9; ++k) t[k] = from_own * a.t[k] + from_partner * b.t[k];

        const PairLanes u = (b.u - a.u) * x + (b.v - a.v) * y + (b.w - a.w) * z;  // r dr/dt
        const PairLanes g_own = a.stretching(x, y, z), g_partner = b.stretching(x, y, z);
        // Gradients may only lessen a closing speed: else parting bodies would turn heat into
        // motion.
        const PairLanes left = larger(u, u - 0.5 * limiter(g_own, g_partner) * (g_own + g_partner));
        const PairLanes mu = left * inverse_r;
        PairLanes q =
            select(mu < 0.0, mu * ((a.linear + b.linear) - (a.square + b.square) * mu), zero);
        q *= w;

        const PairLanes px = t[0] * x + t[1] * y + t[2] * z + q * x;
        const PairLanes py = t[3] * x + t[4] * y + t[5] * z + q * y;
        const PairLanes pz = t[6] * x + t[7] * y + t[8] * z + q * z;
        const PairLanes half = 0.5 * q * u;
        fx += px;
        fy += py;
        fz += pz;
        power += half;
        add_half<4>(-px, -py, -pz, half, partners, sums);
      }
      add_half<4>(fx, fy, fz, power, own, sums);
    }
    for (const Index b : window.bodies) finish(b);
  }
}

}  // namespace spall
