// Each part of the energy, L_k^2 / (2 I_k), alone turns the body about its axis k, without error.
// SPDX-License-Identifier: BSD-3-Clause
#include "rigid/free_turn.hpp"

#include <array>
#include <cmath>
#include <utility>

namespace spall {

Turn turn_freely(const Vec3& inertia, const Turn& from, double h) {
  const auto times = [](const Mat3& axes, const Vec3& principal, const Vec3& v) -> Vec3 {
    return axes * principal.cwiseProduct(axes.transpose() * v);
  };
  // In the world's frame it stays.
  const Vec3 momentum = times(from.orientation.toRotationMatrix(), inertia, from.angular_velocity);
  Quaternion q = from.orientation;
  Vec3 l = q.conjugate() * momentum;
  constexpr std::array<std::pair<int, double>, 5> parts{
      {{0, 0.5}, {1, 0.5}, {2, 1.0}, {1, 0.5}, {0, 0.5}}};
  for (const auto& [axis, share] : parts) {
    const double half_angle = share * h * l[axis] / inertia[axis] / 2;
    Quaternion turn(std::cos(half_angle), 0, 0, 0);
    turn.vec()[axis] = std::sin(half_angle);
    q = q * turn;
    l = turn.conjugate() * l;
  }
  q.normalize();
  const Mat3 axes = q.toRotationMatrix();
  const Vec3 inverse = inertia.cwiseInverse();
  Vec3 omega = times(axes, inverse, momentum);
  // Axes are normal to each other to round-off, which adds up over many steps.
  omega += times(axes, inverse, momentum - times(axes, inertia, omega));
  return {q, omega};
}

Quaternion turned_by(const Vec3& rotation, const Quaternion& orientation) {
  const double angle = rotation.norm();
  const Vec3 v = (angle > 0 ? std::sin(angle / 2) / angle : 0.5) * rotation;
  return (Quaternion(std::cos(angle / 2), v.x(), v.y(), v.z()) * orientation).normalized();
}

}  // namespace spall
