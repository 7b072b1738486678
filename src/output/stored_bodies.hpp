// Bodies of an earlier run, for cases that start from them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene/case.hpp"

namespace spall {

/// The case with what its groups of packing "file" take from restart files, in order of id:
/// positions from the centre of mass of what moves, velocities as they are, radii and masses.
/// Throws Error with the group's place.
Case with_stored_bodies(Case scene, const InputFiles& files = {});

}  // namespace spall
