// Who should own which body: parts of space with equal work, as compact as they can be.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "domain/ghosts.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/cut.hpp"

namespace spall {

/// The rank that should own each owned body. `work` is any measure of a body's cost, one for each.
/// It must be counted, not timed, since it decides the result: the same run then gives the same
/// bits again. Most of space stays with the rank that owns it already. Collective.
std::vector<int> partition(const Comm& comm, const Bodies& bodies, std::span<const double> work,
                           Cut by = Cut::bisection);

/// The domain is cut anew where the ranks' work is so many times as uneven as after the last cut.
inline constexpr double imbalance_limit = 1.1;

/// Largest over mean work of the ranks; 1 where there is none. Collective.
double imbalance(const Comm& comm, double work);

/// The state just after the last cut, and how old it is.
struct LastCut {
  double imbalance = 0;  ///< 0: never cut
  Index ghosts = 0;
  int searches = 0;  ///< of pairs since then
};

/// Whether the domain should be cut anew: the ranks' work differs by a tenth more than after the
/// last cut, the bodies of two ranks have mixed, or their order in memory is old. Collective.
bool needs_cut(const Comm& comm, std::span<const double> work, const Ghosts& ghosts,
               const LastCut& last);

/// Pairs were found; where the domain was cut before, `work` and `ghosts` are those since.
/// Collective.
void book_search(const Comm& comm, bool cut, std::span<const double> work, const Ghosts& ghosts,
                 LastCut& last);

}  // namespace spall
