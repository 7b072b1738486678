// Each part of the energy, L_k^2 / (2 I_k), alone turns the body about its axis k, without error.
// SPDX-License-Identifier: BSD-3-Clause
#include "engine/free_turn.hpp"

#include <cmath>

#include "engine/split_turn.hpp"

namespace spall {
Turn turn_freely(const Vec3& inertia, const Turn& from, double h) {
  const auto& q = from.orientation.coeffs();
  const Vec3& spin = from.angular_velocity;
  const SplitTurn<double> now =
      split_turn<double>({inertia[0], inertia[1], inertia[2]},
                         {{q[0], q[1], q[2], q[3]}, {spin[0], spin[1], spin[2]}}, h);
  const auto& [x, y, z, w] = now.orientation;
  return {Quaternion(w, x, y, z), Vec3(now.spin[0], now.spin[1], now.spin[2])};
}

Quaternion turned_by(const Vec3& rotation, const Quaternion& orientation) {
  const double angle = rotation.norm();
  const Vec3 v = (angle > 0 ? std::sin(angle / 2) / angle : 0.5) * rotation;
  return (Quaternion(std::cos(angle / 2), v.x(), v.y(), v.z()) * orientation).normalized();
}

}  // namespace spall
