// The mean distance from surface to union is submodular in the set of spheres: choosing the best
// one after another comes within 1 - 1/e of the best of all sets (Nemhauser et al. 1978).
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/sphere_fill.hpp"

#include <algorithm>
#include <cmath>

namespace spall {
namespace {

struct SurfacePoint {
  Vec3 at, inwards;
};

/// So many points, each of as much area, by a sequence of low discrepancy within the triangles
/// (Roberts 2018).
std::vector<SurfacePoint> points_on(const SurfaceMesh& mesh, int count) {
  std::vector<double> area_before{0};
  std::vector<Vec3> normals;
  for (const auto& [a, b, c] : mesh.triangles()) {
    const auto& v = mesh.vertices();
    const Vec3 twice = (v[b] - v[a]).cross(v[c] - v[a]);
    area_before.push_back(area_before.back() + twice.norm() / 2);
    normals.push_back(twice.normalized());
  }
  std::vector<SurfacePoint> points;
  for (int k = 0; k < count; ++k) {
    const double area = area_before.back() * (k + 0.5) / count;
    const auto next = std::upper_bound(area_before.begin() + 1, area_before.end() - 1, area);
    const auto triangle = static_cast<std::size_t>(next - area_before.begin() - 1);
    double s = std::fmod(0.5 + 0.7548776662466927 * k, 1);
    double t = std::fmod(0.5 + 0.5698402909980532 * k, 1);
    if (s + t > 1) {
      s = 1 - s;
      t = 1 - t;
    }
    const auto& [a, b, c] = mesh.triangles()[triangle];
    const auto& v = mesh.vertices();
    points.push_back({v[a] + s * (v[b] - v[a]) + t * (v[c] - v[a]), -normals[triangle]});
  }
  return points;
}

/// The largest sphere in the mesh that touches it at this point: spheres that do lie in each other.
ShapeSphere largest_at(const SurfaceMesh& mesh, const SurfacePoint& point) {
  constexpr double round_off = 1e-9;
  const double size = mesh.half_widths().norm();
  const auto fits = [&](double r) {
    return mesh.depth(point.at + r * point.inwards) >= r - round_off * size;
  };
  double inside = 0, outside = size;
  for (int halvings = 0; halvings < 40; ++halvings) {
    const double r = (inside + outside) / 2;
    (fits(r) ? inside : outside) = r;
  }
  return {point.at + inside * point.inwards, inside};
}

/// The largest sphere in the mesh about this one's centre, or near it: none is larger that is moved
/// by a ten-thousandth of the size along an axis or between two or three. Depth has edges, up which
/// no axis may lead.
ShapeSphere largest_near(const SurfaceMesh& mesh, ShapeSphere sphere) {
  const double size = mesh.half_widths().norm();
  for (double by = size / 16; by > size / 2e4; by /= 2)
    for (bool moved = true; moved;) {
      moved = false;
      for (int k = 0; k < 27; ++k) {
        const Vec3 at = sphere.at + by * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        const double depth = mesh.depth(at);
        if (depth <= sphere.radius * (1 + 1e-12)) continue;
        sphere = {at, depth};
        moved = true;
      }
    }
  return sphere;
}

}  // namespace

std::vector<ShapeSphere> fill_mesh(const SurfaceMesh& mesh, int count) {
  constexpr int samples = 2000;
  const std::vector<SurfacePoint> points = points_on(mesh, samples);
  std::vector<ShapeSphere> candidates;
  for (const SurfacePoint& point : points) candidates.push_back(largest_at(mesh, point));
  std::vector<ShapeSphere> chosen{
      largest_near(mesh, *std::ranges::max_element(candidates, {}, &ShapeSphere::radius))};
  const auto distance = [](const ShapeSphere& sphere, const SurfacePoint& point) {
    return std::max((point.at - sphere.at).norm() - sphere.radius, 0.0);
  };
  std::vector<double> left(points.size(), infinity);  // from each point to the union
  while (std::ssize(chosen) < count) {
    for (std::size_t k = 0; k < points.size(); ++k)
      left[k] = std::min(left[k], distance(chosen.back(), points[k]));
    double best = 0;
    const ShapeSphere* next = nullptr;
    for (const ShapeSphere& candidate : candidates) {
      const auto overlaps = [&](const ShapeSphere& s) {
        return (s.at - candidate.at).norm() < s.radius + candidate.radius;
      };
      if (std::ranges::none_of(chosen, overlaps)) continue;
      double gain = 0;
      for (std::size_t k = 0; k < points.size(); ++k)
        gain += std::max(left[k] - distance(candidate, points[k]), 0.0);
      if (gain > best * (1 + 1e-12)) {
        best = gain;
        next = &candidate;
      }
    }
    if (best <= 1e-9 * samples * mesh.half_widths().norm()) break;
    chosen.push_back(*next);
  }
  return chosen;
}

}  // namespace spall
