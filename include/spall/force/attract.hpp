// Bodies that attract each other pair by pair, eight at a time: the kernel of both gravity methods.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>

#include "spall/force/lanes.hpp"

namespace spall {

/// Before the factor G: sums of m d/d^3, m/d and m |dv|/d^3.
struct Pull {
  Lanes x{}, y{}, z{}, potential{}, rate{};
};

/// Eight bodies and what they feel. Unused places hold massless copies of another body.
struct Eight {
  Lanes x, y, z, vx, vy, vz, mass;
  Pull pull;
};

/// Bodies and what they feel as they travel between ranks.
inline constexpr int body_width = 7;  ///< doubles: position, velocity, mass
inline constexpr int felt_width = 5;  ///< doubles: sums of m d/d^3, m/d, m |dv|/d^3

/// A body into its place; `present` false makes it massless, a copy that fills up its eight.
inline void put_body(const double* row, bool present, Eight& eight, std::size_t lane) {
  eight.x[lane] = row[0];
  eight.y[lane] = row[1];
  eight.z[lane] = row[2];
  eight.vx[lane] = row[3];
  eight.vy[lane] = row[4];
  eight.vz[lane] = row[5];
  eight.mass[lane] = present ? row[6] : 0.0;
}

inline void get_felt(const Eight& eight, std::size_t lane, double* row) {
  row[0] = eight.pull.x[lane];
  row[1] = eight.pull.y[lane];
  row[2] = eight.pull.z[lane];
  row[3] = eight.pull.potential[lane];
  row[4] = eight.pull.rate[lane];
}

/// The bodies of `is` feel those of all `sources`; with `mutual` those also feel the bodies of
/// `is`, each pair with the same bits. `rates` false leaves the sums of m |dv|/d^3 out.
template <bool mutual, bool rates>
void attract(std::span<Eight> is, std::span<const std::span<Eight>> sources) {
  constexpr std::size_t at_once = 2;  // bodies held in registers: fewer wait, more spill
  for (Eight& i : is)
    for (std::size_t lane = 0; lane < lane_count; lane += at_once) {
      Pull on_i[at_once];
      for (std::span<Eight> js : sources)
        for (Eight& j : js) {
          Pull on_j = j.pull;
          for (std::size_t u = 0; u < at_once; ++u) {
            const Lanes dx = j.x - i.x[lane + u];
            const Lanes dy = j.y - i.y[lane + u];
            const Lanes dz = j.z - i.z[lane + u];
            const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + dz * dz));
            const Lanes cubed = inverse * inverse * inverse;
            const Lanes weight_i = cubed * j.mass;
            on_i[u].x += weight_i * dx;
            on_i[u].y += weight_i * dy;
            on_i[u].z += weight_i * dz;
            on_i[u].potential += inverse * j.mass;
            const double mass_i = i.mass[lane + u];
            if constexpr (mutual) {
              const Lanes weight_j = cubed * mass_i;
              on_j.x -= weight_j * dx;
              on_j.y -= weight_j * dy;
              on_j.z -= weight_j * dz;
              on_j.potential += inverse * mass_i;
            }
            if constexpr (rates) {
              const Lanes dvx = j.vx - i.vx[lane + u];
              const Lanes dvy = j.vy - i.vy[lane + u];
              const Lanes dvz = j.vz - i.vz[lane + u];
              const Lanes rate = cubed * estimate_sqrt(dvx * dvx + (dvy * dvy + dvz * dvz));
              on_i[u].rate += rate * j.mass;
              if constexpr (mutual) on_j.rate += rate * mass_i;
            }
          }
          if constexpr (mutual) j.pull = on_j;
        }
      for (std::size_t u = 0; u < at_once; ++u) {
        i.pull.x[lane + u] += sum_of_lanes(on_i[u].x);
        i.pull.y[lane + u] += sum_of_lanes(on_i[u].y);
        i.pull.z[lane + u] += sum_of_lanes(on_i[u].z);
        i.pull.potential[lane + u] += sum_of_lanes(on_i[u].potential);
        if constexpr (rates) i.pull.rate[lane + u] += sum_of_lanes(on_i[u].rate);
      }
    }
}

}  // namespace spall
