// The impactor: aimed at the bodies that are there, and added to them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene/case.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/body_shape.hpp"

namespace spall {

struct Aim {
  Vec3 position, velocity;  ///< of the impactor's centre at the start; m, m/s
  BodyId struck = -1;       ///< the body that it meets first
};

/// The line of flight runs along `direction` through the target's centre of mass (all bodies that
/// can move) plus `offset`. Aimed head-on it is shifted to pass through the centre of the first
/// body that the impactor meets, and again if on the new line that is another one: the last body
/// is met first and head-on. Bodies are taken where they are now; of equals the lower id is met.
/// Of a body with one of the `shapes` its spheres are met, and head-on means that sphere's centre.
/// Throws Error, with the impactor's place in the case, where the line misses all bodies.
/// Collective.
Aim aim_impactor(const Comm& comm, const Impactor& impactor, const Bodies& bodies,
                 const BodyShapes& shapes = {});

/// Whether the line of flight meets any body. Collective.
bool would_hit(const Comm& comm, const Impactor& impactor, const Bodies& bodies,
               const BodyShapes& shapes = {});

/// Adds the impactor, aimed, as an owned row of the rank that owns the struck body; its id is the
/// next, its group the next after the case's. Bodies must hold no ghosts. Collective.
Aim place_impactor(const Comm& comm, const Case& scene, const Impactor& impactor, Bodies& bodies);

/// The same; throws Error where it would begin inside a wall or outside of [periodic]. Collective.
Aim add_impactor(const Comm& comm, const Case& scene, const Impactor& impactor, Bodies& bodies);

}  // namespace spall
