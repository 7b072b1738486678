// Errors that a user can mend: one message with the values and the place in the input.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

namespace spall {

/// Bad input or a failed library call. `main` catches it once, prints `what()` and ends all ranks.
struct Error : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Throws `Error` with the formatted message unless `condition` holds.
template <class... Args>
void require(bool condition, fmt::format_string<Args...> message, Args&&... args) {
  if (!condition) throw Error(fmt::format(message, std::forward<Args>(args)...));
}

/// Throws `Error` naming the call and PETSc's or MPI's message unless `code` is 0.
void check_mpi(int code, const char* call);
void check_petsc(int code, const char* call);

}  // namespace spall
