// One sphere, lattices, random sequential addition of equal spheres, bodies of an earlier run.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/packing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double slack = 1e-9;  // of a radius or spacing: a box of exactly n layers holds n

/// Calls `visit` with every site of the lattice with spacing `d` in the box [0, room].
template <class Visit>
void visit_sites(LatticeKind kind, double d, const Vec3& room, Visit&& visit) {
  // Rows of spheres along x; every second row and layer of fcc and hcp lies in the gaps of the
  // last.
  const auto site = [&](int i, int j, int k) -> Vec3 {
    const double shift = (j + k) % 2;
    switch (kind) {
      case LatticeKind::simple_cubic:
        return d * Vec3(i, j, k);
      case LatticeKind::fcc:
        return d * std::sqrt(0.5) * Vec3(2 * i + shift, j, k);
      case LatticeKind::hcp:
        return d *
               Vec3(i + shift / 2, std::sqrt(3.0) / 2 * (j + k % 2 / 3.0), std::sqrt(2.0 / 3) * k);
    }
    return Vec3::Zero();
  };
  const Vec3 end = room.array() + slack * d;
  for (int k = 0; site(0, 0, k).z() <= end.z(); ++k)
    for (int j = 0; site(0, j, k).y() <= end.y(); ++j)
      for (int i = 0; site(i, j, k).x() <= end.x(); ++i) visit(site(i, j, k));
}

