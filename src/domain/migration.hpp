// Bodies and what their contacts remember move to their new owners.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/contact_memory.hpp"

namespace spall {

/// Sends every owned body to rank `owner[b]` and drops all ghosts. `owner` may tell of ghosts too:
/// what contacts with them remember finds its way without asking ranks that are far. On arrival
/// bodies lie along a space-filling curve. `memory` must hold each contact on a rank that
/// owns one of its bodies, once over all ranks. Afterwards every rank holds the contacts of its
/// bodies; what came with a restart may be on both ranks of a contact, and then arrives twice
/// alike. Collective.
void migrate(const Comm& comm, Bodies& bodies, SharedContacts& memory,
             const std::vector<int>& owner);

/// Owned bodies in the order of a space-filling curve; ghosts are dropped.
void sort_bodies(const Comm& comm, Bodies& bodies);

}  // namespace spall
