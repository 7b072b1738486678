// The contacts of one rank: pairs of spheres (or a sphere and a plane) that can touch in this step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/types.hpp"

namespace spall {

/// Where two spheres of bodies with shapes touch.
struct SphereContact {
  Vec3 arm_i, arm_j;            ///< m, from the centres of both bodies to one common point
  double radius;                ///< m, of the smaller sphere
  std::int32_t of_i, of_j = 0;  ///< places in the lists of spheres of the shapes; at a plane 0
};

/// Every pair with at least one owned body, each once on this rank; a pair with one ghost is on
/// both ranks, evaluated by both from the same bits. First the `boundary` contacts that have a
/// ghost, then the interior ones; inside each part along a space-filling curve. `id(i) < id(j)`.
struct Contacts {
  Index boundary = 0;

  std::vector<Index> i;             ///< row of the body with the lower id
  std::vector<Index> j;             ///< row of the other body, or `ground`
  std::vector<std::int32_t> plane;  ///< which plane, where j is `ground`; -1 elsewhere
  std::vector<Vec3> normal;         ///< unit vector from i to j
  std::vector<double> gap;          ///< m; negative: overlap
  std::vector<double> kappa;        ///< distance of the centres over the sum of radii; 1 at a plane
  std::vector<Vec3> impulse;        ///< N s, world frame, acts on j (and with opposite sign on i)
  std::vector<Index> pair;          ///< the pair that this contact came from

  /// Where bodies have shapes, else empty. Spheres of the two shapes touch, several of them a pair.
  std::vector<SphereContact> spheres;

  Index size() const { return static_cast<Index>(i.size()); }
};

}  // namespace spall
