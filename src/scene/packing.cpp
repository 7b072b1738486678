// One sphere, lattices, random sequential addition of equal spheres, bodies of an earlier run.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/packing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/hash.hpp"
#include "base/random.hpp"
#include "scene/shape.hpp"
#include "scene/sizes.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double slack = 1e-9;  // of a radius or spacing: a box of exactly n layers holds n

/// The sites of a lattice with spacing `d` in the box [0, room]: rows along x; every second row and
/// layer of fcc and hcp lies in the gaps of the last.
class Sites {
 public:
  Sites(LatticeKind kind, double d, const Vec3& room)
      : kind_(kind), d_(d), end_(room.array() + slack * d) {}

  Vec3 at(int i, int j, int k) const {
    const double shift = (j + k) % 2;
    switch (kind_) {
      case LatticeKind::simple_cubic:
        return d_ * Vec3(i, j, k);
      case LatticeKind::fcc:
        return d_ * std::sqrt(0.5) * Vec3(2 * i + shift, j, k);
      case LatticeKind::hcp:
        return d_ *
               Vec3(i + shift / 2, std::sqrt(3.0) / 2 * (j + k % 2 / 3.0), std::sqrt(2.0 / 3) * k);
    }
    return Vec3::Zero();
  }

  /// Calls `f(j, k, count)` for every row that has sites.
  template <class F>
  void for_each_row(F&& f) const {
    const double step = at(1, 0, 0).x();
    for (int k = 0; at(0, 0, k).z() <= end_.z(); ++k)
      for (int j = 0; at(0, j, k).y() <= end_.y(); ++j) {
        int count = std::max(0, static_cast<int>((end_.x() - at(0, j, k).x()) / step));
        while (at(count, j, k).x() <= end_.x()) ++count;
        if (count > 0) f(j, k, count);
      }
  }

 private:
  LatticeKind kind_;
  double d_;
  Vec3 end_;
};

/// Narrows [first, last] to the numbers i, rounded outwards, for which `from` + i `step` lies in
/// the box 0 +- `half`.
void clip(const Vec3& from, const Vec3& step, const Vec3& half, double& first, double& last) {
  for (int axis = 0; axis < 3; ++axis) {
    if (step[axis] == 0) {
      if (std::abs(from[axis]) > half[axis]) last = first - 1;
      continue;
    }
    const double one = (-half[axis] - from[axis]) / step[axis];
    const double other = (half[axis] - from[axis]) / step[axis];
    first = std::max(first, std::floor(std::min(one, other)));
    last = std::min(last, std::ceil(std::max(one, other)));
  }
}

double spacing_of(const Packing& packing) {
  return packing.spacing.value_or(2 * packing.radius);
}

void read_nothing(Section&, Packing&) {}

void place_single(const PackingRequest& request) {
  request.put({.center = request.volume.center, .radius = request.packing.radius});
}

void read_random(Section& in, Packing& packing) {
  std::int64_t count = 0;
  in.need("count", "of random: spheres wholly inside the volume", count, 1);
  in.check("count", static_cast<double>(count) <= most_spheres,
           fmt::format("= {}: a group has at most {:.0f} spheres", count, most_spheres));
  packing.count = count;
  for (const char* one : {"radius", "diameter"})
    in.check(one, !in.has(one) || !in.has("sizes"), "is given beside sizes: give one of them");
  Sizes sizes;
  if (!in.table("sizes", "of random, in place of radius: unequal spheres",
                [&](Section& s) { read_sizes(s, sizes, count); }))
    return;
  packing.radius = sizes.largest;
  packing.own = sizes;
}

std::vector<double> radii_at_random(const Packing& packing, std::uint64_t seed) {
  const std::int64_t count = packing.count.value();
  const auto* sizes = std::any_cast<Sizes>(&packing.own);
  if (!sizes) return std::vector<double>(count, packing.radius);
  constexpr std::uint64_t stream = 0x53495a45;  // another than that of the places
  return draw_radii(*sizes, count, mix(seed ^ stream));
}

