// A cut for many ranks: space is halved again and again, and so are the ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// The rank that should own each owned body, by recursive coordinate bisection (Berger & Bokhari
/// 1987): the ranks are halved, and space across its longest direction, so that work is shared as
/// ranks are. No rank holds more than its share of the bodies' places meanwhile; the number of
/// steps is logarithmic in the number of ranks. Planes move little from one cut to the next, so
/// most bodies stay. Collective.
std::vector<int> bisect(const Comm& comm, const Bodies& bodies, std::span<const double> work);

/// The rank that each owned body would have on as many as `parts` ranks, by the same planes; nobody
/// sends anything. The number of steps grows with the parts. Collective.
std::vector<int> bisect(const Comm& comm, const Bodies& bodies, std::span<const double> work,
                        int parts);

}  // namespace spall
