// Rings about the line of flight, rays in each, and then the recoil of all that stays.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/hand_over.hpp"

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <vector>

#include "pairs/grid.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Ends of a ring differ by this part; so do neighbouring rays of a ring. What a body gets is wrong
/// by about this part of the distance over its radius; what all get is not.
constexpr double fineness = 0.02;

/// A body of the target, its place relative to the line of flight.
struct Boulder {
  BodyId id;
  Vec3 place;  ///< m: across, across, along the flight
  double radius, density;
  double mass = 0;               ///< kg, launched
  Vec3 momentum = Vec3::Zero();  ///< kg m/s, in the same axes
};

/// Momentum, and angular momentum about the world's origin.
struct Motion {
  Vec3 linear = Vec3::Zero(), angular = Vec3::Zero();
  double energy = 0;
};

double spin_inertia(const Bodies& bodies, Index b) {
  return moment_of_inertia(bodies.mass[b], bodies.radius[b]);
}

Motion motion_of(const Comm& comm, const Bodies& bodies) {
  std::array<double, 7> sums{};
  Eigen::Map<Vec3> linear(sums.data()), angular(sums.data() + 3);
  const bool spins = bodies.has(Field::angular_velocity);
  for (Index b = 0; b < bodies.owned; ++b) {
    const Vec3 p = bodies.mass[b] * bodies.velocity[b];
    linear += p;
    angular += bodies.position[b].cross(p);
    sums[6] += p.dot(bodies.velocity[b]) / 2;
    if (!spins) continue;
    const Vec3& spin = bodies.angular_velocity[b];
    angular += spin_inertia(bodies, b) * spin;
    sums[6] += spin_inertia(bodies, b) * spin.squaredNorm() / 2;
  }
  comm.sum(sums);
  return {Vec3(sums[0], sums[1], sums[2]), Vec3(sums[3], sums[4], sums[5]), sums[6]};
}

/// The surface where a line along the flight meets it: unit vectors.
struct Surface {
  Vec3 normal;  ///< outwards
  Vec3 away;    ///< along the surface, away from the site
};

/// The target's ellipsoid of moments.
class Ellipsoid {
 public:
  explicit Ellipsoid(const std::vector<Boulder>& boulders) {
    double mass = 0;
    for (const Boulder& one : boulders) mass += mass_of(one);
    for (const Boulder& one : boulders) center_ += mass_of(one) / mass * one.place;
    Eigen::Matrix3d second = Eigen::Matrix3d::Zero();
    for (const Boulder& one : boulders) {
      const Vec3 x = one.place - center_;
      second += mass_of(one) / mass *
                (x * x.transpose() + one.radius * one.radius / 5 * Eigen::Matrix3d::Identity());
    }
    // A uniform ellipsoid's second moment along a semi-axis s is s^2 / 5.
    form_ = (5 * second).inverse();
  }

  /// Where the line through `at` enters; `out`: from the site to there, across the flight. Beside
  /// the ellipsoid the normal is that of its limb, the point of the line that is nearest to it; at
  /// the limb the surface runs along the flight.
  Surface surface(const Vec3& at, const Vec3& out) const {
    // q(t) = (x + t e)^T F (x + t e) = 1 with x on the plane through the centre, e along z.
    const Vec3 x(at.x() - center_.x(), at.y() - center_.y(), 0), e = Vec3::UnitZ();
    const double ee = e.dot(form_ * e), xe = x.dot(form_ * e), xx = x.dot(form_ * x);
    const double root = std::sqrt(std::max(xe * xe - ee * (xx - 1), 0.0));
    const Vec3 normal = (form_ * (x + (-xe - root) / ee * e)).normalized();
    return {normal, root > 0 ? Vec3((out - out.dot(normal) * normal).normalized()) : e};
  }

 private:
  static double mass_of(const Boulder& one) { return one.density * ball_volume(one.radius); }
  Vec3 center_ = Vec3::Zero();
  Eigen::Matrix3d form_;
};

class Rays {
 public:
  explicit Rays(std::vector<Boulder>& boulders) : boulders_(boulders) {
    for (const Boulder& one : boulders) largest_ = std::max(largest_, one.radius);
  }

