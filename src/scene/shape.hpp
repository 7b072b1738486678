// Volumes: what lies inside them, and how large they are.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene/case.hpp"

namespace spall {

/// How deep `point` lies inside `volume`, m: the distance to its surface, negative outside (there
/// only the sign is meant). A sphere is wholly inside where its centre is a radius deep.
double depth(const Volume& volume, const Vec3& point);

/// Whether it lies inside: its depth's sign, for less.
bool contains(const Volume& volume, const Vec3& point);

double ball_volume(double radius);       ///< m^3, volume of a ball
double volume_of(const Volume& volume);  ///< m^3

/// Half widths of the smallest box about `volume.center` that holds it, along the axes.
Vec3 half_widths(const Volume& volume);

}  // namespace spall
