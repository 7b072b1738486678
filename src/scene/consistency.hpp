// What a whole case asks for: parts that contradict each other, or that nothing models.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene/case.hpp"

namespace spall {

/// Throws Error, with file, line and key, where keys that are right by themselves do not go
/// together.
void check_consistency(const Case& scene);

/// Where a phase's method leaves behind what held bodies together in the one before, in words.
std::vector<std::string> lost_bonds(const Case& scene);

}  // namespace spall
