// Random velocities of a group, as molecules of a gas have them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "spall/comm.hpp"
#include "spall/types.hpp"

namespace spall {

/// m/s, of those bodies of a group that this rank has: their masses (kg; those of infinite mass
/// rest), and their numbers in the group. Components are normal, those of all bodies alike
/// (Maxwell). The momentum of all is zero, and the rms of a component over the bodies that move is
/// `rms`, both to round-off. A body has the same on any machine and any ranks, to round-off of
/// these sums. Needs two that move. Collective.
std::vector<Vec3> thermal_velocities(const Comm& comm, std::span<const double> mass,
                                     std::span<const BodyId> number, double rms,
                                     std::uint64_t seed);

}  // namespace spall
