// Every pair once: tiles of bodies against tiles, eight bodies at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/gravity_direct.hpp"

#include <algorithm>

#include "spall/force/attract.hpp"

namespace spall {
namespace {

constexpr std::size_t tile = 32;        // eights: 256 bodies and their sums stay in the L1 cache
constexpr std::size_t body_width = 7;   // doubles a body sends
constexpr std::size_t field_width = 5;  // doubles a body gets back

/// This rank's share of the pairs of tiles, dealt out in turn.
template <bool rates>
void attract_share(const Comm& comm, std::span<Eight> all) {
  const auto tile_at = [&](std::size_t first) {
    return all.subspan(first, std::min(tile, all.size() - first));
  };
  std::size_t dealt = 0;
  for (std::size_t i = 0; i < all.size(); i += tile)
    for (std::size_t j = i; j < all.size(); j += tile) {
      if (dealt++ % comm.size != static_cast<std::size_t>(comm.rank)) continue;
      const std::span<Eight> sources[] = {tile_at(j)};
      if (i == j)
        attract<false, rates>(tile_at(i), sources);
      else
        attract<true, rates>(tile_at(i), sources);
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
  const bool rates = comm.any(!velocity.empty());
  std::vector<double> rows(owned * body_width);
  for (std::size_t b = 0; b < owned; ++b) {
    double* row = rows.data() + b * body_width;
    Vec3::Map(row) = position[b];
    Vec3::Map(row + 3) = rates ? velocity[b] : Vec3::Zero();
    row[6] = mass[b];
  }
  rows = comm.all_gather(rows);
  std::vector<Eight> all = pack(rows);
  if (rates)
    attract_share<true>(comm, all);
  else
    attract_share<false>(comm, all);

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
  field.rate.resize(rates ? owned : 0);
  const auto first = static_cast<std::size_t>(comm.sum_before(static_cast<std::int64_t>(owned)));
  // d/dt of d/d^3 is (1 - 3 n n^T) dv / d^3, and that matrix stretches by at most 2.
  const double bound = 2 * (1 + estimate_error);
  for (std::size_t b = 0; b < owned; ++b) {
    const double* row = sums.data() + (first + b) * field_width;
    field.acceleration[b] = constant * Vec3::Map(row);
    field.potential[b] = -constant * row[3];
    if (rates) field.rate[b] = constant * bound * row[4];
  }
  return field;
}

}  // namespace spall
