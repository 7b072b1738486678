// Every pair once: tiles of bodies against tiles, eight bodies at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/direct.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/kernels.hpp"
#include "base/reduce.hpp"
#include "gravity/attract.hpp"

namespace spall {
namespace {

constexpr std::size_t tile = 32;  // eights: 256 bodies and their sums stay in the L1 cache

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
std::vector<Eight> pack(std::span<const double> rows, bool rates) {
  const std::size_t width = body_width(rates), count = rows.size() / width;
  std::vector<Eight> all((count + lane_count - 1) / lane_count);
  for (std::size_t b = 0; b < all.size() * lane_count; ++b)
    put_body(rows.data() + std::min(b, count - 1) * width, rates, b < count, all[b / lane_count],
             b % lane_count);
  return all;
}

}  // namespace

SPALL_KERNEL(GravityField, evaluate_gravity_direct,
             (const Comm& comm, double constant, std::span<const double> mass,
              std::span<const Vec3> position, std::span<const Vec3> velocity, bool rates),
             (comm, constant, mass, position, velocity, rates)) {
  const std::size_t owned = mass.size();
  const std::size_t width = body_width(rates);
  std::vector<double> rows(owned * width);
  for (std::size_t b = 0; b < owned; ++b)
    write_body(position[b], mass[b], rates ? &velocity[b] : nullptr, rows.data() + b * width);
  std::size_t first = 0;
  rows = all_gather(comm, rows, first);
  first /= width;
  std::vector<Eight> all = pack(rows, rates);
  if (rates)
    attract_share<true>(comm, all);
  else
    attract_share<false>(comm, all);

  const std::size_t count = rows.size() / width;
  const std::size_t felt = felt_width(rates);
  std::vector<double> sums(count * felt);
  for (std::size_t b = 0; b < count; ++b)
    get_felt(all[b / lane_count], b % lane_count, rates, sums.data() + b * felt);
  comm.sum(sums);

  GravityField field;
  field.acceleration.resize(owned);
  field.potential.resize(owned);
  field.rate.resize(rates ? owned : 0);
  // d/dt of d/d^3 is (1 - 3 n n^T) dv / d^3, and that matrix stretches by at most 2.
  const double bound = 2 * (1 + estimate_error);
  for (std::size_t b = 0; b < owned; ++b) {
    const double* row = sums.data() + (first + b) * felt;
    field.acceleration[b] = constant * Vec3::Map(row);
    field.potential[b] = -constant * row[3];
    if (rates) field.rate[b] = constant * bound * row[4];
  }
  return field;
}

SPALL_KERNEL(GravityField, evaluate_gravity_direct_at,
             (const Comm& comm, double constant, std::span<const double> mass,
              std::span<const Vec3> position, std::span<const Vec3> places),
             (comm, constant, mass, position, places)) {
  std::array<std::vector<double>, 4> all;  // x, y, z, constant times mass
  for (std::size_t k = 0; k < all.size(); ++k) {
    std::vector<double> mine(mass.size());
    for (std::size_t b = 0; b < mass.size(); ++b)
      mine[b] = k < 3 ? position[b][static_cast<Index>(k)] : constant * mass[b];
    all[k] = comm.all_gather(mine);
  }
  const auto& [xs, ys, zs, pulls] = all;
  GravityField field;
  for (const Vec3& place : places) {
    double ax = 0, ay = 0, az = 0, potential = 0;
    for (std::size_t b = 0; b < pulls.size(); ++b) {
      const double x = xs[b] - place.x(), y = ys[b] - place.y(), z = zs[b] - place.z();
      const double r2 = x * x + y * y + z * z;
      const double inverse = r2 > 0 ? 1 / std::sqrt(r2) : 0;
      const double share = pulls[b] * inverse, per_r2 = share * inverse * inverse;
      ax += per_r2 * x;
      ay += per_r2 * y;
      az += per_r2 * z;
      potential -= share;
    }
    field.acceleration.emplace_back(ax, ay, az);
    field.potential.push_back(potential);
  }
  return field;
}

}  // namespace spall
