// The ranks of a run: a communicator with the reductions that the stages need.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mpi.h>

#include <map>
#include <span>
#include <string>
#include <vector>

#include "spall/types.hpp"

namespace spall {

/// Numbers for or from ranks; a rank that is not named gets or sent none.
template <class T>
using ByRank = std::map<int, std::vector<T>>;

/// A handle, passed by value; the communicator belongs to whoever made it. All calls are
/// collective.
struct Comm {
  MPI_Comm raw = MPI_COMM_NULL;
  int rank = 0;
  int size = 1;

  Comm() = default;
  explicit Comm(MPI_Comm communicator);

  double sum(double value) const;
  std::int64_t sum(std::int64_t value) const;
  Vec3 sum(const Vec3& value) const;
  void sum(std::span<double> values) const;  ///< in place
  double max(double value) const;
  void max(std::span<double> values) const;  ///< in place
  double min(double value) const;
  bool any(bool value) const;
  void any(std::span<std::uint64_t> bits) const;      ///< in place, bit by bit
  std::int64_t sum_before(std::int64_t value) const;  ///< over lower ranks; 0 on rank 0

  void broadcast(std::span<double> values, int root) const;
  /// Every rank's values, one rank after another, on every rank.
  std::vector<double> all_gather(std::span<const double> values) const;
  std::vector<std::int64_t> all_gather(std::span<const std::int64_t> values) const;
  /// Sends each rank what is named for it; returns what came, in the order of the ranks. Messages
  /// go between these ranks alone; who sends is found in a logarithmic number of steps.
  ByRank<double> exchange(ByRank<double> outgoing) const;
  ByRank<std::int64_t> exchange(ByRank<std::int64_t> outgoing) const;
};

/// The first of `total` rows that part `part` of `parts` nearly equal ones holds.
constexpr std::int64_t part_begin(std::int64_t total, int part, int parts) {
  return total / parts * part + total % parts * part / parts;
}

/// MPI and PETSc, started and ended. Lives outside the `try` of `main`: an exception on one rank
/// must reach `abort_all` before any rank waits in MPI_Finalize.
class Session {
 public:
  /// PETSc reads its options from PETSC_OPTIONS alone: command lines are the program's. Throws
  /// Error on every rank alike where SPALL_INSTRUCTIONS is none.
  Session();
  ~Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  Comm world() const;
  /// Says `message` on standard error and ends all ranks with exit code 2, without a destructor on
  /// the way. Where ranks fail together one speaks: rank 0, or else one that knows the cause.
  [[noreturn]] static void abort_all(const std::string& message, bool knows_cause = true);
};

}  // namespace spall
