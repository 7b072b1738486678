// A run: the phases of a case, from bodies to results.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "output/restart.hpp"
#include "output/run_folder.hpp"
#include "scene/case.hpp"
#include "spall/comm.hpp"

namespace spall {

/// What `check_case` foretells; time costs a sample of steps.
enum class Foretold { memory, time_too };

/// What a case makes and runs, in words and tables. Throws Error where a run of it would, by the
/// beginning of that run itself: its bodies are made, and the first phase begins. Collective.
std::string check_case(const Comm& comm, const Case& scene, Foretold foretold = Foretold::memory);

/// What a restart file holds, in a line, after all of it was read; throws Error where it is not
/// whole. Collective.
std::string check_restart(const Comm& comm, const std::string& file);

/// Runs a case from its start and writes snapshots, series, restarts and results into `folder`,
/// which is made where it is missing; one with a former run is refused unless that is to be
/// overwritten. Returns false where a signal ended the run early, after its restart file was
/// written. Collective.
bool run_case(const Comm& comm, const Case& scene, const std::string& folder,
              Former former = Former::refuse);

/// The case of a restart file, with the changes that it was run with and others, for which the
/// state is made ready. Throws Error where one of those changes nothing any more, or cannot be.
/// Collective.
Case case_to_go_on(const Comm& comm, RestartState& state, const std::vector<std::string>& overrides,
                   const InputFiles& files);

/// What `resume_case` may be told.
struct ResumeOptions {
  std::string folder;                  ///< for results; empty: that of the restart file
  Former former = Former::refuse;      ///< what another folder may hold
  std::vector<std::string> overrides;  ///< may change what lies ahead
  bool stored_case = false;            ///< go on with it, whatever the case's file says by now
};

/// Goes on with the run whose restart file is `file`; in another folder the series begins with the
/// resumed step, so that many impacts can start from one aggregate. Throws Error where the file of
/// the case has changed since, unless told. Collective.
bool resume_case(const Comm& comm, const std::string& file, const ResumeOptions& options = {});

}  // namespace spall
