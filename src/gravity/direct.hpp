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

/// The field of all bodies at places of this rank where there may be none: each place with each
/// body. What lies at a place itself does not act there. Each rank holds every body meanwhile (32
/// bytes a body), and its own places alone. Without rates. Collective.
GravityField evaluate_gravity_direct_at(const Comm& comm, double constant,
                                        std::span<const double> mass,
                                        std::span<const Vec3> position,
                                        std::span<const Vec3> places);

}  // namespace spall
