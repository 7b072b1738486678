// Signed distances to spheres, boxes, ellipsoids, shells and cylinders.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/scene/shape.hpp"

#include <algorithm>
#include <cmath>

namespace spall {
namespace {

/// Distance of `p` from the surface of the ellipsoid with half axes `a`; the nearest point is
/// q_k = a_k^2 p_k / (t + a_k^2) with t from |q / a| = 1, found by bisection (Eberly 2013,
/// "Distance from a point to an ellipse, an ellipsoid, or a hyperellipsoid").
double ellipsoid_depth(const Vec3& a, const Vec3& p) {
  const double outside = (p.array() / a.array()).matrix().squaredNorm() - 1;
  if (outside >= 0) return -outside;
  int shortest = 0;
  a.minCoeff(&shortest);
  const Eigen::Array3d a2 = a.array().square();
  const auto nearest = [&](double t) -> Vec3 { return a2 * p.array() / (t + a2); };
  double low = -a2[shortest], high = 0;
  for (int k = 0; k < 60; ++k) {
    const double t = (low + high) / 2;
    ((nearest(t).array() / a.array()).matrix().squaredNorm() > 1 ? low : high) = t;
  }
  Vec3 q = nearest(high);
  if (p[shortest] == 0) {
    // On the plane across the shortest axis the nearest point may leave it, with t = -a^2 there.
    q[shortest] = 0;
    const double rest = 1 - (q.array() / a.array()).matrix().squaredNorm();
    q[shortest] = a[shortest] * std::sqrt(std::max(0.0, rest));
  }
  return (q - p).norm();
}

}  // namespace

double depth(const Volume& volume, const Vec3& point) {
  const Vec3 p = point - volume.center;
  const Vec3 half = volume.extents / 2;
  switch (volume.shape) {
    case Shape::sphere:
      return volume.radius - p.norm();
    case Shape::hollow_sphere:
      return std::min(volume.radius - p.norm(), p.norm() - volume.inner_radius);
    case Shape::box:
      return (half - p.cwiseAbs()).minCoeff();
    case Shape::ellipsoid:
      return ellipsoid_depth(half, p);
    case Shape::cylinder:
      return std::min(half.x() - p.head<2>().norm(), half.z() - std::abs(p.z()));
  }
  return -infinity;
}

double volume_of(const Volume& volume) {
  const auto ball = [](double radius) { return 4 * pi / 3 * radius * radius * radius; };
  switch (volume.shape) {
    case Shape::sphere:
      return ball(volume.radius);
    case Shape::hollow_sphere:
      return ball(volume.radius) - ball(volume.inner_radius);
    case Shape::box:
      return volume.extents.prod();
    case Shape::ellipsoid:
      return pi / 6 * volume.extents.prod();
    case Shape::cylinder:
      return pi / 4 * volume.extents.prod();
  }
  return 0;
}

Vec3 half_widths(const Volume& volume) {
  if (volume.shape == Shape::sphere || volume.shape == Shape::hollow_sphere)
    return Vec3::Constant(volume.radius);
  return volume.extents / 2;
}

}  // namespace spall
