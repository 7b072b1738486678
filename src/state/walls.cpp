// Walls as a point sees them.
// SPDX-License-Identifier: BSD-3-Clause
#include "state/walls.hpp"

namespace spall {

Face face_of(const Walls& walls, std::size_t wall, const Vec3& x) {
  if (wall < walls.planes.size()) {
    const Plane& plane = walls.planes[wall];
    return {plane.normal, plane.normal.dot(x - plane.point)};
  }
  const Cylinder& cylinder = walls.cylinders[wall - walls.planes.size()];
  const Vec3 along = x - cylinder.point;
  const Vec3 out = along - along.dot(cylinder.axis) * cylinder.axis;
  const double distance = out.norm();
  return {distance > 0 ? Vec3(-out / distance) : Vec3::Zero(), cylinder.radius - distance};
}

}  // namespace spall
