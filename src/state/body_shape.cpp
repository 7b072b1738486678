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
  /// Of the part of a line along z at (x, y).
  void add_line(double x, double y, double low, double high) {
    const double l = high - low, z = (high * high - low * low) / 2;
    const double zz = (high * high * high - low * low * low) / 3;
    volume += l;
    first += Vec3(l * x, l * y, z);
    second(0, 0) += l * x * x;
    second(0, 1) += l * x * y;
    second(1, 1) += l * y * y;
    second(0, 2) += z * x;
    second(1, 2) += z * y;
    second(2, 2) += zz;
  }
};

/// A sphere where a line along z runs through it.
struct Chord {
  std::size_t sphere;
  double z, half2;  // of its middle; of its half, squared
};

/// The part of chord `own` of a line that is the sphere's own: of points in several spheres, those
/// for which |x - c|^2 - r^2 is least. The spheres' parts add up to the union.
std::array<double, 2> own_part(const std::vector<Chord>& chords, std::size_t own) {
  const auto& [sphere, z, half2] = chords[own];
  const double half = std::sqrt(half2);
  double low = z - half, high = z + half;
  for (std::size_t k = 0; k < chords.size(); ++k) {
    if (k == own) continue;
    const double apart = z - chords[k].z;
    const double over = (z * z - chords[k].z * chords[k].z - half2 + chords[k].half2) / 2;
    if (apart > 0)
      low = std::max(low, over / apart);
    else if (apart < 0)
      high = std::min(high, over / apart);
    else if (over > 0 || (over == 0 && k < own))
      return {z, z};
  }
  return {low, std::max(low, high)};
}

/// Of each sphere's part of the union, by lines along z through the middles of n x n squares over
/// all of it.
std::vector<Moments> moments_by_lines(std::span<const ShapeSphere> spheres, int n) {
  Eigen::AlignedBox2d box;
  for (const ShapeSphere& s : spheres) {
    box.extend(Eigen::Vector2d(s.at.head<2>().array() - s.radius));
    box.extend(Eigen::Vector2d(s.at.head<2>().array() + s.radius));
  }
  const Eigen::Vector2d d = box.sizes() / n;
  std::vector<Moments> parts(spheres.size());
  std::vector<Chord> chords;
  std::vector<std::size_t> of_row;
  for (int j = 0; j < n; ++j) {
    const double y = box.min().y() + (j + 0.5) * d.y();
    of_row.clear();
    for (std::size_t s = 0; s < spheres.size(); ++s)
      if (std::abs(y - spheres[s].at.y()) < spheres[s].radius) of_row.push_back(s);
    for (int i = 0; i < n; ++i) {
      const double x = box.min().x() + (i + 0.5) * d.x();
      chords.clear();
      for (std::size_t s : of_row) {
        const Vec3& at = spheres[s].at;
        const double dx = x - at.x(), dy = y - at.y();
        const double half2 = spheres[s].radius * spheres[s].radius - dx * dx - dy * dy;
        if (half2 > 0) chords.push_back({s, at.z(), half2});
      }
      for (std::size_t k = 0; k < chords.size(); ++k) {
        const auto [low, high] = own_part(chords, k);
        if (low < high) parts[chords[k].sphere].add_line(x, y, low, high);
      }
    }
  }
  const double area = d.prod();
  for (Moments& part : parts) {
    part.second.triangularView<Eigen::StrictlyLower>() = part.second.transpose();
    part.volume *= area;
    part.first *= area;
    part.second *= area;
  }
  return parts;
}

Moments sum_of(const std::vector<Moments>& parts) {
  Moments sum;
  for (const Moments& part : parts) {
    sum.volume += part.volume;
    sum.first += part.first;
    sum.second += part.second;
  }
  return sum;
}

/// With twice the lines until that changes nothing any more. Halving the spacing lowers the error
/// by more than two, so the last change is more than what is left.
std::vector<Moments> moments_of(std::span<const ShapeSphere> spheres) {
  constexpr int fewest = 128, most = 8192;
  Moments coarse = sum_of(moments_by_lines(spheres, fewest));
  for (int n = 2 * fewest;; n *= 2) {
    std::vector<Moments> parts = moments_by_lines(spheres, n);
    const Moments fine = sum_of(parts);
    const double least = Eigen::SelfAdjointEigenSolver<Mat3>(fine.inertia(), Eigen::EigenvaluesOnly)
                             .eigenvalues()
                             .minCoeff();
    const double change =
        std::max(std::abs(fine.volume - coarse.volume) / fine.volume,
                 (fine.inertia() / fine.volume - coarse.inertia() / coarse.volume).norm() *
                     fine.volume / least);
    if (change < shape_error || n == most) return parts;
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

  const std::vector<Moments> parts = moments_of(spheres);
  const Moments moments = sum_of(parts);
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
  shape.parts.clear();
  for (const Moments& part : parts)
    if (part.volume > 0)
      shape.parts.push_back({turn.transpose() * (part.centre() - moments.centre()) / radius,
                             part.volume / moments.volume});
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

ShapeSphere placed_sphere(const ShapeSphere& sphere, const Vec3& center, double radius,
                          const Quaternion& turn) {
  return {center + radius * (turn * sphere.at), radius * sphere.radius};
}

Mat3 turned_tensor(const Quaternion& turn, const Vec3& principal) {
  const Mat3 axes = turn.toRotationMatrix();
  return axes * principal.asDiagonal() * axes.transpose();
}

Mat3 inertia_factor(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  if (shapes.empty() || bodies.shape[b] == 0) return sphere_inertia * Mat3::Identity();
  return turned_tensor(bodies.orientation[b], shape_of(shapes, bodies, b).inertia);
}

Mat3 inverse_inertia_factor(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  if (shapes.empty() || bodies.shape[b] == 0) return 1 / sphere_inertia * Mat3::Identity();
  return turned_tensor(bodies.orientation[b], shape_of(shapes, bodies, b).inertia.cwiseInverse());
}

double turning_speed(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  if (shapes.empty() || bodies.shape[b] == 0) return 0;
  return bodies.radius[b] * shape_of(shapes, bodies, b).arm * bodies.angular_velocity[b].norm();
}

Vec3 momentum_of_spin(const BodyShapes& shapes, const Bodies& bodies, Index b, const Vec3& spin) {
  const double mass = bodies.mass[b], radius = bodies.radius[b];
  if (shapes.empty() || bodies.shape[b] == 0) return moment_of_inertia(mass, radius) * spin;
  return mass * radius * radius * (inertia_factor(shapes, bodies, b) * spin);
}

Vec3 spin_momentum(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  return momentum_of_spin(shapes, bodies, b, bodies.angular_velocity[b]);
}

Vec3 spin_of_momentum(const BodyShapes& shapes, const Bodies& bodies, Index b,
                      const Vec3& momentum) {
  const double mass = bodies.mass[b], radius = bodies.radius[b];
  if (shapes.empty() || bodies.shape[b] == 0) return momentum / moment_of_inertia(mass, radius);
  return inverse_inertia_factor(shapes, bodies, b) * momentum / (mass * radius * radius);
}

}  // namespace spall
