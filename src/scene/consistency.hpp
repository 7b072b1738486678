// What a whole case asks for: parts that contradict each other, or that nothing models.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "scene/case.hpp"

namespace spall {

/// A row of the series costs as much as most of a step of smooth forces: without being told, one in
/// so many steps.
inline constexpr int steps_a_row = 100;

/// Throws Error, with file, line and key, where keys that are right by themselves do not go
/// together.
void check_consistency(const Case& scene, Groups groups);

/// The same of bodies of files, once they are read: a file brings places and motions, and what was
/// broken would be bonded anew, and whole.
void check_stored_damage(const Case& scene);

/// s, of phases one after another.
double duration_of(std::span<const Phase> phases);

/// What takes a part of an impact's recoil, which is that of a free target: "a wall"; "" without.
std::string taker_of_recoil(const Case& scene);

/// What a reader of read-outs must know of the scene, or nothing.
std::string warning_of_read_outs(const Case& scene);

/// What is modelled, and may not be what it looks like, in words: read-outs of a target that is not
/// free; an impactor that never arrives; a phase whose method leaves behind what held bodies
/// together in the one before, or takes them to be whole.
std::vector<std::string> warnings_of(const Case& scene);

}  // namespace spall
