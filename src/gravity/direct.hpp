// The exact sum of gravity over all pairs of bodies, shared out among the ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "gravity/field.hpp"

namespace spall {

/// The field of all bodies at the owned bodies, each pair evaluated once and applied to both with
/// the same bits. Ranks share the pairs equally, however the bodies are distributed. Each holds
/// every body meanwhile (192 bytes a body). `rates` is the same on all ranks: whether they are
/// wanted, by the velocities. Collective.
GravityField evaluate_gravity_direct(const Comm& comm, double constant,
                                     std::span<const double> mass, std::span<const Vec3> position,
                                     std::span<const Vec3> velocity, bool rates);

}  // namespace spall
