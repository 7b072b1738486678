// The clock of stages: what one within another takes and sends counts for both.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/timer.hpp"

#include <mpi.h>

#include <utility>

namespace spall {

StageTimer::StageTimer(StageUses& uses, const char* stage)
    : use_(uses[stage]), before_(std::exchange(traffic(), {})), start_(MPI_Wtime()) {}

StageTimer::~StageTimer() {
  use_.seconds += MPI_Wtime() - start_;
  use_.traffic.add(traffic());
  traffic().add(before_);
}

}  // namespace spall
