// The two sweeps of a step over the pairs of one piece: shapes and velocities; then forces.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "solid/rows.hpp"
#include "spall/types.hpp"

namespace spall {

/// The pairs of a window whose bodies are of one piece: a bit a lane, a byte a slot.
using SamePiece = std::vector<std::vector<std::uint8_t>>;

/// Places of eight bodies.
[[gnu::always_inline]] inline LaneVectors gather_places(const MotionRow* rows,
                                                        const Index* places) {
  LaneVectors v;
  gather_half<doubles_a_row>(reinterpret_cast<const double*>(rows), places, &v.x, &v.y, &v.z,
                             nullptr);
  return v;
}

/// Eight bodies with their motion.
struct MotionLanes {
  Lanes x, y, z, volume, u, v, w, pressure;

  MotionLanes(const MotionRow* rows, const Index* places) {
    const double* all = reinterpret_cast<const double*>(rows);
    gather_half<doubles_a_row>(all, places, &x, &y, &z, &volume);
    gather_half<doubles_a_row>(all + 4, places, &u, &v, &w, &pressure);
  }
  LaneMask failed() const { return pressure >= infinity; }
};

/// Weight of a neighbour, (1 - r/R)^2 nearer than R; of squared distances over R^2.
[[gnu::always_inline]] inline Lanes weight_of(const Lanes& share2) {
  const Lanes left = 1.0 - root_of(share2);
  return left * left;
}

/// Adds to the sums of owned bodies; those of ghosts mean nothing. `reach` is R of each body (m).
inline void sweep_shapes(const std::vector<NearWindow>& windows, const SamePiece& same,
                         const double* reach, const MotionRow* rows, ShapeRow* shapes) {
  double* const sums = reinterpret_cast<double*>(shapes);
  const Lanes zero{};
  for (std::size_t n = 0; n < windows.size(); ++n) {
    const NearWindow& window = windows[n];
    const Index* partners = window.partners.data();
    const std::uint8_t* bits = same[n].data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * lane_count;
      const MotionLanes i(rows, own);
      const Lanes R = gather(reach, rows_at(own)), inverse2 = 1.0 / (R * R);
      const LaneMask failed = i.failed();
      Lanes sum[16] = {};
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count) {
        if (*bits++ == 0) continue;
        const MotionLanes j(rows, partners);
        const Lanes x = j.x - i.x, y = j.y - i.y, z = j.z - i.z;
        const Lanes r2 = x * x + y * y + z * z, share2 = r2 * inverse2;
        const LaneMask acts = (share2 < 1.0) & (share2 > 0.0) & mask_of_bits(bits[-1]);
        if (bits_of_mask(acts) == 0) continue;
        const Lanes w = select(acts, weight_of(share2), zero);
        // Who has not failed does not see who has: nothing holds it there.
        const LaneMask partner_failed = j.failed();
        const Lanes of_own = select(partner_failed & ~failed, zero, w * j.volume);
        const Lanes of_partner = select(failed & ~partner_failed, zero, w * i.volume);
        const Lanes p = select(failed | partner_failed, zero, j.pressure - i.pressure);
        const Lanes u = j.u - i.u, v = j.v - i.v, ww = j.w - i.w;
        // S alone changes sign with the side that is asked.
        const Lanes term[16] = {x * x, y * y, z * z, y * z, z * x,  x * y,  u * x,  u * y,
                                u * z, v * x, v * y, v * z, ww * x, ww * y, ww * z, r2 * p};
        for (int k = 0; k < 16; ++k) sum[k] += of_own * term[k];
        const auto add = [&](int k) {
          const Lanes last = of_partner * term[k + 3];
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
}

/// 1/s^2: the largest v^2/R^2 of bodies nearer than R to each other, of any pieces; v their
/// velocity against each other, R the mean of both reaches.
inline double fastest_pair(const std::vector<NearWindow>& windows, const double* reach,
                           const MotionRow* rows) {
  Lanes fastest{};
  for (const NearWindow& window : windows)
    for_each_slot(window, [&](std::size_t, const Index* own, const Index* partners) {
      const MotionLanes i(rows, own), j(rows, partners);
      const Lanes R = 0.5 * (gather(reach, rows_at(own)) + gather(reach, rows_at(partners)));
      const Lanes x = j.x - i.x, y = j.y - i.y, z = j.z - i.z;
      const Lanes u = j.u - i.u, v = j.v - i.v, w = j.w - i.w;
      const Lanes R2 = R * R, speed2 = u * u + v * v + w * w;
      fastest = larger(fastest, select(x * x + y * y + z * z < R2, speed2 / R2, Lanes{}));
    });
  return largest_lane(fastest);
}

/// How eight bodies answer.
struct ResponseLanes {
  Lanes t[9], d[6], linear, square, u, v, w, volume, failed;

  ResponseLanes(const ResponseRow* rows, const Index* places) {
    const double* all = reinterpret_cast<const double*>(rows);
    gather_half<response_width>(all, places, &t[0], &t[1], &t[2], &t[3]);
    gather_half<response_width>(all + 4, places, &t[4], &t[5], &t[6], &t[7]);
    gather_half<response_width>(all + 8, places, &t[8], &d[0], &d[1], &d[2]);
    gather_half<response_width>(all + 12, places, &d[3], &d[4], &d[5], &linear);
    gather_half<response_width>(all + 16, places, &square, &u, &v, &w);
    Lanes none;
    gather_half<response_width>(all + 20, places, &volume, &failed, &none, nullptr);
  }
  /// x . D x
  Lanes stretching(const Lanes& x, const Lanes& y, const Lanes& z) const {
    return x * (d[0] * x + 2.0 * d[5] * y) + y * (d[1] * y + 2.0 * d[3] * z) +
           z * (d[2] * z + 2.0 * d[4] * x);
  }
};

/// van Leer's limiter of two gradients: 1 where they are equal, 0 where their signs differ.
[[gnu::always_inline]] inline Lanes limiter(const Lanes& a, const Lanes& b) {
  const Lanes sum = a + b, product = 4.0 * a * b;
  return select(product > 0.0, product / (sum * sum), Lanes{});
}

/// Adds the forces of all pairs of one piece,
///
///   f = w V_i V_j (sigma_i K_i^-1 + sigma_j K_j^-1) x   (each where the body sees the other)
///       - w V_i V_j (a_i q_i + a_j q_j) x,   q = rho (c u + s u^2),
///
/// u > 0 the closing speed that is left where both velocities are extrapolated to the middle by the
/// bodies' gradients, limited (the limiter of Frontiere, Raskin & Owen, J. Comput. Phys. 332 (2017)
/// 160); c and s are the material's own, as behind a shock rho (c + s u) u (Dukowicz, J. Comput.
/// Phys. 61 (1985) 119). Calls `finish(body)` once nothing will be added to its row and neither its
/// place nor its answer will be asked for again.
template <class Finish>
void sweep_forces(const std::vector<NearWindow>& windows, const SamePiece& same,
                  const double* reach, const MotionRow* rows, const ResponseRow* responses,
                  PushRow* forces, Finish&& finish) {
  double* const sums = reinterpret_cast<double*>(forces);
  const Lanes zero{};
  for (std::size_t n = 0; n < windows.size(); ++n) {
    const NearWindow& window = windows[n];
    const Index* partners = window.partners.data();
    const std::uint8_t* bits = same[n].data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * lane_count;
      const LaneVectors i = gather_places(rows, own);
      const ResponseLanes a(responses, own);
      const Lanes R = gather(reach, rows_at(own)), inverse2 = 1.0 / (R * R);
      Lanes fx{}, fy{}, fz{}, power{};
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count) {
        if (*bits++ == 0) continue;
        const LaneVectors j = gather_places(rows, partners);
        const Lanes x = j.x - i.x, y = j.y - i.y, z = j.z - i.z;
        const Lanes r2 = x * x + y * y + z * z, share2 = r2 * inverse2;
        const LaneMask acts = (share2 < 1.0) & (share2 > 0.0) & mask_of_bits(bits[-1]);
        if (bits_of_mask(acts) == 0) continue;
        const ResponseLanes b(responses, partners);
        const Lanes w = select(acts, weight_of(share2) * a.volume * b.volume, zero);
        const Lanes from_own = select(a.failed < b.failed, zero, w);
        const Lanes from_partner = select(b.failed < a.failed, zero, w);
        Lanes t[9];
        for (int k = 0; k < 9; ++k) t[k] = from_own * a.t[k] + from_partner * b.t[k];

        const Lanes u = (b.u - a.u) * x + (b.v - a.v) * y + (b.w - a.w) * z;  // r dr/dt
        const Lanes g_own = a.stretching(x, y, z), g_partner = b.stretching(x, y, z);
        const Lanes left = u - 0.5 * limiter(g_own, g_partner) * (g_own + g_partner);
        const Lanes mu = left * inverse_sqrt(r2);
        Lanes q = select(mu < 0.0, mu * ((a.linear + b.linear) - (a.square + b.square) * mu), zero);
        q *= w;

        const Lanes px = t[0] * x + t[1] * y + t[2] * z + q * x;
        const Lanes py = t[3] * x + t[4] * y + t[5] * z + q * y;
        const Lanes pz = t[6] * x + t[7] * y + t[8] * z + q * z;
        const Lanes half = 0.5 * q * u;
        fx += px;
        fy += py;
        fz += pz;
        power += half;
        add_half<4>(-px, -py, -pz, half, partners, sums);
      }
      add_half<4>(fx, fy, fz, power, own, sums);
    }
    for (Index r = 0; r < window.count; ++r) finish(window.rows[r] / doubles_a_row);
  }
}

}  // namespace spall
