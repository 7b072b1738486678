// Nearest points of a contact's admissible impulses, for one contact (a number) or eight (a pack).
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/lanes.hpp"

namespace spall {

/// An impulse z = z_n n + z_t becomes normal n + tangent_factor z_t.
template <class T>
struct Projected {
  T normal;
  T tangent_factor;
};

/// Normal first, then the tangent into the disc that this normal allows: p_n >= -s,
/// |p_t| <= mu (p_n + s). Not the nearest point of a fixed set; its fixed points are exact Coulomb
/// solutions. `tangent` is |z_t|.
template <class T>
Projected<T> project_coulomb(T z_n, T tangent, T mu, T s) {
  const T normal = larger(z_n, -s);
  const T bound = mu * (normal + s);
  return {normal, select(tangent > bound, bound / tangent, T{} + 1)};
}

/// Nearest point of the cone |p_t| <= mu (p_n + s), apex at -s n, in the metric
/// diag(1, theta2, theta2): tangents scaled by theta make it Euclidean with mu theta for mu.
template <class T>
Projected<T> project_cone(T z_n, T tangent, T mu, T s, T theta2) {
  const T height = z_n + s;
  const T polar = theta2 * mu * tangent;
  const T surface = (height + polar) / (theta2 * mu * mu + 1);
  const auto inside = tangent <= mu * height;
  const auto apex = polar <= -height;
  // The apex comes first: without friction what parts straight along the normal is in both.
  return {select(apex, -s, select(inside, z_n, surface - s)),
          select(apex, T{}, select(inside, T{} + 1, mu * surface / tangent))};
}

}  // namespace spall
