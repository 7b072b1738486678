// What rank 0 does for all of them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <exception>
#include <limits>
#include <string>
#include <utility>

#include "spall/comm.hpp"
#include "spall/error.hpp"

namespace spall {

/// Rank 0's text, on every rank. Collective.
inline std::string text_of_first_rank(const Comm& comm, std::string text) {
  require(text.size() <= std::numeric_limits<int>::max(), "a text of {} bytes is not sent",
          text.size());
  auto length = static_cast<int>(text.size());
  check_mpi(MPI_Bcast(&length, 1, MPI_INT, 0, comm.raw), "MPI_Bcast");
  text.resize(length);
  check_mpi(MPI_Bcast(text.data(), length, MPI_CHAR, 0, comm.raw), "MPI_Bcast");
  return text;
}

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
  if (comm.any(failed)) throw Error(text_of_first_rank(comm, reason));
}

}  // namespace spall
