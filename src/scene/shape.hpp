// Volumes: what lies inside them, and how large they are.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "scene/case.hpp"

namespace spall {

/// How deep `point` lies inside `volume`, m: the distance to its surface, negative outside (there
/// only the sign is meant). A sphere is wholly inside where its centre is a radius deep.
double depth(const Volume& volume, const Vec3& point);

/// Whether it lies inside: its depth's sign, for less.
bool contains(const Volume& volume, const Vec3& point);

double ball_volume(double radius);       ///< m^3, volume of a ball
double volume_of(const Volume& volume);  ///< m^3

/// Half widths of the smallest box about `volume.center` that holds it, along its own axes.
Vec3 half_widths(const Volume& volume);
/// The same along those of the world, of the box that holds that one.
Vec3 half_widths_in_world(const Volume& volume);

/// About the rotation vector `turn`, by its length (rad).
Eigen::AngleAxisd turn_by(const Vec3& turn);

/// Its own axis along which a box is thinnest; of a cylinder that of its height.
int thin_axis(const Volume& volume);
/// Of a velocity along this unit normal; 0 where turning the normal alone has made it so.
double speed_across(const Vec3& velocity, const Vec3& normal);
/// Of a unit vector, for messages: "x", "-z", "[0, 0.6, 0.8]".
std::string words_of_direction(const Vec3& direction);

}  // namespace spall
