// Bodies and what their contacts remember move to their new owners.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/base/comm.hpp"
#include "spall/contact/contacts.hpp"
#include "spall/scene/bodies.hpp"

namespace spall {

/// Sends every owned body to rank `owner[b]` and drops all ghosts; on arrival bodies lie along a
/// space-filling curve. `memory` holds each contact once over all ranks (on any rank that owns one
/// of its bodies); afterwards every rank holds those of its bodies. Collective.
void migrate(const Comm& comm, Bodies& bodies, ContactMemory& memory,
             const std::vector<int>& owner);

/// Owned bodies in the order of a space-filling curve; ghosts are dropped.
void sort_bodies(const Comm& comm, Bodies& bodies);

}  // namespace spall