  double launch(double y, double z, double column, double area, const Vec3& velocity) {
    hits_.clear();
    const auto first = std::ranges::lower_bound(boulders_, y - largest_, {}, across);
    for (auto one = first; one != boulders_.end() && one->place.x() <= y + largest_; ++one) {
      const double dy = one->place.x() - y, dz = one->place.y() - z;
      const double half2 = one->radius * one->radius - dy * dy - dz * dz;
      if (half2 <= 0) continue;
      const double half = std::sqrt(half2);
      hits_.push_back({one->place.z() - half, 2 * half, &*one});
    }
    std::ranges::sort(hits_, [](const Hit& a, const Hit& b) {
      return a.enters < b.enters || (a.enters == b.enters && a.boulder->id < b.boulder->id);
    });
    double left = column;
    for (const Hit& hit : hits_) {
      const double taken = std::min(left, hit.boulder->density * hit.chord);
      hit.boulder->mass += taken * area;
      hit.boulder->momentum += taken * area * velocity;
      left -= taken;
      if (left <= 0) break;
    }
    return (column - left) * area;
  }

 private:
  static double across(const Boulder& one) { return one.place.x(); }
  struct Hit {
    double enters, chord;  ///< m
    Boulder* boulder;
  };
  std::vector<Boulder>& boulders_;
  double largest_ = 0;
  std::vector<Hit> hits_;
};

/// All bodies but the impactor on every rank, in an order that no rank changes.
std::vector<Boulder> gather_boulders(const Comm& comm, const Bodies& bodies, BodyId impactor,
                                     const Vec3& on_line, const Eigen::Matrix3d& axes) {
  std::vector<double> own;
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.id[b] == impactor) continue;
    const Vec3 place = axes.transpose() * (bodies.position[b] - on_line);
    const double r = bodies.radius[b];
    own.insert(own.end(), {static_cast<double>(bodies.id[b]), place.x(), place.y(), place.z(), r,
                           bodies.mass[b] / ball_volume(r)});
  }
  const std::vector<double> all = comm.all_gather(std::span<const double>(own));
  std::vector<Boulder> boulders;
  for (std::size_t k = 0; k < all.size(); k += 6)
    boulders.push_back({static_cast<BodyId>(all[k]), Vec3(all[k + 1], all[k + 2], all[k + 3]),
                        all[k + 4], all[k + 5]});
  std::ranges::sort(boulders, [](const Boulder& a, const Boulder& b) {
    return a.place.x() < b.place.x() || (a.place.x() == b.place.x() && a.id < b.id);
  });
  return boulders;
}

/// The place of the first boulder in the way of a sphere of this radius; their count without any.
std::size_t first_in_the_way(const std::vector<Boulder>& boulders, double radius) {
  std::size_t first = boulders.size();
  double least = infinity;
  for (std::size_t k = 0; k < boulders.size(); ++k) {
    const double reach = boulders[k].radius + radius;
    const double half2 = reach * reach - boulders[k].place.head<2>().squaredNorm();
    if (half2 <= 0) continue;
    const double enters = boulders[k].place.z() - std::sqrt(half2);
    if (enters > least || (enters == least && boulders[k].id > boulders[first].id)) continue;
    least = enters;
    first = k;
  }
  return first;
}

/// Leaves those boulders that hang together with the struck one: chains of gaps join them, each
/// narrower than the mean of both radii. So narrow are the pores of a pile, loose ones too; what
/// lies behind a wider gap feels nothing of the impact yet.
void keep_target(std::vector<Boulder>& boulders, std::size_t struck) {
  Bodies bodies;
  bodies.fields = {};
  resize(bodies, static_cast<Index>(boulders.size()));
  bodies.owned = bodies.size();
  std::vector<double> half_a_radius;
  for (Index b = 0; b < bodies.owned; ++b) {
    bodies.id[b] = boulders[b].id;
    bodies.position[b] = boulders[b].place;
    bodies.radius[b] = boulders[b].radius;
    half_a_radius.push_back(boulders[b].radius / 2);
  }
  std::vector<Index> piece(boulders.size());  // a place on the way to that which names the piece
  std::iota(piece.begin(), piece.end(), 0);
  const auto name_of = [&](Index b) {
    while (piece[b] != b) b = piece[b] = piece[piece[b]];
    return b;
  };
  std::vector<Index> partners;
  find_partners(bodies, {.of_rows = half_a_radius}, ListedWith::lower_row, partners,
                [&](Index row, Index) {
                  for (const Index other : partners) piece[name_of(other)] = name_of(row);
                  partners.clear();
                });
  const Index name = name_of(static_cast<Index>(struck));
  std::vector<Boulder> kept;
  for (Index b = 0; b < bodies.owned; ++b)
    if (name_of(b) == name) kept.push_back(boulders[b]);
  boulders = std::move(kept);
}

