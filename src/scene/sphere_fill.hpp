// Spheres in a closed surface: how a shape model becomes a rigid clump.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "scene/surface_mesh.hpp"
#include "state/body_shape.hpp"

namespace spall {

/// Up to `count` spheres that lie in `mesh` and hang together, the largest first. Of the others
/// candidates touch the surface at some two thousand points, alike in area, and are as large as
/// they can be there. Each that is chosen brings the union of all most of the way to the surface,
/// on the mean over these points. Fewer where no other would bring it nearer. The same on every
/// machine.
std::vector<ShapeSphere> fill_mesh(const SurfaceMesh& mesh, int count);

}  // namespace spall