void place_random(const PackingRequest& request) {
  const std::vector<double> radii = radii_at_random(request.packing, request.seed);
  const double all = volume_of(request.volume);
  const auto filled = [&](std::int64_t spheres) {
    return std::accumulate(radii.begin(), radii.begin() + spheres, 0.0,
                           [](double sum, double r) { return sum + ball_volume(r); }) /
           all;
  };
  const auto count = std::ssize(radii);
  const std::string wanted = fmt::format(
      "{}: {} spheres of radius {}{} m would be {:.3f} of the volume", request.place, count,
      radii.back() < radii.front() ? fmt::format("{:.4g} to ", radii.back()) : "", radii.front(),
      filled(count));
  const std::string mend =
      "enlarge the volume (random packings of equal spheres end near 0.38) or "
      "take a lattice";
  const double most = most_filled_at_random(request.volume, radii);
  require(filled(count) <= most, "{}; at random at most {:.3f} can be: {}", wanted, most, mend);
  const std::int64_t placed = place_at_random(
      request.volume, radii, request.seed, request.is_free,
      [&](const Vec3& center, double r) { request.put({.center = center, .radius = r}); });
  require(placed == count, "{}; {} ({:.3f}) found a place at random: {}", wanted, placed,
          filled(placed), mend);
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
  in.check("orientation", packing.orientation == Orientation::rotation || !in.has("rotation"),
           "= \"random\" is given beside rotation: give one of them");
}

Lattice simple_cubic(const Packing& packing) {
  return {6, 1, spacing_of(packing)};
}
Lattice close_packed(const Packing& packing) {
  return {12, std::sqrt(0.5), spacing_of(packing)};
}

template <LatticeKind kind>
void place_sites(const PackingRequest& request) {
  const Vec3 sides = 2 * half_widths(request.volume) / spacing_of(request.packing);
  const double sites = (sides.array() + 1).prod();
  require(sites <= most_spheres,
          "{}: a lattice of {} m in its volume has about {:.2g} sites; at most {:.0f} can be: "
          "enlarge the spheres",
          request.place, spacing_of(request.packing), sites, most_spheres);
  place_lattice(kind, request.volume, request.packing, [&](const Vec3& center) {
    request.put({.center = center, .radius = request.packing.radius});
  });
}

constexpr Choice<StoredMotion> stored_motions[] = {{"kept", StoredMotion::kept},
                                                   {"none", StoredMotion::none}};

void read_file(Section& in, Packing& packing) {
  in.need("file",
          "of file: a restart file, beside the case; the centre of mass of what moves is at center",
          packing.file);
  in.take("motion", "of file: velocities and spins are those of the file, or bodies are at rest",
          packing.stored_motion, stored_motions);
}

/// Those bodies of an earlier run that have their centres in the volume.
void place_stored(const PackingRequest& request) {
  const Vec3& turn = request.packing.rotation;
  const Eigen::Matrix3d rotation(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
  const bool moves = request.packing.stored_motion == StoredMotion::kept;
  for (const StoredBody& body : request.packing.stored) {
    PackedSphere sphere{.center = request.volume.center + rotation * body.position,
                        .radius = body.radius,
                        .fixed = body.fixed};
    if (depth(request.volume, sphere.center) < 0) continue;
    if (!body.fixed) sphere.mass = body.mass;
    if (!body.fixed && moves) {
      sphere.velocity = rotation * body.velocity;
      sphere.spin = rotation * body.spin;
    }
    request.put(sphere);
  }
}

}  // namespace

extern const PackingType random_packing, simple_cubic_packing, fcc_packing, hcp_packing;
extern const PackingType file_packing;
const PackingType single_packing{
    .name = "single", .sized = false, .turns = true, .read = read_nothing, .place = place_single};
