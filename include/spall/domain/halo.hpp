// Finds which bodies are needed as ghosts where, and fetches them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "spall/base/comm.hpp"
#include "spall/domain/ghosts.hpp"
#include "spall/scene/bodies.hpp"

namespace spall {

/// Appends as ghosts all bodies of other ranks whose sphere, grown by its own reach, may meet a
/// sphere of this rank, grown by its reach (m, one an owned body; any sizes: a nucleus larger than
/// a subdomain becomes a ghost wherever it reaches). Returns the plan that keeps them current, and
/// grows `reach` by the ghosts' rows. Collective.
Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach);

/// Brings position, velocities and kick of all ghosts up to date. Collective.
void refresh_ghosts(const Ghosts& ghosts, Bodies& bodies);

}  // namespace spall
