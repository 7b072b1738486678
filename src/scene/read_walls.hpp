// What a case says of walls and of space that repeats itself.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// [[planes]], [[boxes]], [[cylinders]] and [periodic].
void read_walls(Section& in, Case& scene);

}  // namespace spall
