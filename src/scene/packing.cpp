// Lattices clipped to a volume, and random sequential addition.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/scene/packing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "spall/base/require.hpp"
#include "spall/scene/shape.hpp"

namespace spall {
namespace {

constexpr double slack = 1e-9;  // of a radius or spacing: a box of exactly n layers holds n

/// Calls `visit` with every site of the lattice with spacing `d` in the box [0, room].
template <class Visit>
void visit_sites(PackingKind kind, double d, const Vec3& room, Visit&& visit) {
  // Sites are (i, j, k) steps, of which fcc leaves out every second; hcp shifts its rows.
  Vec3 step = Vec3::Constant(d);
  if (kind == PackingKind::fcc) step *= std::sqrt(0.5);
  if (kind == PackingKind::hcp) step = d * Vec3(1, std::sqrt(3.0) / 2, std::sqrt(2.0 / 3));
  const Eigen::Array3d last = (room.array() / step.array() + slack).floor();
  for (double k = 0; k <= last.z(); ++k)
    for (double j = 0; j <= last.y(); ++j) {
      const bool odd = std::fmod(j + k, 2) != 0;
      Vec3 row(0, j, k);
      if (kind == PackingKind::hcp) {
        row.x() = odd ? 0.5 : 0;
        row.y() += std::fmod(k, 2) / 3;
        if (row.y() * step.y() > room.y() + slack * d) continue;
      }
      const bool alternate = kind == PackingKind::fcc;
      if (alternate && odd) row.x() = 1;
      for (; row.x() * d <= room.x() * (d / step.x()) + slack * d; row.x() += alternate ? 2 : 1)
        visit(Vec3(row.cwiseProduct(step)));
    }
}

}  // namespace

SphereGrid::SphereGrid(const Vec3& center, const Vec3& half, double radius, std::int64_t expected)
    : low_(center - half), radius_(radius) {
  // Not smaller than a sphere, nor so small that most cells of a thin cloud are empty.
  const double volume = 8 * half.prod();
  cell_ = std::max(2 * radius, std::cbrt(volume / (2.0 * static_cast<double>(expected))));
  cells_ = (2 * half / cell_).array().floor().cast<int>() + 1;
  first_.assign(static_cast<std::size_t>(cells_.cast<std::int64_t>().prod()), -1);
}

Eigen::Array3i SphereGrid::cell_of(const Vec3& point) const {
  const Eigen::Array3d cell = ((point - low_) / cell_).array().floor();
  return cell.max(0).min(cells_.cast<double>() - 1).cast<int>();
}

std::size_t SphereGrid::index_of(const Eigen::Array3i& cell) const {
  return (static_cast<std::size_t>(cell.z()) * cells_.y() + cell.y()) * cells_.x() + cell.x();
}

void SphereGrid::add(const Vec3& center) {
  const Eigen::Array3i cell = cell_of(center);
  auto& first = first_[index_of(cell)];
  next_.push_back(first);
  first = static_cast<std::int32_t>(centers_.size());
  centers_.push_back(center);
}

std::int64_t SphereGrid::find_nearer(const Vec3& point, double distance) const {
  const auto find_in = [&](const Eigen::Array3i& cell) {
    std::int32_t sphere = first_[index_of(cell)];
    while (sphere >= 0 && (centers_[sphere] - point).squaredNorm() >= distance * distance)
      sphere = next_[sphere];
    return sphere;
  };
  // In dense packings most places are taken, most often by a sphere of the point's own cell.
  if (const std::int32_t sphere = find_in(cell_of(point)); sphere >= 0) return sphere;
  // Clamped cells keep what lies beyond the box in its outermost layer, so nothing is missed.
  const Eigen::Array3i low = cell_of(point - Vec3::Constant(distance));
  const Eigen::Array3i high = cell_of(point + Vec3::Constant(distance));
  for (int z = low.z(); z <= high.z(); ++z)
    for (int y = low.y(); y <= high.y(); ++y)
      for (int x = low.x(); x <= high.x(); ++x)
        if (const std::int32_t sphere = find_in({x, y, z}); sphere >= 0) return sphere;
  return -1;
}

void place_lattice(const Volume& volume, const Packing& packing,
                   const std::function<void(const Vec3&)>& place) {
  const double d = packing.spacing.value_or(2 * packing.radius);
  const bool turned = !packing.rotation.isZero(0);
  Vec3 half = half_widths(volume);
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  if (turned) {
    rotation = Eigen::AngleAxisd(packing.rotation.norm(), packing.rotation.normalized());
    half = Vec3::Constant(half.norm());
  }
  const Vec3 room = 2 * half - Vec3::Constant(d);
  if ((room.array() < -slack * d).any()) return;
  Vec3 extent = Vec3::Zero();
  const auto visit = [&](auto&& f) { visit_sites(packing.kind, d, room, f); };
  visit([&](const Vec3& site) { extent = extent.cwiseMax(site); });
  visit([&](const Vec3& site) {
    const Vec3 center = volume.center + rotation * (site - extent / 2);
    if (depth(volume, center) >= -slack * d) place(center);
  });
}

void place_at_random(const Volume& volume, const Packing& packing, std::uint64_t seed,
                     const std::function<bool(const Vec3&)>& is_free,
                     const std::function<void(const Vec3&)>& place) {
  const double r = packing.radius;
  const std::int64_t count = packing.count.value();
  const Vec3 room = half_widths(volume) - Vec3::Constant(r);  // of centres
  const double sphere = 4 * pi / 3 * r * r * r;
  require((room.array() >= 0).all(), "the volume is smaller than one sphere of radius {} m", r);

  // The standard distributions differ from library to library; the engine does not.
  std::mt19937_64 engine(seed);
  const auto uniform = [&] {
    return static_cast<double>(engine() >> 11) * 0x1p-52 - 1;
  };  // [-1, 1)

  SphereGrid grid(volume.center, half_widths(volume), r, count);
  // Near the end of room free places are rare: at 0.36 one try of about 3,000 still finds one.
  const std::int64_t most_tries_in_vain = 2'000'000;
  std::int64_t placed = 0;
  for (std::int64_t in_vain = 0; placed < count && in_vain < most_tries_in_vain; ++in_vain) {
    const double x = uniform(), y = uniform(), z = uniform();
    const Vec3 center = volume.center + room.cwiseProduct(Vec3(x, y, z));
    if (depth(volume, center) < r || grid.find_nearer(center, 2 * r) >= 0 || !is_free(center))
      continue;
    grid.add(center);
    place(center);
    ++placed;
    in_vain = 0;
  }
  require(
      placed == count,
      "{} spheres of radius {} m are asked for, which is {:.3f} of the volume; {} ({:.3f}) found "
      "a place at random: enlarge the volume (random packings end near 0.38) or take a lattice",
      count, r, static_cast<double>(count) * sphere / volume_of(volume), placed,
      static_cast<double>(placed) * sphere / volume_of(volume));
}

}  // namespace spall
