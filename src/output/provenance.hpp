// Where results come from: told alike in results, snapshots and trajectories.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "scene/case.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Names and values: title, case with its changes, seed, command, version, commit, date, host,
/// ranks.
using Provenance = std::vector<std::pair<std::string, std::variant<std::int64_t, std::string>>>;

/// Of a run that begins or goes on now, the same on all ranks. Nothing is computed from it.
/// Collective.
Provenance provenance_of(const Comm& comm, const Case& scene);

}  // namespace spall
