// What rank 0 does for all of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <string>
#include <utility>

#include "spall/comm.hpp"
#include "spall/error.hpp"

namespace spall {

/// Calls `f` on rank 0. What it throws is thrown on all ranks, as an Error with the same words: no
/// rank waits for one that has left. Collective.
template <class F>
void on_first_rank(const Comm& comm, F&& f) {
  std::string reason;
  bool failed = false;
  if (comm.rank == 0) {
    try {
      std::forward<F>(f)();
    } catch (const std::exception& error) {
      failed = true;
      reason = error.what();
    }
  }
  if (!comm.any(failed)) return;
  auto length = static_cast<int>(reason.size());
  check_mpi(MPI_Bcast(&length, 1, MPI_INT, 0, comm.raw), "MPI_Bcast");
  reason.resize(length);
  check_mpi(MPI_Bcast(reason.data(), length, MPI_CHAR, 0, comm.raw), "MPI_Bcast");
  throw Error(reason);
}

}  // namespace spall
