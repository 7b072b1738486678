// Packings: how a volume is filled with spheres. The table of them is scene/packings.cpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "keys/section.hpp"
#include "scene/case.hpp"
#include "spall/comm.hpp"
#include "state/period.hpp"

namespace spall {

/// A sphere where a packing puts it.
struct PackedSphere {
  Vec3 center;                                        ///< m
  double radius = 0;                                  ///< m
  std::optional<double> mass = {};                    ///< kg; left out: its material gives it
  Vec3 velocity = Vec3::Zero(), spin = Vec3::Zero();  ///< m/s, rad/s, beside the group's motion
  bool fixed = false;                                 ///< never moves, whatever its group does
};

/// What a packing is to fill, and what it may ask and give.
struct PackingRequest {
  const Volume& volume;
  const Packing& packing;
  std::uint64_t seed;  ///< of this group alone: changing one group leaves the others as they are
  std::string_view place;  ///< where the case asks for it, for messages
  Period period = {};      ///< for those that keep clear: of images of their own spheres as well
  Comm comm = {};          ///< for those that keep clear: ranks that share the work
  /// Whether a sphere (m) is clear of earlier groups and of planes.
  std::function<bool(const Vec3& center, double radius)> is_free;
  /// Makes a body.
  std::function<void(const PackedSphere&)> put;
};

/// m, radii of spheres in their order, the largest first: one, where all are equal.
struct Radii {
  std::int64_t count = 0;
  std::vector<double> values = {};

  double operator[](std::int64_t k) const { return values[values.size() == 1 ? 0 : k]; }
  double largest() const { return values.front(); }
  double smallest() const { return values.back(); }
};

/// A way to fill a volume, as a case sees it. Every rank runs through it, with the same result.
struct PackingType {
  std::string_view name;  ///< of `kind` in a packing
  bool sized = true;      ///< has the key `radius` or `diameter`
  bool turns = false;     ///< has the key `rotation`
  /// It asks `is_free` for each body, whose images keep clear of each other; bodies of others are
  /// checked afterwards.
  bool keeps_clear = false;
  /// Reads its own keys; `radius` is read.
  void (*read)(Section& in, Packing& packing);
  /// Whether its spheres may differ in size; null: they do not.
  bool (*unequal)(const Packing& packing) = nullptr;
  /// Radii of its spheres, where they are known before they are placed; null: placing them tells.
  Radii (*radii)(const Packing& packing, std::uint64_t seed) = nullptr;
  /// The lattice of its spheres; null: none.
  Lattice (*lattice)(const Packing& packing) = nullptr;
  /// Puts all bodies, in an order that does not depend on the rank.
  void (*place)(const PackingRequest& request);
};

/// In the order in which their names are listed.
std::span<const PackingType* const> all_packings();

/// Centres of spheres, in cells that find the neighbours of a point.
class SphereGrid {
 public:
  /// For about `expected` spheres of up to `radius` in the box `center` +- `half`.
  SphereGrid(const Vec3& center, const Vec3& half, double radius, std::int64_t expected);
  void add(const Vec3& center);
  void remove_last();
  /// A sphere with `is_wanted(sphere)` of those in the cells within `distance` of `point`; -1
  /// without one.
  template <class Test>
  std::int64_t find(const Vec3& point, double distance, Test&& is_wanted) const;
  /// A sphere nearer than `distance` to `point`; -1 without one.
  std::int64_t find_nearer(const Vec3& point, double distance) const;
  const Vec3& center(std::int64_t sphere) const { return centers_[sphere]; }

 private:
  Eigen::Array3i cell_of(const Vec3& point) const;
  std::size_t index_of(const Eigen::Array3i& cell) const;

