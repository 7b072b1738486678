// A contact problem from a file, solved by any of Spall's methods.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "spall/comm.hpp"

namespace spall {

struct SolverSettings;  // solver/settings.hpp

/// Prints, on rank 0, what the method reached, or with `only_evaluate` how good the file's own
/// solution is. Collective.
void solve_file(const Comm& comm, const std::string& file, const SolverSettings& settings,
                bool only_evaluate);

}  // namespace spall
