// [debris]: which groups are projectile and plate, and what is measured.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

void read_debris(Section& in, DebrisSettings& debris);

/// Looks the groups up by name and checks that they are such as debris can be measured of.
void find_debris_groups(Case& scene);

}  // namespace spall
