// The keys of a group's motion: velocity, rotation, oscillation, a table in time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// [groups.motion], and that `fixed` and `motion` stand beside no other motion.
void read_motion_of_group(Section& in, Group& group);

/// Puts the groups' motions where a world finds them, and refuses what they cannot go with.
void gather_motions(Case& scene);

}  // namespace spall
