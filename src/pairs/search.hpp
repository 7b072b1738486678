// A search for pairs, the same for all engines: cut, migrate, fetch ghosts, find, recall.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "base/let_go.hpp"
#include "domain/ghosts.hpp"
#include "domain/halo.hpp"
#include "domain/migration.hpp"
#include "domain/partition.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "spall/error.hpp"
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
inline void find_ghosts(const Comm& comm, Bodies& bodies, const Period& period,
                        std::vector<double>& reach, Search& search) {
  if (period.any())
    for (Index b = 0; b < bodies.owned; ++b)
      bodies.position[b] = period.wrapped(bodies.position[b]);
  search.found_at.assign(bodies.position.begin(), bodies.position.begin() + bodies.owned);
  search.ghosts = make_halo(comm, bodies, reach, period, search.shifts);
}

/// Throws Error, which begins with `place`, where space repeats itself so soon that bodies which
/// act up to `reach` (m, between centres) act on two images of another.
inline void check_period(const Period& period, double reach, const std::string& place) {
  for (int k = 0; k < 3; ++k)
    require(period.size[k] == 0 || period.size[k] > 2 * reach,
            "{}: periodic.size: {:g} m in direction {} is less than twice {:.4g} m, the reach of a "
            "body: it would meet two images of another",
            place, period.size[k], "xyz"[k], reach);
}

/// m: the skin, or less where space repeats itself so soon that bodies which act up to `reach` (m,
/// between centres) would be listed with two images of another. Throws Error where they act on two.
inline double skin_within(const Period& period, double reach, double skin) {
  check_period(period, reach, "search for pairs");
  for (double size : period.size)
    if (size > 0) skin = std::min(skin, size / 2 - reach);
  return skin;
}

/// Adds what becomes of ghosts, where they are still those of the last search, to what becomes of
/// owned bodies. Collective.
inline void tell_ghosts(const Bodies& bodies, const Ghosts& ghosts, std::vector<int>& owner) {
  const bool other = ghosts.owned() != bodies.owned || ghosts.ghosts() != bodies.ghosts();
  if (ghosts.comm().any(other)) return;
  std::vector<double> numbers(owner.begin(), owner.end());
  numbers.resize(bodies.size());
  ghosts.gather(numbers.data(), 1);
  owner.assign(numbers.begin(), numbers.end());
}

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
