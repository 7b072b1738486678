// What all searches for pairs do besides finding them: ghosts, and what a period allows.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/search.hpp"

#include <algorithm>

#include "spall/error.hpp"

namespace spall {

void find_ghosts(const Comm& comm, Bodies& bodies, const Period& period, std::vector<double>& reach,
                 Search& search) {
  if (period.any())
    for (Index b = 0; b < bodies.owned; ++b)
      bodies.position[b] = period.wrapped(bodies.position[b]);
  search.found_at.assign(bodies.position.begin(), bodies.position.begin() + bodies.owned);
  search.ghosts = make_halo(comm, bodies, reach, period, search.shifts);
}

void check_period(const Period& period, double reach, const std::string& place) {
  for (int k = 0; k < 3; ++k)
    require(period.size[k] == 0 || period.size[k] > 2 * reach,
            "{}: periodic.size: {:g} m in direction {} is less than twice {:.4g} m, the reach of a "
            "body: it would meet two images of another",
            place, period.size[k], "xyz"[k], reach);
}

double skin_within(const Period& period, double reach, double skin) {
  check_period(period, reach, "search for pairs");
  for (double size : period.size)
    if (size > 0) skin = std::min(skin, size / 2 - reach);
  return skin;
}

void tell_ghosts(const Bodies& bodies, const Ghosts& ghosts, std::vector<int>& owner) {
  const bool other = ghosts.owned() != bodies.owned || ghosts.ghosts() != bodies.ghosts();
  if (ghosts.comm().any(other)) return;
  std::vector<double> numbers(owner.begin(), owner.end());
  numbers.resize(bodies.size());
  ghosts.gather(numbers.data(), 1);
  owner.assign(numbers.begin(), numbers.end());
}

}  // namespace spall
