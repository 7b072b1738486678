// Where the time goes: wall seconds a stage, on this rank.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <map>
#include <string>

namespace spall {

using StageTimes = std::map<std::string, double>;

/// Adds the seconds of its own lifetime to a stage.
class StageTimer {
 public:
  StageTimer(StageTimes& times, const char* stage) : seconds_(times[stage]), start_(MPI_Wtime()) {}
  ~StageTimer() { seconds_ += MPI_Wtime() - start_; }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  double& seconds_;
  double start_;
};

}  // namespace spall