/// In [0, 1). The standard distributions differ from library to library; the engine does not.
double uniform(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

double spacing_of(const Packing& packing) {
  return packing.spacing.value_or(2 * packing.radius);
}

void read_nothing(Section&, Packing&) {}

void place_single(const PackingRequest& request) {
  request.put(request.volume.center, request.packing.radius, {});
}

void read_random(Section& in, Packing& packing) {
  std::int64_t count = 0;
  in.need("count", "of random: spheres wholly inside the volume", count, 1);
  packing.count = count;
}

void place_random(const PackingRequest& request) {
  const double radius = request.packing.radius;
  const std::int64_t count = request.packing.count.value();
  const std::int64_t placed = place_at_random(
      request.volume, request.packing, request.seed,
      [&](const Vec3& center) { return request.is_free(center, radius); },
      [&](const Vec3& center) { request.put(center, radius, {}); });
  const double share = ball_volume(radius) / volume_of(request.volume);
  require(
      placed == count,
      "{}: {} spheres of radius {} m would be {:.3f} of the volume; {} ({:.3f}) found a place at "
      "random: enlarge the volume (random packings end near 0.38) or take a lattice",
      request.place, count, radius, static_cast<double>(count) * share, placed,
      static_cast<double>(placed) * share);
}

constexpr Choice<Orientation> orientations[] = {{"rotation", Orientation::rotation},
                                                {"random", Orientation::random}};

void read_lattice(Section& in, Packing& packing) {
  in.take("spacing", "of lattices, between neighbours; 2 radius", packing.spacing,
          positive(dimension::length));
  const double diameter = 2 * packing.radius, spacing = packing.spacing.value_or(diameter);
  in.check("spacing", spacing >= diameter * (1 - 1e-9),
           fmt::format("= {} m is less than the spheres' diameter, {} m", spacing, diameter));
  in.take("orientation", "of lattices: random is drawn by seed, another for each group",
          packing.orientation, orientations);
}

Lattice simple_cubic(const Packing& packing) {
  return {6, 1, spacing_of(packing)};
}
Lattice close_packed(const Packing& packing) {
  return {12, std::sqrt(0.5), spacing_of(packing)};
}

template <LatticeKind kind>
void place_sites(const PackingRequest& request) {
  place_lattice(kind, request.volume, request.packing,
                [&](const Vec3& center) { request.put(center, request.packing.radius, {}); });
}

void read_file(Section& in, Packing& packing) {
  in.need("file",
          "of file: a restart file, beside the case; bodies at rest, centre of mass at center",
          packing.file);
}

/// Those bodies of an earlier run that have their centres in the volume.
void place_stored(const PackingRequest& request) {
  const Vec3& turn = request.packing.rotation;
  const Eigen::Matrix3d rotation(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
  for (const StoredBody& body : request.packing.stored) {
    const Vec3 center = request.volume.center + rotation * body.position;
    if (depth(request.volume, center) >= 0) request.put(center, body.radius, body.mass);
  }
}

}  // namespace

extern const PackingType random_packing, simple_cubic_packing, fcc_packing, hcp_packing;
extern const PackingType file_packing;
const PackingType single_packing{
    .name = "single", .sized = false, .read = read_nothing, .place = place_single};
const PackingType random_packing{
    .name = "random", .keeps_clear = true, .read = read_random, .place = place_random};
const PackingType simple_cubic_packing{.name = "simple_cubic",
                                       .turns = true,
                                       .read = read_lattice,
                                       .lattice = simple_cubic,
                                       .place = place_sites<LatticeKind::simple_cubic>};
const PackingType fcc_packing{.name = "fcc",
                              .turns = true,
                              .read = read_lattice,
                              .lattice = close_packed,
                              .place = place_sites<LatticeKind::fcc>};
const PackingType hcp_packing{.name = "hcp",
                              .turns = true,
                              .read = read_lattice,
                              .lattice = close_packed,
                              .place = place_sites<LatticeKind::hcp>};
const PackingType file_packing{
    .name = "file", .sized = false, .turns = true, .read = read_file, .place = place_stored};

Lattice lattice_of(const Packing& packing) {
  if (packing.type->lattice) return packing.type->lattice(packing);
  return {0, pi / 6, 2 * packing.radius};
}

/// Shoemake 1992, "Uniform random rotations": a quaternion with two random angles.
Vec3 random_rotation(std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  const double u = uniform(engine), a = 2 * pi * uniform(engine), b = 2 * pi * uniform(engine);
  const double s = std::sqrt(1 - u), c = std::sqrt(u);
  const Eigen::AngleAxisd turn(
      Eigen::Quaterniond(c * std::cos(b), s * std::sin(a), s * std::cos(a), c * std::sin(b)));
  return turn.angle() * turn.axis();
}

SphereGrid::SphereGrid(const Vec3& center, const Vec3& half, double radius, std::int64_t expected)
    : low_(center - half) {
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
  return find(point, distance, [&](std::int64_t sphere) {
    return (centers_[sphere] - point).squaredNorm() < distance * distance;
  });
}

void SphereSet::add(const Vec3& center, double radius) {
  const int power = static_cast<int>(std::ceil(std::log2(radius)));
  auto level = levels_.find(power);
  if (level == levels_.end()) {
    const double largest = std::ldexp(1.0, power);
    level =
        levels_.emplace(power, Level{{center_, half_, largest, expected_}, largest, {}, {}}).first;
  }
  level->second.grid.add(center);
  level->second.radius.push_back(radius);
  level->second.sphere.push_back(count_++);
}

std::optional<SphereSet::Overlap> SphereSet::find_overlap(const Vec3& center, double radius,
                                                          double allowed) const {
  for (const auto& [power, level] : levels_) {
    const auto reach = [&](std::int64_t k) {
      return radius + level.radius[k] - allowed * std::min(radius, level.radius[k]);
    };
    const std::int64_t hit = level.grid.find(center, radius + level.largest, [&](std::int64_t k) {
      return (level.grid.center(k) - center).squaredNorm() < reach(k) * reach(k);
    });
    if (hit < 0) continue;
    const Vec3& at = level.grid.center(hit);
    return Overlap{level.sphere[hit], at, level.radius[hit],
                   radius + level.radius[hit] - (at - center).norm()};
  }
  return std::nullopt;
}

void place_lattice(LatticeKind kind, const Volume& volume, const Packing& packing,
                   const std::function<void(const Vec3&)>& place) {
  const double d = spacing_of(packing);
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
  const auto visit = [&](auto&& f) { visit_sites(kind, d, room, f); };
  visit([&](const Vec3& site) { extent = extent.cwiseMax(site); });
  visit([&](const Vec3& site) {
    const Vec3 center = volume.center + rotation * (site - extent / 2);
    if (depth(volume, center) >= -slack * d) place(center);
  });
}

std::int64_t place_at_random(const Volume& volume, const Packing& packing, std::uint64_t seed,
                             const std::function<bool(const Vec3&)>& is_free,
                             const std::function<void(const Vec3&)>& place) {
  const double r = packing.radius;
  const std::int64_t count = packing.count.value();
  const Vec3 room = half_widths(volume) - Vec3::Constant(r);  // of centres
  if ((room.array() < 0).any()) return 0;

  std::mt19937_64 engine(seed);
  const auto coordinate = [&] { return 2 * uniform(engine) - 1; };

  SphereGrid grid(volume.center, half_widths(volume), r, count);
  const std::int64_t most_tries_in_vain = 2'000'000;
  std::int64_t placed = 0;
  for (std::int64_t in_vain = 0; placed < count && in_vain < most_tries_in_vain; ++in_vain) {
    const double x = coordinate(), y = coordinate(), z = coordinate();
    const Vec3 center = volume.center + room.cwiseProduct(Vec3(x, y, z));
    if (depth(volume, center) < r || grid.find_nearer(center, 2 * r) >= 0 || !is_free(center))
      continue;
    grid.add(center);
    place(center);
    ++placed;
    in_vain = 0;
  }
  return placed;
}

}  // namespace spall
