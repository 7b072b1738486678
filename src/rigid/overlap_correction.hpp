// Moves bodies by their velocities, and out of each other.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "domain/ghosts.hpp"
#include "pairs/broad_phase.hpp"
#include "rigid/contacts.hpp"
#include "state/world.hpp"

namespace spall {

struct DriftReport {
  double overlap = 0;  ///< largest overlap to come, over the smaller radius, on this rank
  int products = 0;    ///< of the problem that took overlaps apart
};

/// Moves all rows by h (s) of their velocities and takes apart what would overlap at the end, by
/// displacements that never become velocities. Momentum is kept; the energy of keeping angular
/// momentum is booked, and of bonds that `pairs` open and close. Collective.
DriftReport drift_apart(World& world, const Ghosts& ghosts, const Pairs& pairs,
                        const Contacts& contacts, double h);

}  // namespace spall
