// Bodies that attract each other pair by pair, eight at a time: the kernel of both gravity methods.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>

#include "spall/lanes.hpp"
#include "spall/types.hpp"

namespace spall {

/// Before the factor G: sums of m d/d^3, m/d and m |dv|/d^3.
template <class V>
struct PullOf {
  V x{}, y{}, z{}, potential{}, rate{};
};
using Pull = PullOf<Lanes>;

/// Eight bodies and what they feel, one a lane. Lanes that are left over hold massless copies of
/// another body.
struct Eight {
  Lanes x, y, z, vx, vy, vz, mass;
  Pull pull;
};

/// Bodies and what they feel as they travel between ranks: doubles in a row.
constexpr int body_width(bool rates) {
  return rates ? 7 : 4;  // position, mass, velocity
}
constexpr int felt_width(bool rates) {
  return rates ? 5 : 4;  // sums of m d/d^3, m/d, m |dv|/d^3
}

/// Without a velocity the row is the narrow one.
inline void write_body(const Vec3& position, double mass, const Vec3* velocity, double* row) {
  Vec3::Map(row) = position;
  row[3] = mass;
  if (velocity) Vec3::Map(row + 4) = *velocity;
}

/// A body into its place; `present` false makes it massless, a copy that fills up its eight.
inline void put_body(const double* row, bool rates, bool present, Eight& eight, std::size_t lane) {
  eight.x[lane] = row[0];
  eight.y[lane] = row[1];
  eight.z[lane] = row[2];
  eight.mass[lane] = present ? row[3] : 0.0;
  eight.vx[lane] = rates ? row[4] : 0.0;
  eight.vy[lane] = rates ? row[5] : 0.0;
  eight.vz[lane] = rates ? row[6] : 0.0;
}

inline void get_felt(const Eight& eight, std::size_t lane, bool rates, double* row) {
  row[0] = eight.pull.x[lane];
  row[1] = eight.pull.y[lane];
  row[2] = eight.pull.z[lane];
  row[3] = eight.pull.potential[lane];
  if (rates) row[4] = eight.pull.rate[lane];
}

/// The bodies of `is` feel those of all `sources`. With `mutual` the sources feel the bodies of
/// `is` as well, each pair with the same bits. Without `rates` the sums of m |dv|/d^3 are left
/// out.
template <bool mutual, bool rates>
void attract(std::span<Eight> is, std::span<const std::span<Eight>> sources) {
  using V = RegisterLanes;
  constexpr std::size_t at_once = 2;  // bodies held in registers: fewer wait, more spill
  for (Eight& i : is)
    for (std::size_t lane = 0; lane < lane_count; lane += at_once) {
      PullOf<V> on_i[at_once];
      for (std::span<Eight> js : sources)
        for (Eight& j : js)
          for (std::size_t k = 0; k < lane_count; k += register_lanes) {
            const V jx = part_of(j.x, k), jy = part_of(j.y, k), jz = part_of(j.z, k);
            const V mass_j = part_of(j.mass, k);
            PullOf<V> on_j;
            for (std::size_t u = 0; u < at_once; ++u) {
              const V dx = jx - i.x[lane + u], dy = jy - i.y[lane + u], dz = jz - i.z[lane + u];
              const V inverse = inverse_sqrt(dx * dx + (dy * dy + dz * dz));
              const V cubed = inverse * inverse * inverse;
              const V weight_i = cubed * mass_j;
              on_i[u].x += weight_i * dx;
              on_i[u].y += weight_i * dy;
              on_i[u].z += weight_i * dz;
              on_i[u].potential += inverse * mass_j;
              const double mass_i = i.mass[lane + u];
              if constexpr (mutual) {
                const V weight_j = cubed * mass_i;
                on_j.x -= weight_j * dx;
                on_j.y -= weight_j * dy;
                on_j.z -= weight_j * dz;
                on_j.potential += inverse * mass_i;
              }
              if constexpr (rates) {
                const V dvx = part_of(j.vx, k) - i.vx[lane + u];
                const V dvy = part_of(j.vy, k) - i.vy[lane + u];
                const V dvz = part_of(j.vz, k) - i.vz[lane + u];
                const V rate = cubed * estimate_sqrt(dvx * dvx + (dvy * dvy + dvz * dvz));
                on_i[u].rate += rate * mass_j;
                if constexpr (mutual) on_j.rate += rate * mass_i;
              }
            }
            if constexpr (mutual) {
              part_of(j.pull.x, k) += on_j.x;
              part_of(j.pull.y, k) += on_j.y;
              part_of(j.pull.z, k) += on_j.z;
              part_of(j.pull.potential, k) += on_j.potential;
              if constexpr (rates) part_of(j.pull.rate, k) += on_j.rate;
            }
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
