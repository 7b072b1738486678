// Finds which bodies are needed as ghosts where, and fetches them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "base/traffic.hpp"
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

/// What a halo is to one of many ranks.
struct HaloShare {
  std::int64_t ghosts = 0;   ///< rows
  std::int64_t sources = 0;  ///< other ranks that they come from
  std::int64_t copies = 0;   ///< rows of others that are copies of own bodies
  std::int64_t holders = 0;  ///< other ranks that have some
  Traffic search;            ///< messages and bytes of making it
};

/// What `make_halo` would give the ranks `sample` if body b were owned by rank `owner[b]` of
/// `ranks`: all bodies are here, those of a rank in the order in which it would have them.
std::vector<HaloShare> foretell_halo(const Bodies& bodies, std::span<const double> reach,
                                     std::span<const int> owner, int ranks, const Period& period,
                                     std::span<const int> sample);

/// Brings the fields of ghosts that are `refreshed` up to date. Collective.
void refresh_ghosts(const Ghosts& ghosts, Bodies& bodies);

}  // namespace spall
