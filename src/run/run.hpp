// A run: the phases of a case, from bodies to results.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "output/restart.hpp"
#include "scene/case.hpp"
#include "spall/comm.hpp"

namespace spall {

/// What `check_case` foretells; time costs a sample of steps.
enum class Foretold { memory, time_too };

/// What a case makes and runs, in words and tables. Throws Error where a run of it would, by the
/// beginning of that run itself: its bodies are made, and the first phase begins. Collective.
std::string check_case(const Comm& comm, const Case& scene, Foretold foretold = Foretold::memory);

/// Runs a case from its start and writes snapshots, series, restarts and results into `folder`,
/// which is made where it is missing. Returns false where a signal ended the run early, after its
/// restart file was written. Collective.
bool run_case(const Comm& comm, const Case& scene, const std::string& folder);

/// Goes on with the run whose restart file is `file`, in the folder of that file unless another is
/// named; there the series begins with the resumed step. `overrides` may change what lies ahead:
/// many impacts can start from one aggregate. Collective.
bool resume_case(const Comm& comm, const std::string& file, const std::string& folder = "",
                 const std::vector<std::string>& overrides = {});

}  // namespace spall
