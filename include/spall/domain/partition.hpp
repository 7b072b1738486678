// Who should own which body: coarse cells of space, cut by METIS into parts of equal work.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "spall/base/comm.hpp"
#include "spall/scene/bodies.hpp"

namespace spall {

/// The rank that should own each owned body. `work` is any measure of a body's cost; it decides the
/// result, so it must be counted, not timed: the same run then gives the same bits again. Parts
/// keep the ranks that already own most of them. Collective.
std::vector<int> partition(const Comm& comm, const Bodies& bodies, std::span<const double> work);

/// Largest over mean work of the ranks; 1 where there is none. Collective.
double imbalance(const Comm& comm, double work);

}  // namespace spall
