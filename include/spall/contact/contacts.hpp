// The contacts of one rank: pairs of spheres (or a sphere and a plane) that can touch in this step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/base/types.hpp"

namespace spall {

/// Row of the other side of a contact with a plane: a body that never moves.
inline constexpr Index ground = -1;

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

  Index size() const { return static_cast<Index>(i.size()); }
};

/// What contacts leave to the next step and to restarts, by name, since rows die: impulses, or the
/// springs of penalty contact.
struct ContactMemory {
  std::vector<BodyId> i;      ///< the lower id
  std::vector<BodyId> j;      ///< the other id, or -1 - plane
  std::vector<Vec3> impulse;  ///< N s, acts on j; penalty contact: m, sliding of j against i
  std::vector<Vec3> rolling;  ///< m, the same from either side; empty where nothing resists rolling

  std::size_t size() const { return i.size(); }
  Vec3 rolling_of(std::size_t m) const { return rolling.empty() ? Vec3(Vec3::Zero()) : rolling[m]; }

  void reserve(std::size_t count) {
    i.reserve(count);
    j.reserve(count);
    impulse.reserve(count);
  }
  void add(BodyId lower, BodyId other, const Vec3& first, const Vec3& second = Vec3::Zero()) {
    if (rolling.empty() && !second.isZero(0)) rolling.assign(size(), Vec3::Zero());
    i.push_back(lower);
    j.push_back(other);
    impulse.push_back(first);
    if (!rolling.empty() || !second.isZero(0)) rolling.push_back(second);
  }
};

}  // namespace spall
