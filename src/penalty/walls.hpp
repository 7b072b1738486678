// Penalty contact with walls: the pairs' law, with a wall for the partner.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "penalty/sweep.hpp"
#include "state/reaction.hpp"

namespace spall {

/// Up to eight bodies at walls; lanes that are left hold the last one again.
struct WallLanes {
  std::array<Index, lane_count> places;
  ContactLanes contact;
  SpringLanes spring;
  unsigned before = 0;  ///< lanes that touched a step ago

  WallLanes(const Bodies& bodies, const Walls& walls, std::span<const WallTouch> touches) {
    for (std::size_t l = 0; l < lane_count; ++l) {
      const WallTouch& t = touches[std::min(l, touches.size() - 1)];
      const Face face = face_of(walls, t.wall, bodies.position[t.row]);
      const double radius = bodies.radius[t.row];
      const Vec3 surface = radius * bodies.angular_velocity[t.row];
      places[l] = doubles_a_row * t.row;
      set(contact.normal, l, -face.normal);
      contact.overlap[l] = radius - face.height;
      contact.radius[l] = radius;
      contact.inverse_mass[l] = 1 / bodies.mass[t.row];
      contact.kappa[l] = 1;
      set(contact.velocity, l, -bodies.velocity[t.row]);
      set(contact.surface, l, surface);
      set(contact.rolling, l, -bodies.angular_velocity[t.row]);
      contact.twist[l] = -0.5 * bodies.angular_velocity[t.row].dot(face.normal);
      set(spring.sliding, l, t.sliding);
      set(spring.rolling, l, t.rolling);
      before |= t.touching ? 1u << l : 0;
    }
  }
  static void set(LaneVectors& v, std::size_t l, const Vec3& value) {
    v.x[l] = value.x();
    v.y[l] = value.y();
    v.z[l] = value.z();
  }
  static Vec3 get(const LaneVectors& v, std::size_t l) { return {v.x[l], v.y[l], v.z[l]}; }
};

/// Of the body and of the wall, which may be of the body's own.
inline auto materials_at_walls(const Bodies& bodies, const Walls& walls,
                               std::span<const WallTouch> touches) {
  return [&bodies, walls, touches](std::size_t l) {
    const WallTouch& t = touches[std::min(l, touches.size() - 1)];
    const int own = bodies.material[t.row], of_wall = walls.material(t.wall);
    return std::array{own, of_wall == same_material ? own : of_wall};
  };
}

/// Adds the forces of walls to the rows and steps their springs. `received`, by wall, grows by what
/// they exert over `h` (s). Returns the largest overlap over the radius.
template <class Model>
double sweep_walls(const Bodies& bodies, const Walls& walls, const Model& model, double h,
                   std::vector<WallTouch>& touches, ForceRow* rows,
                   std::vector<Reaction>& received) {
  const std::span<WallTouch> all(touches);
  double deepest = 0;
  for (std::size_t first = 0; first < all.size(); first += lane_count) {
    const auto part = all.subspan(first, std::min(lane_count, all.size() - first));
    WallLanes eight(bodies, walls, part);
    ContactLanes& c = eight.contact;
    const auto& law = model.of(materials_at_walls(bodies, walls, part));
    const LaneMask touching =
        law.touches(c.overlap, c.radius, eight.before) & (c.inverse_mass > 0.0);
    const ContactForce f = law(c, touching, eight.before, eight.spring);
    LaneVectors torque = c.radius * f.lever;
    if constexpr (Model::rolling) torque = torque - f.rolling;
    for (std::size_t l = 0; l < part.size(); ++l) {
      ForceRow& row = rows[part[l].row];
      row.force += RowHalf{-f.force.x[l], -f.force.y[l], -f.force.z[l], f.power[l]};
      if constexpr (Model::frictional)
        row.torque += RowHalf{torque.x[l], torque.y[l], torque.z[l], 0};
      const Vec3 push = WallLanes::get(f.force, l);
      if (!push.isZero(0))
        Reactions::at(received, part[l].wall)
            .add(bodies.position[part[l].row], h * push,
                 Model::frictional ? Vec3(-h * WallLanes::get(torque, l)) : Vec3(Vec3::Zero()));
      part[l].touching = touching[l] != 0;
      if (part[l].touching) deepest = std::max(deepest, c.overlap[l] / c.radius[l]);
      if constexpr (Model::frictional) part[l].sliding = WallLanes::get(eight.spring.sliding, l);
      if constexpr (Model::rolling) part[l].rolling = WallLanes::get(eight.spring.rolling, l);
    }
  }
  return deepest;
}

/// J, elastic.
template <class Model>
double wall_energy(const Bodies& bodies, const Walls& walls, const Model& model,
                   const std::vector<WallTouch>& touches) {
  const std::span<const WallTouch> all(touches);
  double energy = 0;
  for (std::size_t first = 0; first < all.size(); first += lane_count) {
    const auto part = all.subspan(first, std::min(lane_count, all.size() - first));
    const WallLanes eight(bodies, walls, part);
    const Lanes u = model.of(materials_at_walls(bodies, walls, part))
                        .energy(eight.contact.overlap, eight.contact.radius, eight.before);
    for (std::size_t l = 0; l < part.size(); ++l)
      if (eight.contact.inverse_mass[l] > 0) energy += u[l];
  }
  return energy;
}

}  // namespace spall
