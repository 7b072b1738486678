// Gravity's own methods at the points, then what being inside of a body changes.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/map.hpp"

#include <algorithm>
#include <cmath>

namespace spall {
namespace {

int rank_of(const Grid& grid, std::int64_t point, int ranks) {
  int rank = 0;
  while (part_begin(grid.total(), rank + 1, ranks) <= point) ++rank;
  return rank;
}

/// Calls f(point, place) for the points nearer than `radius` to `center`.
template <class F>
void for_each_inside(const Grid& grid, const Vec3& center, double radius, F&& f) {
  std::array<std::int64_t, 3> low, high;
  for (int k = 0; k < 3; ++k) {
    const double at = (center[k] - grid.low[k]) / grid.spacing, reach = radius / grid.spacing;
    const auto last = static_cast<double>(grid.counts[k] - 1);
    low[k] = static_cast<std::int64_t>(std::clamp(std::floor(at - reach), 0.0, last));
    high[k] = static_cast<std::int64_t>(std::clamp(std::ceil(at + reach), 0.0, last));
  }
  for (std::int64_t z = low[2]; z <= high[2]; ++z)
    for (std::int64_t y = low[1]; y <= high[1]; ++y)
      for (std::int64_t x = low[0]; x <= high[0]; ++x) {
        const std::int64_t point = x + grid.counts[0] * (y + grid.counts[1] * z);
        const Vec3 place = grid.place(point);
        if ((place - center).squaredNorm() < radius * radius) f(point, place);
      }
}

/// What a uniform sphere's field inside of it differs from that of its mass at its centre, as rows
/// of point, potential and acceleration for the ranks that hold the points.
ByRank<double> corrections(const Comm& comm, double constant, const Bodies& bodies,
                           const Grid& grid) {
  ByRank<double> rows;
  for (Index b = 0; b < bodies.owned; ++b) {
    const double r = bodies.radius[b], gm = constant * bodies.mass[b];
    for_each_inside(grid, bodies.position[b], r, [&](std::int64_t point, const Vec3& place) {
      const Vec3 to_centre = bodies.position[b] - place;
      const double d = to_centre.norm();
      const double inverse = d > 0 ? 1 / d : 0;  // gravity leaves coincident bodies out
      const double potential = gm * (inverse - (3 - d * d / (r * r)) / (2 * r));
      const Vec3 pull = gm * (1 / (r * r * r) - inverse * inverse * inverse) * to_centre;
      std::vector<double>& row = rows[rank_of(grid, point, comm.size)];
      row.insert(row.end(), {static_cast<double>(point), potential, pull.x(), pull.y(), pull.z()});
    });
  }
  return rows;
}

}  // namespace

Grid Grid::in_box(const Vec3& center, const Vec3& size, double spacing) {
  Grid grid;
  grid.spacing = spacing;
  for (int k = 0; k < 3; ++k) {
    // A size that is a multiple of the spacing gets its last point in spite of round-off.
    grid.counts[k] = 1 + static_cast<std::int64_t>(size[k] / spacing * (1 + 1e-12));
    grid.low[k] = center[k] - spacing * static_cast<double>(grid.counts[k] - 1) / 2;
  }
  return grid;
}

Vec3 Grid::place(std::int64_t point) const {
  const auto x = point % counts[0], y = point / counts[0] % counts[1],
             z = point / counts[0] / counts[1];
  return low +
         spacing * Vec3(static_cast<double>(x), static_cast<double>(y), static_cast<double>(z));
}

GravityMap map_gravity(const Comm& comm, const GravitySettings& settings, const Bodies& bodies,
                       const Grid& grid) {
  GravityMap map;
  map.first = part_begin(grid.total(), comm.rank, comm.size);
  const std::int64_t end = part_begin(grid.total(), comm.rank + 1, comm.size);
  std::vector<Vec3> places;
  for (std::int64_t point = map.first; point < end; ++point) places.push_back(grid.place(point));
  const auto owned = static_cast<std::size_t>(bodies.owned);
  GravityField field = evaluate_gravity_at(comm, settings, std::span(bodies.mass).first(owned),
                                           std::span(bodies.position).first(owned), places);
  map.potential = std::move(field.potential);
  map.acceleration = std::move(field.acceleration);
  constexpr std::size_t width = 5;
  for (const auto& [rank, rows] : comm.exchange(corrections(comm, settings.constant, bodies, grid)))
    for (std::size_t at = 0; at < rows.size(); at += width) {
      const auto k = static_cast<std::size_t>(rows[at]) - static_cast<std::size_t>(map.first);
      map.potential[k] += rows[at + 1];
      map.acceleration[k] += Vec3::Map(&rows[at + 2]);
    }
  return map;
}

}  // namespace spall
