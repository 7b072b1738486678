// Volume and inertia by lines through the union: exact along each line, a midpoint rule across.
// SPDX-License-Identifier: BSD-3-Clause
#include "state/body_shape.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "spall/error.hpp"

namespace spall {
namespace {

/// Of a body of density 1.
struct Moments {
  double volume = 0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();  // of x x^T

  Vec3 centre() const { return first / volume; }
  /// About the centre of mass.
  Mat3 inertia() const {
    const Mat3 about = second - volume * centre() * centre().transpose();
    return about.trace() * Mat3::Identity() - about;
  }
};

/// Of the union, by lines along z through the middles of n x n squares over all of it.
Moments moments_by_lines(std::span<const ShapeSphere> spheres, int n) {
  Eigen::AlignedBox2d box;
  for (const ShapeSphere& s : spheres) {
    box.extend(Eigen::Vector2d(s.at.head<2>().array() - s.radius));
    box.extend(Eigen::Vector2d(s.at.head<2>().array() + s.radius));
  }
  const Eigen::Vector2d d = box.sizes() / n;
  Moments sum;
  std::vector<std::array<double, 2>> cuts;
  std::vector<ShapeSphere> of_row;
  for (int j = 0; j < n; ++j) {
    const double y = box.min().y() + (j + 0.5) * d.y();
    of_row.clear();
    for (const ShapeSphere& s : spheres)
      if (std::abs(y - s.at.y()) < s.radius) of_row.push_back(s);
    for (int i = 0; i < n; ++i) {
      const double x = box.min().x() + (i + 0.5) * d.x();
      cuts.clear();
      for (const ShapeSphere& s : of_row) {
        const double dx = x - s.at.x(), dy = y - s.at.y();
        const double left = s.radius * s.radius - dx * dx - dy * dy;
        if (left <= 0) continue;
        const double half = std::sqrt(left);
        cuts.push_back({s.at.z() - half, s.at.z() + half});
      }
      std::sort(cuts.begin(), cuts.end());
      for (std::size_t k = 0; k < cuts.size();) {
        const double low = cuts[k][0];
        double high = cuts[k][1];
        for (++k; k < cuts.size() && cuts[k][0] <= high; ++k) high = std::max(high, cuts[k][1]);
        const double l = high - low, z = (high * high - low * low) / 2;
        const double zz = (high * high * high - low * low * low) / 3;
        sum.volume += l;
        sum.first += Vec3(l * x, l * y, z);
        sum.second(0, 0) += l * x * x;
        sum.second(0, 1) += l * x * y;
        sum.second(1, 1) += l * y * y;
        sum.second(0, 2) += z * x;
        sum.second(1, 2) += z * y;
        sum.second(2, 2) += zz;
      }
    }
  }
  sum.second.triangularView<Eigen::StrictlyLower>() = sum.second.transpose();
  const double area = d.prod();
  sum.volume *= area;
  sum.first *= area;
  sum.second *= area;
  return sum;
}

/// With twice the lines until that changes nothing any more. Halving the spacing lowers the error
/// by more than two, so the last change is more than what is left.
Moments moments_of(std::span<const ShapeSphere> spheres) {
  constexpr int fewest = 128, most = 8192;
  Moments coarse = moments_by_lines(spheres, fewest);
  for (int n = 2 * fewest;; n *= 2) {
    const Moments fine = moments_by_lines(spheres, n);
    const double least = Eigen::SelfAdjointEigenSolver<Mat3>(fine.inertia(), Eigen::EigenvaluesOnly)
                             .eigenvalues()
                             .minCoeff();
    const double change =
        std::max(std::abs(fine.volume - coarse.volume) / fine.volume,
                 (fine.inertia() / fine.volume - coarse.inertia() / coarse.volume).norm() *
                     fine.volume / least);
    if (change < shape_error || n == most) return fine;
    coarse = fine;
  }
}

/// Whether one can go from each sphere to each other without leaving them. Spheres that touch hang
/// together, whatever round-off made of their places.
bool hangs_together(std::span<const ShapeSphere> spheres) {
  constexpr double round_off = 1e-9;  // of the sum of radii
  std::vector<bool> reached(spheres.size(), false);
  std::vector<std::size_t> next{0};
  reached[0] = true;
  while (!next.empty()) {
    const ShapeSphere from = spheres[next.back()];
    next.pop_back();
    for (std::size_t k = 0; k < spheres.size(); ++k) {
      const double reach = (1 + round_off) * (from.radius + spheres[k].radius);
      if (reached[k] || (spheres[k].at - from.at).norm() > reach) continue;
      reached[k] = true;
      next.push_back(k);
    }
  }
  return std::ranges::find(reached, false) == reached.end();
}

}  // namespace

BodyShape make_shape(std::string name, std::span<const ShapeSphere> spheres) {
  BodyShape shape;
  shape.name = std::move(name);
  require(!spheres.empty(), "shape {} has no sphere", shape.name);
  for (const ShapeSphere& s : spheres)
    require(s.at.allFinite() && s.radius > 0 && std::isfinite(s.radius),
            "shape {}: a sphere has no finite place or no positive radius", shape.name);
  require(hangs_together(spheres), "shape {}: its spheres do not hang together", shape.name);
  if (spheres.size() == 1) return shape;

  const Moments moments = moments_of(spheres);
  const Eigen::SelfAdjointEigenSolver<Mat3> principal(moments.inertia());
  Mat3 axes = principal.eigenvectors();
  if (axes.determinant() < 0) axes.col(0) = -axes.col(0);
  shape.as_listed = Quaternion(axes).normalized();
  const Mat3 turn = shape.as_listed.toRotationMatrix();
  double radius = 0;
  for (const ShapeSphere& s : spheres)
    radius = std::max(radius, (s.at - moments.centre()).norm() + s.radius);
  shape.spheres.clear();
  for (const ShapeSphere& s : spheres)
    shape.spheres.push_back(
        {turn.transpose() * (s.at - moments.centre()) / radius, s.radius / radius});
  for (const ShapeSphere& s : shape.spheres) shape.arm = std::max(shape.arm, s.at.norm());
  shape.volume = moments.volume / (radius * radius * radius);
  shape.inertia = principal.eigenvalues() / (moments.volume * radius * radius);
  return shape;
}

std::vector<ShapeSphere> fill_ellipsoid(const Vec3& axes, int count) {
  std::array<int, 3> order{0, 1, 2};  // the longest first
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return axes[a] > axes[b]; });
  const double a = axes[order[0]], b = axes[order[1]], c = axes[order[2]];
  // A ball around (x, y, 0) reaches the ellipsoid at (x a^2/(a^2 - c^2), y b^2/(b^2 - c^2)):
  // centres fill the ellipse with semi-axes a - c^2/a and b - c^2/b.
  const double most_x = a - c * c / a, most_y = b - c * c / b;
  constexpr int steps = 40;  // each way
  std::vector<ShapeSphere> candidates;
  for (int k = 0; k <= steps; ++k)
    for (int l = 0; l <= steps; ++l) {
      // 0, +1, -1, +2 …: of equals the nearest to the middle comes first.
      const auto place = [](int m) {
        return (m % 2 == 1 ? 1.0 : -1.0) * ((m + 1) / 2) * 2 / steps;
      };
      const double x = place(k), y = place(l);
      if (x * x + y * y > 1 + 1e-12) continue;
      const double px = x * most_x, py = y * most_y;
      const double left =
          1 - (a > c ? px * px / (a * a - c * c) : 0) - (b > c ? py * py / (b * b - c * c) : 0);
      Vec3 at = Vec3::Zero();
      at[order[0]] = px;
      at[order[1]] = py;
      candidates.push_back({at, c * std::sqrt(left)});
    }
  std::vector<ShapeSphere> chosen{candidates.front()};
  std::vector<double> stands_out(candidates.size(), infinity);
  while (std::ssize(chosen) < count) {
    std::size_t next = 0;
    for (std::size_t k = 0; k < candidates.size(); ++k) {
      const double out = (candidates[k].at - chosen.back().at).norm() + candidates[k].radius -
                         chosen.back().radius;
      stands_out[k] = std::min(stands_out[k], out);
      if (stands_out[k] > stands_out[next] * (1 + 1e-12)) next = k;
    }
    if (stands_out[next] <= 1e-9 * c) break;
    chosen.push_back(candidates[next]);
  }
  return chosen;
}

}  // namespace spall
