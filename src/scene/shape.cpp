// Signed distances to spheres, boxes, ellipsoids, shells, cylinders and meshes.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/shape.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace spall {
namespace {

/// Distance of `p` from the surface of the ellipsoid with half axes `a`; the nearest point is
/// q_k = a_k^2 p_k / (s + a_k^2 - a_min^2) with s in (0, a_min^2] from |q / a| = 1, found by
/// bisection (Eberly 2013, "Distance from a point to an ellipse, an ellipsoid, or a
/// hyperellipsoid").
double ellipsoid_depth(const Vec3& a, const Vec3& p) {
  const double outside = (p.array() / a.array()).matrix().squaredNorm() - 1;
  if (outside >= 0) return -outside;
  int shortest = 0;
  const double a_min = a.minCoeff(&shortest);
  const Eigen::Array3d a2 = a.array().square();
  const auto nearest = [&](double s) -> Vec3 {
    return a2 * p.array() / (s + (a2 - a_min * a_min));
  };
  double low = 0, high = a_min * a_min;
  for (int k = 0; k < 60; ++k) {
    const double s = (low + high) / 2;
    ((nearest(s).array() / a.array()).matrix().squaredNorm() > 1 ? low : high) = s;
  }
  Vec3 q = nearest(high);
  if (p[shortest] == 0) {
    // From the plane across the shortest axis the nearest point may lie off it, with s = 0.
    q[shortest] = 0;
    const double rest = 1 - (q.array() / a.array()).matrix().squaredNorm();
    q[shortest] = a[shortest] * std::sqrt(std::max(0.0, rest));
  }
  return (q - p).norm();
}

}  // namespace

double depth(const Volume& volume, const Vec3& point) {
  const Vec3 p = volume.axes.transpose() * (point - volume.center);
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
    case Shape::mesh:
      return volume.mesh->depth(p);
  }
  return -infinity;
}

bool contains(const Volume& volume, const Vec3& point) {
  if (volume.shape != Shape::ellipsoid) return depth(volume, point) > 0;
  const Vec3 p = volume.axes.transpose() * (point - volume.center);
  return (2 * p.array() / volume.extents.array()).matrix().squaredNorm() < 1;
}

double ball_volume(double radius) {
  return 4 * pi / 3 * radius * radius * radius;
}

double volume_of(const Volume& volume) {
  switch (volume.shape) {
    case Shape::sphere:
      return ball_volume(volume.radius);
    case Shape::hollow_sphere:
      return ball_volume(volume.radius) - ball_volume(volume.inner_radius);
    case Shape::box:
      return volume.extents.prod();
    case Shape::ellipsoid:
      return pi / 6 * volume.extents.prod();
    case Shape::cylinder:
      return pi / 4 * volume.extents.prod();
    case Shape::mesh:
      return volume.mesh->volume();
  }
  return 0;
}

Vec3 half_widths(const Volume& volume) {
  if (volume.shape == Shape::sphere || volume.shape == Shape::hollow_sphere)
    return Vec3::Constant(volume.radius);
  if (volume.shape == Shape::mesh) return volume.mesh->half_widths();
  return volume.extents / 2;
}

Vec3 half_widths_in_world(const Volume& volume) {
  return volume.axes.cwiseAbs() * half_widths(volume);
}

Eigen::AngleAxisd turn_by(const Vec3& turn) {
  return {turn.norm(), turn.stableNormalized()};
}

int thin_axis(const Volume& volume) {
  int thin = 2;
  if (volume.shape == Shape::box) volume.extents.minCoeff(&thin);
  return thin;
}

double speed_across(const Vec3& velocity, const Vec3& normal) {
  constexpr double rounding = 1e-12;
  const double speed = velocity.dot(normal);
  return std::abs(speed) > rounding * velocity.norm() ? speed : 0;
}

std::string words_of_direction(const Vec3& direction) {
  for (int k = 0; k < 3; ++k)
    if (std::abs(direction[k]) == 1)
      return fmt::format("{}{}", direction[k] < 0 ? "-" : "", "xyz"[k]);
  const Vec3 told = direction + Vec3::Zero();  // 0 in place of -0
  return fmt::format("[{:.3g}, {:.3g}, {:.3g}]", told.x(), told.y(), told.z());
}

}  // namespace spall
