// A search for pairs, the same for all engines: cut, migrate, fetch ghosts, find, recall.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/let_go.hpp"
#include "domain/ghosts.hpp"
#include "domain/halo.hpp"
#include "domain/migration.hpp"
#include "domain/partition.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/period.hpp"

namespace spall {

/// What a search leaves to the steps that follow and to the next search.
struct Search {
  Ghosts ghosts;
  std::vector<Vec3> shifts;    ///< m, of ghosts that are images
  std::vector<Vec3> found_at;  ///< m, owned rows: where bodies were when pairs were found
  Cut cut = Cut::bisection;
  LastCut last_cut;
  std::int64_t searches = 0;
};

/// Ghosts and places of bodies as they are now, wrapped into the period; `reach` (m, one an owned
/// body) grows by the ghosts' rows. Collective.
void find_ghosts(const Comm& comm, Bodies& bodies, const Period& period, std::vector<double>& reach,
                 Search& search);

/// Throws Error, which begins with `place`, where space repeats itself so soon that bodies which
/// act up to `reach` (m, between centres) act on two images of another.
void check_period(const Period& period, double reach, const std::string& place);

/// m: the skin, or less where space repeats itself so soon that bodies which act up to `reach` (m,
/// between centres) would be listed with two images of another. Throws Error where they act on two.
double skin_within(const Period& period, double reach, double skin);

/// Adds what becomes of ghosts, where they are still those of the last search, to what becomes of
/// owned bodies. Collective.
void tell_ghosts(const Bodies& bodies, const Ghosts& ghosts, std::vector<int>& owner);

/// Searches pairs anew; cuts the domain before where the ranks' work differs by more than a tenth.
/// What pairs remember goes with them:
///
///   work()         of owned bodies, counted over the pairs as they are
///   keep(cut)      what pairs remember, by ids; each on one rank where the domain is cut
///   find(kept)     ghosts and pairs, and what was kept for them
///
/// There must be a `migrate` for what is kept. Collective.
template <class Work, class Keep, class Find>
void search_anew(const Comm& comm, Bodies& bodies, Search& search, Work&& work, Keep&& keep,
                 Find&& find) {
  std::vector<double> load = work();
  const bool cut = needs_cut(comm, load, search.ghosts, search.last_cut);
  let_go(search.found_at);  // what comes needs the memory
  auto kept = keep(cut);
  if (cut) {
    std::vector<int> owner = partition(comm, bodies, load, search.cut);
    let_go(load);
    if (search.searches > 0) tell_ghosts(bodies, search.ghosts, owner);
    migrate(comm, bodies, kept, owner);
  }
  let_go(load);
  find(std::move(kept));
  ++search.searches;
  if (cut) load = work();
  book_search(comm, cut, load, search.ghosts, search.last_cut);
}

}  // namespace spall
