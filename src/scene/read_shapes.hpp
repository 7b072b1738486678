// What a case says of the shapes of bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// [shapes.NAME]: a list of spheres, or how an ellipsoid is filled with them.
void read_shape(Section& in, ListedShape& shape);

/// Gives the case the shapes that its groups name, and the groups their numbers. A shape of one
/// sphere is the sphere. Throws Error on names that are not there, and on what shapes are not
/// modelled with.
void gather_shapes(Case& scene);

}  // namespace spall
