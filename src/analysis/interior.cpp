// Sums over the spheres and two searches: no body leaves its rank.
// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/interior.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "spall/error.hpp"

namespace spall {

namespace {

double volume(double radius) {
  return 4 * pi / 3 * radius * radius * radius;
}

/// Directions spread evenly over half of the unit sphere (Fibonacci spiral): widths have no sign.
std::vector<Vec3> directions(int count) {
  std::vector<Vec3> all(count);
  const double turn = pi * (3 - std::sqrt(5.0));  // golden angle
  for (int k = 0; k < count; ++k) {
    const double z = (k + 0.5) / count, s = std::sqrt(1 - z * z);
    all[k] = {s * std::cos(turn * k), s * std::sin(turn * k), z};
  }
  return all;
}

}  // namespace

double shared_volume(double radius_a, double radius_b, double distance) {
  const double small = std::min(radius_a, radius_b), large = std::max(radius_a, radius_b);
  if (distance >= small + large) return 0;
  if (distance <= large - small) return volume(small);
  // Two caps of heights h: pi h^2 (3 r - h) / 3, heights from products, not from differences of
  // squares, so that a small sphere on a large one loses no digits.
  const double large_cap = (small - large + distance) * (small + large - distance) / (2 * distance);
  const double small_cap = small + large - distance - large_cap;
  return pi / 3 *
         (large_cap * large_cap * (3 * large - large_cap) +
          small_cap * small_cap * (3 * small - small_cap));
}

Interior measure_interior(const Comm& comm, const Bodies& bodies, std::span<const char> chosen,
                          const BodyShapes& shapes) {
  std::vector<double> radius = bodies.radius;
  if (!shapes.empty())
    for (Index b = 0; b < bodies.owned; ++b)
      radius[b] *= std::cbrt(shape_of(shapes, bodies, b).volume / volume(1));
  std::vector<Index> rows;
  for (Index b = 0; b < bodies.owned; ++b)
    if (chosen[b] && std::isfinite(bodies.mass[b])) rows.push_back(b);

  Interior pile;
  std::array<double, 4> first{};
  for (Index b : rows) {
    first[0] += bodies.mass[b];
    for (int k = 0; k < 3; ++k) first[1 + k] += bodies.mass[b] * bodies.position[b][k];
  }
  comm.sum(first);
  pile.mass = first[0];
  pile.center = Vec3(first[1], first[2], first[3]) / pile.mass;

  Eigen::Matrix3d second = Eigen::Matrix3d::Zero();  // kg m^2
  double reach = 0;
  for (Index b : rows) {
    const Vec3 x = bodies.position[b] - pile.center;
    const double r = radius[b];
    second += bodies.mass[b] * (x * x.transpose() + r * r / 5 * Eigen::Matrix3d::Identity());
    reach = std::max(reach, x.norm() + r);
  }
  comm.sum(std::span<double>(second.data(), 9));
  reach = comm.max(reach);
  second /= pile.mass;
  pile.gyration_radius = std::sqrt(second.trace());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> moments(second, Eigen::EigenvaluesOnly);
  // A uniform ellipsoid's second moment along a semi-axis a is a^2 / 5.
  pile.axes = 2 * (5 * moments.eigenvalues().reverse()).cwiseSqrt();

  /// Mass and volume inside the sphere of radius R about the centre.
  const auto inside = [&](double R) {
    std::array<double, 2> sums{};
    for (Index b : rows) {
      const double r = radius[b];
      const double part = shared_volume(R, r, (bodies.position[b] - pile.center).norm());
      sums[0] += bodies.mass[b] * (part / volume(r));
      sums[1] += part;
    }
    comm.sum(sums);
    return sums;
  };
  double below = 0, above = reach;
  for (int round = 0; round < 60; ++round) {
    const double middle = (below + above) / 2;
    (inside(middle)[0] < pile.mass / 2 ? below : above) = middle;
  }
  pile.half_mass_radius = above;
  pile.packing_fraction = inside(above)[1] / volume(above);

  const auto spread = directions(2000);
  std::vector<double> ends(2 * spread.size(), -infinity);  // support along a direction, against it
  // Rows that follow each other are near each other: few groups of them reach beyond the others.
  constexpr std::size_t most = 64;
  for (std::size_t at = 0; at < rows.size(); at += most) {
    const auto group = std::span(rows).subspan(at, std::min(most, rows.size() - at));
    Eigen::AlignedBox3d box;  // of the centres, about the pile's
    double largest = 0;
    for (Index b : group) {
      box.extend(bodies.position[b] - pile.center);
      largest = std::max(largest, radius[b]);
    }
    const Vec3 middle = box.center(), half = box.sizes() / 2;
    for (std::size_t k = 0; k < spread.size(); ++k) {
      const double along = spread[k].dot(middle), more = spread[k].cwiseAbs().dot(half) + largest;
      if (along + more <= ends[2 * k] && more - along <= ends[2 * k + 1]) continue;
      for (Index b : group) {
        const double x = spread[k].dot(bodies.position[b] - pile.center);
        ends[2 * k] = std::max(ends[2 * k], x + radius[b]);
        ends[2 * k + 1] = std::max(ends[2 * k + 1], radius[b] - x);
      }
    }
  }
  comm.max(ends);
  for (std::size_t k = 0; k < spread.size(); ++k) {
    const double width = ends[2 * k] + ends[2 * k + 1];
    pile.extent = std::max(pile.extent, width);
    pile.mean_diameter += width / static_cast<double>(spread.size());
  }
  return pile;
}

}  // namespace spall