  Vec3 low_;
  double cell_;
  Eigen::Array3i cells_;
  std::vector<std::int32_t> first_, next_;  ///< chains of the spheres of a cell
  std::vector<Vec3> centers_;
};

/// Spheres of a group, at most: they are numbered by 32 bits while they are placed.
inline constexpr double most_spheres = 2147483647;

/// m, of a lattice: between nearest neighbours.
double spacing_of(const Packing& packing);

/// The lattice of a packing's spheres; a sphere's cell where the packing is none is the sphere.
Lattice lattice_of(const Packing& packing);

/// Of the mass that a group's volume has at the density of its solid, what so many spheres of its
/// lattice have, which stand for their cells. In few layers along its faces much is left out.
double filled_by(const Group& group, std::int64_t spheres);
/// What it may be off by before that is told, or a wall is refused: equations of shields are steep
/// in the thickness.
inline constexpr double most_unfilled = 0.05;

/// A turn, as a rotation vector, of which any is as likely as any other; the same on every machine.
Vec3 random_rotation(std::uint64_t seed);

enum class LatticeKind { simple_cubic, fcc, hcp };

/// Calls `place` with every site of the lattice, in a fixed order. The lattice is laid into the
/// bounding box of the volume so that whole spheres fill it, centred in it (a box n diameters wide
/// holds n layers); the sites whose centres lie inside the volume are kept, so that mass goes with
/// volume. Cubic axes along x, y, z; hcp: close-packed layers across z, rows along x; turned by
/// `packing.rotation` about the volume's center. `within`, of the same axes: sites far outside of
/// its bounding box may be left out, which saves the time to look at them.
void place_lattice(LatticeKind kind, const Volume& volume, const Packing& packing,
                   const std::function<void(const Vec3&)>& place, const Volume* within = nullptr);

/// About how many grains of this mean size (m, of a ball as large as the mean grain) the bounding
/// box of a volume has.
double grains_of(const Volume& volume, double grain);

/// The same of a polycrystal: middles of grains at random in the bounding box, and around each its
/// own crystal, turned at random, as far as its Voronoi cell reaches. `packing.grain` is their mean
/// size. As many sites as the volume has room for on average; next to a border between grains they
/// may lie nearer to each other than the spacing, or leave gaps of about one.
void place_grains(LatticeKind kind, const Volume& volume, const Packing& packing,
                  std::uint64_t seed, const std::function<void(const Vec3&)>& place);

template <class Test>
std::int64_t SphereGrid::find(const Vec3& point, double distance, Test&& is_wanted) const {
  const auto find_in = [&](const Eigen::Array3i& cell) {
    std::int32_t sphere = first_[index_of(cell)];
    while (sphere >= 0 && !is_wanted(sphere)) sphere = next_[sphere];
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

/// Spheres of many sizes: a grid for each power of two in radius.
class SphereSet {
 public:
  /// For about `expected` spheres in the box `center` +- `half`.
  SphereSet(const Vec3& center, const Vec3& half, std::int64_t expected)
      : center_(center), half_(half), expected_(expected) {}
  void add(const Vec3& center, double radius);
  std::int64_t size() const { return count_; }
  /// Removes all but the first `count`.
  void keep(std::int64_t count);
  struct Overlap {
    std::int64_t sphere;  ///< in the order in which they were added
    Vec3 center;
    double radius, depth;  ///< m
  };
  /// A sphere that reaches more than `allowed` of the smaller radius into this one.
  std::optional<Overlap> find_overlap(const Vec3& center, double radius, double allowed) const;

 private:
  /// Spheres up to `largest`; those of the first level are as large as the first sphere.
  struct Level {
    SphereGrid grid;
    double largest;  ///< m, no sphere of the level has a larger radius
    std::vector<double> radius;
    std::vector<std::int64_t> sphere;
  };
  Vec3 center_, half_;
  double first_ = 0;  ///< m, radius of the sphere that was added first
  std::int64_t expected_, count_ = 0;
  std::map<int, Level> levels_;
};

/// Calls `f(image, itself)` with each image of `x` inside the box `center` +- `half`, which is
/// without end where space does not repeat itself.
template <class F>
void for_each_image(const Period& period, const Vec3& x, const Vec3& center, const Vec3& half,
                    F&& f) {
  Eigen::Array3i first = Eigen::Array3i::Zero(), last = first;
  for (int k = 0; k < 3; ++k) {
    if (period.size[k] == 0) continue;
    first[k] = static_cast<int>(std::ceil((center[k] - half[k] - x[k]) / period.size[k]));
    last[k] = static_cast<int>(std::floor((center[k] + half[k] - x[k]) / period.size[k]));
  }
  for (int l = first.z(); l <= last.z(); ++l)
    for (int m = first.y(); m <= last.y(); ++m)
      for (int n = first.x(); n <= last.x(); ++n)
        f(Vec3(x + period.size.cwiseProduct(Vec3(n, m, l))), n == 0 && m == 0 && l == 0);
}

/// Spheres of these radii at random, wholly inside the volume, clear of each other, of each other's
/// images and where `is_free`: random sequential addition, which ends near 0.38 of the volume where
/// all are equal. The same on every machine and on any number of ranks. Every rank is told of every
/// sphere, and returns how many found a place before two million tries in a row failed. Each rank
/// looks for overlaps in its part of the volume alone and holds no spheres far from it.
/// Collective.
std::int64_t place_at_random(const Comm& comm, const Volume& volume, const Period& period,
                             const Radii& radii, std::uint64_t seed,
                             const std::function<bool(const Vec3&, double radius)>& is_free,
                             const std::function<void(const Vec3&, double radius)>& place);

/// Part of the volume, the most that random sequential addition of such radii can fill, for sure.
double most_filled_at_random(const Volume& volume, const Radii& radii);

/// Boulders that are fine around a site and coarse far from it. At x the largest have the radius
///   R(x) = growth |x - site|, not below `smallest` and not above the packing's radius,
/// and there are N(>r) ~ r^-exponent of them from R down to R/4, which together fill `fill`.
struct Grading {
  Vec3 site = Vec3::Zero();  ///< m
  double smallest = 0;       ///< m
  double growth = 0;
  double exponent = 3;
  double fill = 0.5;
};

/// Boulders as `grading` wants them, up to the radius `largest` (m), wholly inside the volume and
/// clear of each other: added at random from the largest size down, so that small ones find the
/// gaps. The same on every machine. An Error, which begins with `asked_at`, where they are too
/// many.
void place_graded(const Volume& volume, double largest, const Grading& grading, std::uint64_t seed,
                  std::string_view asked_at, const std::function<void(const Vec3&, double)>& place);

}  // namespace spall
