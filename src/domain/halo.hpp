// Finds which bodies are needed as ghosts where, and fetches them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "domain/ghosts.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/period.hpp"

namespace spall {

/// Appends as ghosts all bodies of other ranks that may meet one of this rank's. Two bodies may
/// meet where their spheres do, each grown by its own `reach` (m, one for each owned body). Sizes
/// do not matter: a nucleus larger than a subdomain becomes a ghost wherever it reaches. `reach` is
/// grown by the ghosts' rows.
///
/// Where space repeats itself, images of bodies, this rank's own too, are ghosts at their places.
/// `shifts` (m, one for each ghost) must be added to their positions after each update.
///
/// Returns the plan that keeps ghosts current. Collective.
Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach, const Period& period,
                 std::vector<Vec3>& shifts);
inline Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach) {
  std::vector<Vec3> none;
  return make_halo(comm, bodies, reach, {}, none);
}

/// Brings the fields of ghosts that are `refreshed` up to date. Collective.
void refresh_ghosts(const Ghosts& ghosts, Bodies& bodies);

}  // namespace spall
