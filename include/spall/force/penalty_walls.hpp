// Penalty contact with walls: the pairs' law, with a wall for the partner.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "spall/force/penalty_sweep.hpp"

namespace spall {

/// Up to eight bodies at walls; lanes that are left hold the last one again.
struct WallLanes {
  std::array<Index, lane_count> places;
  ContactLanes contact;
  SpringLanes spring;
  unsigned before = 0;  ///< lanes that touched a step ago

  WallLanes(const Bodies& bodies, const std::vector<Plane>& planes,
            std::span<const WallTouch> touches) {
    for (std::size_t l = 0; l < lane_count; ++l) {
      const WallTouch& t = touches[std::min(l, touches.size() - 1)];
      const Plane& plane = planes[t.wall];
      const double radius = bodies.radius[t.row];
      const double height = plane.normal.dot(bodies.position[t.row] - plane.point);
      const Vec3 surface = radius * bodies.angular_velocity[t.row];
      places[l] = doubles_a_row * t.row;
      set(contact.normal, l, -plane.normal);
      contact.overlap[l] = radius - height;
      contact.radius[l] = radius;
      contact.inverse_mass[l] = 1 / bodies.mass[t.row];
      contact.kappa[l] = 1;
      set(contact.velocity, l, -bodies.velocity[t.row]);
      set(contact.surface, l, surface);
      set(contact.rolling, l, -bodies.angular_velocity[t.row]);
      contact.twist[l] = -0.5 * bodies.angular_velocity[t.row].dot(plane.normal);
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

/// Adds the forces of walls to the rows and steps their springs.
template <class Model>
void sweep_walls(const Bodies& bodies, const std::vector<Plane>& planes, const Model& model,
                 std::vector<WallTouch>& walls, ForceRow* rows) {
  const std::span<WallTouch> all(walls);
  for (std::size_t first = 0; first < all.size(); first += lane_count) {
    const auto part = all.subspan(first, std::min(lane_count, all.size() - first));
    WallLanes eight(bodies, planes, part);
    ContactLanes& c = eight.contact;
    const LaneMask touching =
        model.touches(c.overlap, c.radius, eight.before) & (c.inverse_mass > 0.0);
    const ContactForce f = model(c, touching, eight.before, eight.spring);
    LaneVectors torque = c.radius * f.lever;
    if constexpr (Model::rolling) torque = torque - f.rolling;
    for (std::size_t l = 0; l < part.size(); ++l) {
      ForceRow& row = rows[part[l].row];
      row.force += RowHalf{-f.force.x[l], -f.force.y[l], -f.force.z[l], f.power[l]};
      if constexpr (Model::frictional)
        row.torque += RowHalf{torque.x[l], torque.y[l], torque.z[l], 0};
      part[l].touching = touching[l] != 0;
      if constexpr (Model::frictional) part[l].sliding = WallLanes::get(eight.spring.sliding, l);
      if constexpr (Model::rolling) part[l].rolling = WallLanes::get(eight.spring.rolling, l);
    }
  }
}

/// J, elastic.
template <class Model>
double wall_energy(const Bodies& bodies, const std::vector<Plane>& planes, const Model& model,
                   const std::vector<WallTouch>& walls) {
  const std::span<const WallTouch> all(walls);
  double energy = 0;
  for (std::size_t first = 0; first < all.size(); first += lane_count) {
    const auto part = all.subspan(first, std::min(lane_count, all.size() - first));
    const WallLanes eight(bodies, planes, part);
    const Lanes u = model.energy(eight.contact.overlap, eight.contact.radius, eight.before);
    for (std::size_t l = 0; l < part.size(); ++l) energy += u[l];
  }
  return energy;
}

}  // namespace spall
