// Several questions to all ranks at once: each call waits for the slowest.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

/// Sums and maxima over all ranks, in place, by one call. Collective.
void reduce(const Comm& comm, std::span<double> sums, std::span<double> largest);

/// As `Comm::all_gather`; `first` is where this rank's own begin. Collective.
std::vector<double> all_gather(const Comm& comm, std::span<const double> values,
                               std::size_t& first);

}  // namespace spall
