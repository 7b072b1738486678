// Every pair once: tiles of bodies against tiles, eight bodies at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/gravity_direct.hpp"

#include <algorithm>

#include "spall/force/lanes.hpp"

namespace spall {
namespace {

/// Before the factor G: sums of m d/d^3, -m/d and m |dv|/d^3.
struct Pull {
  Lanes x{}, y{}, z{}, potential{}, rate{};
};

/// Eight bodies and what they feel.
struct Eight {
  Lanes x, y, z, vx, vy, vz, mass;
  Pull pull;
};

constexpr std::size_t tile = 32;        // eights: 256 bodies and their sums stay in the L1 cache
constexpr std::size_t at_once = 2;      // bodies of tile i held in registers
constexpr std::size_t body_width = 7;   // doubles a body sends
constexpr std::size_t field_width = 5;  // doubles a body gets back

/// The bodies of `is` and `js` attract each other; with `mutual` false only the first feel it, for
/// a tile against itself.
template <bool mutual>
void attract(std::span<Eight> is, std::span<Eight> js) {
  for (Eight& i : is)
    for (std::size_t lane = 0; lane < lane_count; lane += at_once) {
      Pull on_i[at_once];
      for (Eight& j : js) {
        Pull on_j = j.pull;
        for (std::size_t u = 0; u < at_once; ++u) {
          const Lanes dx = j.x - i.x[lane + u];
          const Lanes dy = j.y - i.y[lane + u];
          const Lanes dz = j.z - i.z[lane + u];
          const Lanes dvx = j.vx - i.vx[lane + u];
          const Lanes dvy = j.vy - i.vy[lane + u];
          const Lanes dvz = j.vz - i.vz[lane + u];
          const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + dz * dz));
          const Lanes cubed = inverse * inverse * inverse;
          const Lanes rate = cubed * estimate_sqrt(dvx * dvx + (dvy * dvy + dvz * dvz));
          const Lanes weight_i = cubed * j.mass;
          on_i[u].x += weight_i * dx;
          on_i[u].y += weight_i * dy;
          on_i[u].z += weight_i * dz;
          on_i[u].potential -= inverse * j.mass;
          on_i[u].rate += rate * j.mass;
          if constexpr (mutual) {
            const double mass_i = i.mass[lane + u];
            const Lanes weight_j = cubed * mass_i;
            on_j.x -= weight_j * dx;
            on_j.y -= weight_j * dy;
            on_j.z -= weight_j * dz;
            on_j.potential -= inverse * mass_i;
            on_j.rate += rate * mass_i;
          }
        }
        if constexpr (mutual) j.pull = on_j;
      }
      for (std::size_t u = 0; u < at_once; ++u) {
        i.pull.x[lane + u] += sum_of_lanes(on_i[u].x);
        i.pull.y[lane + u] += sum_of_lanes(on_i[u].y);
        i.pull.z[lane + u] += sum_of_lanes(on_i[u].z);
        i.pull.potential[lane + u] += sum_of_lanes(on_i[u].potential);
        i.pull.rate[lane + u] += sum_of_lanes(on_i[u].rate);
      }
    }
}

/// This rank's share of the pairs of tiles, dealt out in turn.
void attract_share(const Comm& comm, std::span<Eight> all) {
  const auto tile_at = [&](std::size_t first) {
    return all.subspan(first, std::min(tile, all.size() - first));
  };
  std::size_t dealt = 0;
  for (std::size_t i = 0; i < all.size(); i += tile)
    for (std::size_t j = i; j < all.size(); j += tile) {
      if (dealt++ % comm.size != static_cast<std::size_t>(comm.rank)) continue;
      if (i == j)
        attract<false>(tile_at(i), tile_at(j));
      else
        attract<true>(tile_at(i), tile_at(j));
    }
}

/// The last eight is filled up with massless copies of the last body.
std::vector<Eight> pack(std::span<const double> rows) {
  const std::size_t count = rows.size() / body_width;
  std::vector<Eight> all((count + lane_count - 1) / lane_count);
  for (std::size_t b = 0; b < all.size() * lane_count; ++b) {
    const double* row = rows.data() + std::min(b, count - 1) * body_width;
    Eight& eight = all[b / lane_count];
    const std::size_t lane = b % lane_count;
    eight.x[lane] = row[0];
    eight.y[lane] = row[1];
    eight.z[lane] = row[2];
    eight.vx[lane] = row[3];
    eight.vy[lane] = row[4];
    eight.vz[lane] = row[5];
    eight.mass[lane] = b < count ? row[6] : 0.0;
  }
  return all;
}

}  // namespace

GravityField evaluate_gravity_direct(const Comm& comm, double constant,
                                     std::span<const double> mass, std::span<const Vec3> position,
                                     std::span<const Vec3> velocity) {
  const std::size_t owned = mass.size();
  std::vector<double> rows(owned * body_width);
  for (std::size_t b = 0; b < owned; ++b) {
    double* row = rows.data() + b * body_width;
    Vec3::Map(row) = position[b];
    Vec3::Map(row + 3) = velocity[b];
    row[6] = mass[b];
  }
  rows = comm.all_gather(rows);
  std::vector<Eight> all = pack(rows);
  attract_share(comm, all);

  const std::size_t count = rows.size() / body_width;
  std::vector<double> sums(count * field_width);
  for (std::size_t b = 0; b < count; ++b) {
    const Pull& pull = all[b / lane_count].pull;
    const std::size_t lane = b % lane_count;
    double* row = sums.data() + b * field_width;
    row[0] = pull.x[lane];
    row[1] = pull.y[lane];
    row[2] = pull.z[lane];
    row[3] = pull.potential[lane];
    row[4] = pull.rate[lane];
  }
  comm.sum(sums);

  GravityField field;
  field.acceleration.resize(owned);
  field.potential.resize(owned);
  field.rate.resize(owned);
  const auto first = static_cast<std::size_t>(comm.sum_before(static_cast<std::int64_t>(owned)));
  // d/dt of d/d^3 is (1 - 3 n n^T) dv / d^3, and that matrix stretches by at most 2.
  const double bound = 2 * (1 + estimate_error);
  for (std::size_t b = 0; b < owned; ++b) {
    const double* row = sums.data() + (first + b) * field_width;
    field.acceleration[b] = constant * Vec3::Map(row);
    field.potential[b] = constant * row[3];
    field.rate[b] = constant * bound * row[4];
  }
  return field;
}

}  // namespace spall
