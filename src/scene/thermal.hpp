// Random velocities of a group, as molecules of a gas have them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "spall/types.hpp"

namespace spall {

/// m/s, of bodies of these masses (kg; those of infinite mass rest). Components are normal, those
/// of all bodies alike (Maxwell). The momentum of all is zero, and the rms of a component over the
/// bodies that move is `rms`, both to round-off. Needs two that move. The same on every machine.
std::vector<Vec3> thermal_velocities(std::span<const double> mass, double rms, std::uint64_t seed);

}  // namespace spall