const PackingType random_packing{.name = "random",
                                 .keeps_clear = true,
                                 .read = read_random,
                                 .radii = radii_at_random,
                                 .place = place_random};
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
  // A volume that is far longer than wide would have more of them than spheres.
  const auto cells = [&]() -> Eigen::Array3d { return (2 * half / cell_).array().floor() + 1; };
  while (cells().prod() > 1000 + 8 * static_cast<double>(expected)) cell_ *= 2;
  cells_ = cells().cast<int>();
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
  if (count_ == 0) first_ = radius;
  const int power = static_cast<int>(std::ceil(std::log2(radius / first_)));
  auto level = levels_.find(power);
  if (level == levels_.end()) {
    const double largest = std::ldexp(first_, power);
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
  const Sites sites(kind, d, room);
  Vec3 extent = Vec3::Zero();
  sites.for_each_row(
      [&](int j, int k, int count) { extent = extent.cwiseMax(sites.at(count - 1, j, k)); });
  // A flat body in the sphere around it takes a small part of each row.
  const auto seen = [&](int i, int j, int k) -> Vec3 {
    return rotation * (sites.at(i, j, k) - extent / 2);
  };
  const Vec3 box = half_widths(volume).array() + d;
  sites.for_each_row([&](int j, int k, int count) {
    double first = 0, last = count - 1;
    clip(seen(0, j, k), seen(1, j, k) - seen(0, j, k), box, first, last);
    for (auto i = static_cast<int>(first); i <= last; ++i) {
      const Vec3 center = volume.center + seen(i, j, k);
      if (depth(volume, center) >= -slack * d) place(center);
    }
  });
}

double most_filled_at_random(const Volume& volume, std::span<const double> radii) {
  // Where random sequential addition of equal spheres ends (Zhang & Torquato 2013: 0.38413). For
  // each halving of the radius another such packing may fill what is left.
  constexpr double equal = 0.3842;
  const double halvings = 1 + std::log2(radii.front() / radii.back());
  const double inside = 1 - std::pow(1 - equal, halvings);
  // Spheres that lean on walls stand denser: as if the volume had a layer more, of at most this
  // part of the layer in which no centre may be.
  constexpr double beside_walls = 2;
  const Vec3 half = half_widths(volume);
  std::mt19937_64 engine(1);
  constexpr int samples = 20'000;
  int all = 0, free = 0;
  for (int k = 0; k < samples; ++k) {
    const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
    const Vec3 offset = half.cwiseProduct(2 * Vec3(x, y, z) - Vec3::Ones());
    const double d = depth(volume, volume.center + offset);
    all += d >= 0;
    free += d >= radii.back();
  }
  return inside * (1 + beside_walls * (all - free) / std::max(all, 1));
}

std::int64_t place_at_random(const Volume& volume, std::span<const double> radii,
                             std::uint64_t seed,
                             const std::function<bool(const Vec3&, double radius)>& is_free,
                             const std::function<void(const Vec3&, double radius)>& place) {
  std::mt19937_64 engine(seed);
  const auto coordinate = [&] { return 2 * uniform(engine) - 1; };
  const Vec3 half = half_widths(volume);
  SphereSet spheres(volume.center, half, std::ssize(radii));
  constexpr std::int64_t most_tries_in_vain = 2'000'000;
  std::int64_t placed = 0;
  for (double r : radii) {
    const Vec3 room = half - Vec3::Constant(r);  // of centres
    if ((room.array() < 0).any()) return placed;
    for (std::int64_t in_vain = 0;; ++in_vain) {
      if (in_vain == most_tries_in_vain) return placed;
      const double x = coordinate(), y = coordinate(), z = coordinate();
      const Vec3 center = volume.center + room.cwiseProduct(Vec3(x, y, z));
      if (depth(volume, center) < r || spheres.find_overlap(center, r, 0) || !is_free(center, r))
        continue;
      spheres.add(center, r);
      place(center, r);
      ++placed;
      break;
    }
  }
  return placed;
}

}  // namespace spall
