// Packings: the centres of the spheres that fill a volume.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "spall/scene/case.hpp"

namespace spall {

/// Centres of equal spheres, in cells that find the neighbours of a point.
class SphereGrid {
 public:
  /// For about `expected` spheres of `radius` in the box `center` +- `half`.
  SphereGrid(const Vec3& center, const Vec3& half, double radius, std::int64_t expected);
  void add(const Vec3& center);
  /// A sphere nearer than `distance` to `point`; -1 without one.
  std::int64_t find_nearer(const Vec3& point, double distance) const;
  double radius() const { return radius_; }
  const Vec3& center(std::int64_t sphere) const { return centers_[sphere]; }

 private:
  Eigen::Array3i cell_of(const Vec3& point) const;
  std::size_t index_of(const Eigen::Array3i& cell) const;

  Vec3 low_;
  double radius_, cell_;
  Eigen::Array3i cells_;
  std::vector<std::int32_t> first_, next_;  ///< chains of the spheres of a cell
  std::vector<Vec3> centers_;
};

/// The lattice of a packing's spheres; a sphere's cell where the packing is none is the sphere.
Lattice lattice_of(const Packing& packing);

/// A turn, as a rotation vector, of which any is as likely as any other; the same on every machine.
Vec3 random_rotation(std::uint64_t seed);

/// Calls `place` with every site of the lattice, in a fixed order. The lattice is laid into the
/// bounding box of the volume so that whole spheres fill it, centred in it (a box n diameters wide
/// holds n layers); the sites whose centres lie inside the volume are kept, so that mass goes with
/// volume. Cubic axes along x, y, z; hcp: close-packed layers across z, rows along x; turned by
/// `packing.rotation` about the volume's center.
void place_lattice(const Volume& volume, const Packing& packing,
                   const std::function<void(const Vec3&)>& place);

/// `packing.count` spheres at random, wholly inside the volume, clear of each other and where
/// `is_free`: random sequential addition, which ends near 0.38 of the volume. The same on every
/// machine. Returns how many found a place before two million tries in a row failed.
std::int64_t place_at_random(const Volume& volume, const Packing& packing, std::uint64_t seed,
                             const std::function<bool(const Vec3&)>& is_free,
                             const std::function<void(const Vec3&)>& place);

}  // namespace spall
