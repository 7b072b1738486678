// What a case says of walls and of space that repeats itself.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// [[planes]], [[boxes]], [[cylinders]] and [periodic].
void read_walls(Section& in, Case& scene);

/// What columns of forces are called by: names of groups are free, those of columns are not.
std::string column_name(std::string name);

}  // namespace spall
