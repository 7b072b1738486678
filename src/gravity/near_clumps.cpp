// A search of its own, since gravity is asked for before contacts are; ghosts are fetched for it.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/near_clumps.hpp"

#include <algorithm>
#include <cmath>

#include "base/kernels.hpp"
#include "domain/halo.hpp"
#include "pairs/grid.hpp"
#include "spall/lanes.hpp"

namespace spall {
namespace {

struct PointMass {
  Vec3 arm;  ///< m, from the body's centre
  double mass;
};

/// Eight parts; lanes that are left over hold massless ones.
struct EightParts {
  Lanes x{}, y{}, z{}, mass{};
};

/// The parts of all bodies, one body after another: those of row b are [first[b], first[b + 1]) of
/// the points, and the same by eights: to read lanes one by one takes half as long again.
struct Parts {
  std::vector<PointMass> points;
  std::vector<EightParts> eights;
  std::vector<std::size_t> first{0}, first_eight{0};

  Parts(const BodyShapes& shapes, const Bodies& bodies) {
    for (Index b = 0; b < bodies.size(); ++b) {
      const Mat3 turn = bodies.orientation[b].toRotationMatrix();
      std::size_t lane = 0;
      for (const ShapePart& part : shape_of(shapes, bodies, b).parts) {
        const PointMass& point = points.emplace_back(bodies.radius[b] * (turn * part.centre),
                                                     bodies.mass[b] * part.share);
        if (lane == 0) eights.emplace_back();
        EightParts& eight = eights.back();
        eight.x[lane] = point.arm.x();
        eight.y[lane] = point.arm.y();
        eight.z[lane] = point.arm.z();
        eight.mass[lane] = point.mass;
        lane = (lane + 1) % lane_count;
      }
      first.push_back(points.size());
      first_eight.push_back(eights.size());
    }
  }
  std::span<const PointMass> of(Index b) const {
    return std::span(points).subspan(first[b], first[b + 1] - first[b]);
  }
  std::span<const EightParts> eights_of(Index b) const {
    return std::span(eights).subspan(first_eight[b], first_eight[b + 1] - first_eight[b]);
  }
};

/// Before the factor G: what the parts of the second body of a pair do to the first; on the second
/// acts the opposite force.
struct PartsPull {
  double energy = 0;
  Vec3 force = Vec3::Zero(), torque_i = Vec3::Zero(), torque_j = Vec3::Zero();
};

PartsPull pull_of_parts(std::span<const PointMass> of_i, std::span<const EightParts> of_j,
                        const Vec3& apart) {
  PartsPull sum;
  Lanes energy{}, turn_x{}, turn_y{}, turn_z{};
  for (const PointMass& a : of_i) {
    const Vec3 from = apart - a.arm;
    Lanes x{}, y{}, z{};
    for (const EightParts& b : of_j) {
      const Lanes dx = b.x + from.x(), dy = b.y + from.y(), dz = b.z + from.z();
      const Lanes inverse = inverse_sqrt(dx * dx + (dy * dy + dz * dz));
      const Lanes product = a.mass * (b.mass * inverse);
      const Lanes factor = product * (inverse * inverse);
      const Lanes fx = factor * dx, fy = factor * dy, fz = factor * dz;
      energy -= product;
      x += fx;
      y += fy;
      z += fz;
      turn_x += b.z * fy - b.y * fz;
      turn_y += b.x * fz - b.z * fx;
      turn_z += b.y * fx - b.x * fy;
    }
    const Vec3 on_a(sum_of_lanes(x), sum_of_lanes(y), sum_of_lanes(z));
    sum.force += on_a;
    sum.torque_i += a.arm.cross(on_a);
  }
  sum.energy = sum_of_lanes(energy);
  sum.torque_j = {sum_of_lanes(turn_x), sum_of_lanes(turn_y), sum_of_lanes(turn_z)};
  return sum;
}

/// S at the distance r, and dS/dr.
struct Fading {
  double share, slope;
};
Fading fading(double r, double furthest) {
  const double y = 2 * r / furthest - 1;
  if (y <= 0) return {1, 0};
  return {1 - y * y * y * (10 - 15 * y + 6 * y * y), -60 * y * y * (1 - y) * (1 - y) / furthest};
}

}  // namespace

NearSearch search_for_near_clumps(const Bodies& bodies, double near_clumps) {
  NearSearch search;
  Bodies& copy = search.bodies;
  copy.fields = {Field::shape, Field::orientation};
  resize(copy, bodies.owned);
  copy.owned = bodies.owned;
  const auto take = [&](const auto& from, auto& to) {
    std::copy_n(from.begin(), bodies.owned, to.begin());
  };
  take(bodies.id, copy.id);
  take(bodies.radius, copy.radius);
  take(bodies.mass, copy.mass);
  take(bodies.position, copy.position);
  take(bodies.shape, copy.shape);
  take(bodies.orientation, copy.orientation);
  for (const double radius : copy.radius) search.reach.push_back((near_clumps - 1) * radius);
  return search;
}

SPALL_KERNEL(std::vector<Vec3>, attract_near_clumps, (const World& world, GravityField& field),
             (world, field)) {
  const double near = world.gravity.near_clumps, constant = world.gravity.constant;
  NearSearch search = search_for_near_clumps(world.bodies, near);
  Bodies& bodies = search.bodies;
  make_halo(world.comm, bodies, search.reach);
  const Parts parts(world.shapes, bodies);

  std::vector<Vec3> torque(bodies.owned, Vec3::Zero());
  std::vector<Index> partners;
  const auto attract = [&](Index row, Index) {
    for (const Index partner : partners) {
      if (bodies.shape[row] == 0 && bodies.shape[partner] == 0) continue;
      // The same bits on both ranks of a pair: their forces are opposite then.
      const bool in_order = bodies.id[row] < bodies.id[partner];
      const Index i = in_order ? row : partner, j = in_order ? partner : row;
      const Vec3 x = bodies.position[j] - bodies.position[i];
      const double r = x.norm(), furthest = near * (bodies.radius[i] + bodies.radius[j]);
      if (r == 0 || r >= furthest) continue;
      const PartsPull pull = pull_of_parts(parts.of(i), parts.eights_of(j), x);
      const double product = bodies.mass[i] * bodies.mass[j];
      const double energy = pull.energy + product / r;
      const Fading fade = fading(r, furthest);
      const Vec3 force =
          fade.share * (pull.force - product / (r * r * r) * x) + fade.slope * energy / r * x;
      const auto add = [&](Index b, double sign, const Vec3& turns) {
        if (b >= bodies.owned) return;
        field.acceleration[b] += sign * constant / bodies.mass[b] * force;
        field.potential[b] += constant / bodies.mass[b] * fade.share * energy;
        torque[b] += constant * fade.share * turns;
      };
      add(i, 1, pull.torque_i);
      add(j, -1, pull.torque_j);
    }
    partners.clear();
  };
  find_partners(bodies, {.of_rows = search.reach}, ListedWith::lower_row, partners, attract);

  for (Index b = 0; b < bodies.owned; ++b)
    torque[b] = spin_of_momentum(world.shapes, bodies, b, torque[b]);
  return torque;
}

}  // namespace spall
