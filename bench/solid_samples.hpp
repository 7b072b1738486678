// Discs of a solid's crystal that fly at each other: what the benches of its law are made of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <string>
#include <vector>

#include "lab.hpp"
#include "potential/settings.hpp"
#include "scene/case.hpp"
#include "scene/packing.hpp"

namespace spall {

struct Sample {
  Solid solid;
  PairPotential law;
  double mass, d;
  double step() const { return 0.4 * longest_step(law, mass); }
};

/// The turn that lays a direction of the crystal, "100", "110" or "111", along z; another number is
/// the seed of a random turn.
inline Vec3 turn(const std::string& orientation) {
  Vec3 along = Vec3::UnitZ();
  if (orientation == "100") return Vec3::Zero();
  if (orientation == "110")
    along = {1, 1, 0};
  else if (orientation == "111")
    along = {1, 1, 1};
  else
    return random_rotation(std::strtoull(orientation.c_str(), nullptr, 10));
  const Eigen::AngleAxisd rotation(Eigen::Quaterniond::FromTwoVectors(along, Vec3::UnitZ()));
  return rotation.angle() * rotation.axis();
}

struct Disc {
  double low, high, radius, velocity;  // in spacings; m/s
  bool fixed = false;
};

/// A world of discs of the crystal about the z axis, each a group.
inline Lab make_discs(const Comm& comm, const Sample& m, const std::vector<Disc>& discs,
                      const Vec3& rotation, std::vector<Vec3>* start = nullptr) {
  Lab world;
  world.comm = comm;
  world.potential.law = m.law;
  std::vector<std::pair<Vec3, int>> sites;
  for (std::size_t g = 0; g < discs.size(); ++g) {
    const Disc& disc = discs[g];
    const Volume volume{
        .shape = Shape::cylinder,
        .center = {0, 0, (disc.low + disc.high) / 2 * m.d},
        .extents = m.d * Vec3(2 * disc.radius, 2 * disc.radius, disc.high - disc.low)};
    const Packing packing{.radius = m.d / 2, .rotation = rotation};
    place_lattice(LatticeKind::fcc, volume, packing,
                  [&](const Vec3& x) { sites.emplace_back(x, static_cast<int>(g)); });
  }
  if (start)
    for (const auto& [x, g] : sites) start->push_back(x);
  Bodies& bodies = world.bodies;
  const auto all = static_cast<std::int64_t>(sites.size());
  for (std::int64_t id = all * comm.rank / comm.size; id < all * (comm.rank + 1) / comm.size;
       ++id) {
    const auto& [x, g] = sites[static_cast<std::size_t>(id)];
    const Index b = append_row(bodies);
    bodies.id[b] = id;
    bodies.group[b] = g;
    bodies.radius[b] = m.d / 2;
    bodies.mass[b] = discs[static_cast<std::size_t>(g)].fixed ? infinity : m.mass;
    bodies.position[b] = x;
    bodies.velocity[b] = {0, 0, discs[static_cast<std::size_t>(g)].velocity};
  }
  bodies.owned = bodies.size();
  return world;
}

/// A plate, `length` spacings thick, flies at one twice as thick: the strength that this tells, and
/// where it tears. Collective.
void spall_test(const Comm& comm, const Sample& sample, const std::string& orientation,
                double speed, double length);

}  // namespace spall
