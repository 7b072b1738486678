// Every pair once: tiles of bodies against tiles, eight bodies at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/gravity_direct.hpp"

#include <algorithm>

#include "spall/force/lanes.hpp"

namespace spall {
namespace {

/// What bodies feel, before the factor G: sums of m d/d^3, -m/d and m |dv|/d^3.
template <class T>
struct Pull {
  T x{}, y{}, z{}, potential{}, rate{};
};

/// Bodies in vectors of eight, one array a component; the last vector is filled up with massless
/// copies of the last body.
struct Packed {
  std::vector<Lanes> x, y, z, vx, vy, vz, mass;
  std::vector<Pull<Lanes>> pull;

  explicit Packed(std::size_t count) {
    const std::size_t vectors = (count + lane_count - 1) / lane_count;
    for (auto* field : {&x, &y, &z, &vx, &vy, &vz, &mass}) field->resize(vectors);
    pull.resize(vectors);
  }
  std::size_t vectors() const { return mass.size(); }
};

constexpr std::size_t tile = 32;        // vectors: 256 bodies and their sums stay in the L1 cache
constexpr std::size_t at_once = 2;      // bodies of tile i held in registers
constexpr std::size_t body_width = 7;   // doubles a body sends
constexpr std::size_t field_width = 5;  // doubles a body gets back

/// Bodies [i0, i1) and [j0, j1) (vectors) attract each other; with `mutual` false only the first
/// feel it, for a tile against itself.
template <bool mutual>
void attract(Packed& all, std::size_t i0, std::size_t i1, std::size_t j0, std::size_t j1) {
  for (std::size_t i = i0; i < i1; ++i)
    for (std::size_t lane = 0; lane < lane_count; lane += at_once) {
      Pull<Lanes> on_i[at_once];
      for (std::size_t j = j0; j < j1; ++j) {
        Pull<Lanes> on_j = all.pull[j];
        for (std::size_t u = 0; u < at_once; ++u) {
          const Lanes dx = all.x[j] - all.x[i][lane + u];
          const Lanes dy = all.y[j] - all.y[i][lane + u];
          const Lanes dz = all.z[j] - all.z[i][lane + u];
          const Lanes dvx = all.vx[j] - all.vx[i][lane + u];
          const Lanes dvy = all.vy[j] - all.vy[i][lane + u];
          const Lanes dvz = all.vz[j] - all.vz[i][lane + u];
          const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + dz * dz));
          const Lanes cubed = inverse * inverse * inverse;
          const Lanes speed_cubed = cubed * sqrt_bound(dvx * dvx + (dvy * dvy + dvz * dvz));
          const Lanes weight_i = cubed * all.mass[j];
          on_i[u].x += weight_i * dx;
          on_i[u].y += weight_i * dy;
          on_i[u].z += weight_i * dz;
          on_i[u].potential -= inverse * all.mass[j];
          on_i[u].rate += speed_cubed * all.mass[j];
          if constexpr (mutual) {
            const double mass_i = all.mass[i][lane + u];
            const Lanes weight_j = cubed * mass_i;
            on_j.x -= weight_j * dx;
            on_j.y -= weight_j * dy;
            on_j.z -= weight_j * dz;
            on_j.potential -= inverse * mass_i;
            on_j.rate += speed_cubed * mass_i;
          }
        }
        if constexpr (mutual) all.pull[j] = on_j;
      }
      for (std::size_t u = 0; u < at_once; ++u) {
        Pull<Lanes>& sum = all.pull[i];
        sum.x[lane + u] += sum_of_lanes(on_i[u].x);
        sum.y[lane + u] += sum_of_lanes(on_i[u].y);
        sum.z[lane + u] += sum_of_lanes(on_i[u].z);
        sum.potential[lane + u] += sum_of_lanes(on_i[u].potential);
        sum.rate[lane + u] += sum_of_lanes(on_i[u].rate);
      }
    }
}

/// This rank's share of the pairs of tiles, dealt out in turn.
void attract_share(const Comm& comm, Packed& all) {
  const std::size_t size = all.vectors();
  std::size_t dealt = 0;
  for (std::size_t i = 0; i < size; i += tile)
    for (std::size_t j = i; j < size; j += tile) {
      if (dealt++ % comm.size != static_cast<std::size_t>(comm.rank)) continue;
      const std::size_t i_end = std::min(i + tile, size), j_end = std::min(j + tile, size);
      if (i == j)
        attract<false>(all, i, i_end, j, j_end);
      else
        attract<true>(all, i, i_end, j, j_end);
    }
}

Packed pack(std::span<const double> rows) {
  const std::size_t count = rows.size() / body_width;
  Packed all(count);
  for (std::size_t b = 0; b < all.vectors() * lane_count; ++b) {
    const double* row = rows.data() + std::min(b, count - 1) * body_width;
    const std::size_t v = b / lane_count, lane = b % lane_count;
    all.x[v][lane] = row[0];
    all.y[v][lane] = row[1];
    all.z[v][lane] = row[2];
    all.vx[v][lane] = row[3];
    all.vy[v][lane] = row[4];
    all.vz[v][lane] = row[5];
    all.mass[v][lane] = b < count ? row[6] : 0.0;
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
  Packed all = pack(rows);
  attract_share(comm, all);

  const std::size_t count = rows.size() / body_width;
  std::vector<double> sums(count * field_width);
  for (std::size_t b = 0; b < count; ++b) {
    const Pull<Lanes>& pull = all.pull[b / lane_count];
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
  for (std::size_t b = 0; b < owned; ++b) {
    const double* row = sums.data() + (first + b) * field_width;
    field.acceleration[b] = constant * Vec3::Map(row);
    field.potential[b] = constant * row[3];
    // d/dt of d/d^3 is (1 - 3 n n^T) dv / d^3, and that matrix stretches by at most 2.
    field.rate[b] = 2 * constant * row[4];
  }
  return field;
}

}  // namespace spall
