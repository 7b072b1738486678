// One sphere, lattices, bodies of an earlier run; spheres in cells.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/packing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "scene/shape.hpp"
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

void read_nothing(Section&, Packing&) {}

void place_single(const PackingRequest& request) {
  request.put({.center = request.volume.center, .radius = request.packing.radius});
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
  in.take("grains",
          "of lattices: mean size of crystals that are turned at random; left out: one crystal",
          packing.grain, positive(dimension::length));
  in.check("grains",
           !packing.grain || (packing.orientation == Orientation::rotation && !in.has("rotation")),
           "is given beside rotation or orientation, which turn one crystal");
  constexpr double smallest_grain = 2;  // spacings
  in.check("grains", !packing.grain || *packing.grain >= smallest_grain * spacing,
           fmt::format("= {} m is less than {:g} spacings of {} m", packing.grain.value_or(0),
                       smallest_grain, spacing));
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
  const auto put = [&](const Vec3& center) {
    request.put({.center = center, .radius = request.packing.radius});
  };
  if (!request.packing.grain) return place_lattice(kind, request.volume, request.packing, put);
  const double grains = grains_of(request.volume, *request.packing.grain);
  constexpr double most_grains = 1e6;
  require(grains <= most_grains,
          "{}: its volume has about {:.2g} grains of {} m; at most {:.0f} can be: enlarge "
          "packing.grains",
          request.place, grains, *request.packing.grain, most_grains);
  place_grains(kind, request.volume, request.packing, request.seed, put);
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
  const Mat3 rotation = request.volume.axes * turn_by(request.packing.rotation);
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

extern const PackingType simple_cubic_packing, fcc_packing, hcp_packing, file_packing;
const PackingType single_packing{
    .name = "single", .sized = false, .turns = true, .read = read_nothing, .place = place_single};
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

double spacing_of(const Packing& packing) {
  return packing.spacing.value_or(2 * packing.radius);
}

Lattice lattice_of(const Packing& packing) {
  if (packing.type->lattice) return packing.type->lattice(packing);
  return {0, pi / 6, 2 * packing.radius};
}

double filled_by(const Group& group, std::int64_t spheres) {
  return static_cast<double>(spheres) * lattice_of(group.packing).volume() /
         volume_of(group.volume);
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

void SphereGrid::remove_last() {
  first_[index_of(cell_of(centers_.back()))] = next_.back();
  next_.pop_back();
  centers_.pop_back();
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

void SphereSet::keep(std::int64_t count) {
  for (auto& [power, level] : levels_)
    while (!level.sphere.empty() && level.sphere.back() >= count) {
      level.grid.remove_last();
      level.radius.pop_back();
      level.sphere.pop_back();
    }
  count_ = std::min(count_, count);
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
                   const std::function<void(const Vec3&)>& place, const Volume* within) {
  const double d = spacing_of(packing);
  const bool turned = !packing.rotation.isZero(0);
  Vec3 half = half_widths(volume);
  Mat3 rotation = Mat3::Identity();
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
  const Volume& outer = within ? *within : volume;
  const Vec3 outer_box = half_widths(outer).array() + d;
  const Vec3 off = volume.axes.transpose() * (volume.center - outer.center);
  sites.for_each_row([&](int j, int k, int count) {
    double first = 0, last = count - 1;
    const Vec3 from = seen(0, j, k), step = seen(1, j, k) - from;
    clip(from, step, box, first, last);
    clip(off + from, step, outer_box, first, last);
    for (auto i = static_cast<int>(first); i <= last; ++i) {
      const Vec3 center = volume.center + volume.axes * seen(i, j, k);
      if (depth(volume, center) >= -slack * d) place(center);
    }
  });
}

}  // namespace spall