/// Lets the mass that is not launched recoil rigidly, by `linear` and `angular` about the origin.
/// `launched`: kg, of each owned body; all of a body that has no part in the recoil.
void recoil(const Comm& comm, const Vec3& linear, const Vec3& angular,
            const std::vector<double>& launched, Bodies& bodies) {
  const bool spins = bodies.has(Field::angular_velocity);
  std::array<double, 4> first{};
  for (Index b = 0; b < bodies.owned; ++b) {
    const double w = bodies.mass[b] - launched[b];
    first[0] += w;
    for (int k = 0; k < 3; ++k) first[1 + k] += w * bodies.position[b][k];
  }
  comm.sum(first);
  const Vec3 center = Vec3(first[1], first[2], first[3]) / first[0];
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  for (Index b = 0; b < bodies.owned; ++b) {
    const double w = bodies.mass[b] - launched[b];
    const Vec3 x = bodies.position[b] - center;
    const double own = spins ? spin_inertia(bodies, b) * w / bodies.mass[b] : 0;
    inertia += w * (x.squaredNorm() * Eigen::Matrix3d::Identity() - x * x.transpose()) +
               own * Eigen::Matrix3d::Identity();
  }
  comm.sum(std::span<double>(inertia.data(), 9));
  const Vec3 shift = linear / first[0];
  // Bodies on one line have no moment about it, nor anything that could turn them so.
  const Vec3 turn = inertia.completeOrthogonalDecomposition().solve(angular - center.cross(linear));
  for (Index b = 0; b < bodies.owned; ++b) {
    const double share = 1 - launched[b] / bodies.mass[b];
    bodies.velocity[b] += share * (shift + turn.cross(bodies.position[b] - center));
    if (spins) bodies.angular_velocity[b] += share * turn;
  }
}

}  // namespace

HandOver hand_over_flow(const Comm& comm, const Impactor& impactor, BodyId id, Bodies& bodies) {
  const PointSource& source = *impactor.coupling;
  const Motion before = motion_of(comm, bodies);
  Vec3 on_line = Vec3::Zero();
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.id[b] == id) on_line = bodies.position[b];
  on_line = comm.sum(on_line);
  const Vec3 d = impactor.direction;

  Eigen::Matrix3d axes;
  axes.col(2) = d;
  axes.col(0) = d.unitOrthogonal();
  axes.col(1) = d.cross(axes.col(0));
  std::vector<Boulder> boulders = gather_boulders(comm, bodies, id, on_line, axes);

  const std::size_t struck = first_in_the_way(boulders, impactor.radius);
  require(struck < boulders.size(), "{}: no body lies on the line of flight", impactor.place);
  keep_target(boulders, struck);
  std::vector<BodyId> target;
  for (const Boulder& one : boulders) target.push_back(one.id);
  std::ranges::sort(target);
  const auto in_target = [&](Index b) { return std::ranges::binary_search(target, bodies.id[b]); };
  std::array<double, 4> sums{};  // the target's momentum and mass
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!in_target(b)) continue;
    Eigen::Map<Vec3>(sums.data()) += bodies.mass[b] * bodies.velocity[b];
    sums[3] += bodies.mass[b];
  }
  comm.sum(sums);
  const Vec3 drift = Vec3(sums[0], sums[1], sums[2]) / sums[3];

  HandOver result;
  result.a = impactor.radius;
  result.delta = impactor.mass / ball_volume(impactor.radius);
  result.hand_over = source.hand_over;
  const LaunchFlow flow(source, result.a, result.delta, impactor.speed);
  double farthest = 0;
  for (const Boulder& one : boulders)
    farthest = std::max(farthest, one.place.head<2>().norm() + one.radius);
  result.reach = std::min(farthest, flow.end());

  const Launched inner = flow.between(flow.begin(), source.hand_over);
  result.inner_mass = inner.mass;
  result.inner_momentum = inner.momentum * std::sin(source.angle);
  result.inner_energy = inner.energy;

  const Ellipsoid ellipsoid(boulders);
  Rays rays(boulders);
  const double across = std::log(result.reach / source.hand_over);
  const int rings = std::max(0, static_cast<int>(std::ceil(across / fineness)));
  const int around = static_cast<int>(std::ceil(2 * pi / fineness));
  for (int ring = 0; ring < rings; ++ring) {
    const double from = source.hand_over * std::exp(across * ring / rings);
    const double to = source.hand_over * std::exp(across * (ring + 1) / rings);
    const Launched here = flow.between(from, to);
    result.outer_mass += here.mass;
    result.outer_momentum += here.momentum;
    result.outer_energy += here.energy;
    const double x = std::sqrt((from * from + to * to) / 2);  // halves the area
    const double area = pi * (to * to - from * from) / around;
    for (int k = 0; k < around; ++k) {
      const double phi = 2 * pi * (k + 0.5) / around;
      const Vec3 out(std::cos(phi), std::sin(phi), 0);
      const Surface here_is = source.surface == LaunchSurface::ellipsoid
                                  ? ellipsoid.surface(x * out, out)
                                  : Surface{.normal = -Vec3::UnitZ(), .away = out};
      const Vec3 launch =
          std::sin(source.angle) * here_is.normal + std::cos(source.angle) * here_is.away;
      result.found_mass += rays.launch(x * out.x(), x * out.y(), here.mass / (around * area), area,
                                       here.momentum / here.mass * launch);
    }
  }
  require(result.found_mass > 0,
          "{}: no body lies where the flow launches matter, {:.4g} m and more from the site: a "
          "smaller hand_over is wanted",
          impactor.place, source.hand_over);

  std::ranges::sort(boulders, {}, &Boulder::id);
  std::vector<double> launched(bodies.owned, 0.0);
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.id[b] == id) {
      // Its own momentum has gone into the flow; it takes the inner part's along.
      launched[b] = bodies.mass[b];
      bodies.velocity[b] = drift - result.inner_momentum / bodies.mass[b] * d;
      continue;
    }
    if (!in_target(b)) {
      launched[b] = bodies.mass[b];
      continue;
    }
    const Boulder& one = *std::ranges::lower_bound(boulders, bodies.id[b], {}, &Boulder::id);
    launched[b] = std::min(one.mass, bodies.mass[b]);
    bodies.velocity[b] += axes * one.momentum / bodies.mass[b];
  }
  for (const Boulder& one : boulders) {
    result.given_momentum -= one.momentum.z();
    result.count += one.mass > 0;
  }
  const Motion thrown = motion_of(comm, bodies);
  recoil(comm, before.linear - thrown.linear, before.angular - thrown.angular, launched, bodies);

  const Motion after = motion_of(comm, bodies);
  const double unit = impactor.mass * impactor.speed;
  result.momentum_closure = (after.linear - before.linear).norm() / unit;
  result.angular_closure = (after.angular - before.angular).norm() / (unit * farthest);
  result.energy = impactor.mass * impactor.speed * impactor.speed / 2;
  result.heat = before.energy - after.energy;
  result.carrier_energy = result.inner_momentum * result.inner_momentum / (2 * impactor.mass);
  result.flow_energy = result.energy - result.carrier_energy - result.heat;
  require(result.heat >= 0,
          "{}.coupling: bodies would get {:.3g} and the impactor's {:.3g} of the energy of the "
          "impact: another hand_over is wanted",
          impactor.place, result.flow_energy / result.energy,
          result.carrier_energy / result.energy);
  return result;
}

}  // namespace spall
