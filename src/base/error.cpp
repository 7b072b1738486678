// Turns library return codes into errors with words.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/error.hpp"

#include <mpi.h>
#include <petscsys.h>

namespace spall {

void check_mpi(int code, const char* call) {
  if (code == MPI_SUCCESS) return;
  char text[MPI_MAX_ERROR_STRING];
  int length = 0;
  MPI_Error_string(code, text, &length);
  throw Error(fmt::format("{} failed: {}", call, text));
}

void check_petsc(int code, const char* call) {
  if (code == 0) return;
  const char* text = nullptr;
  PetscErrorMessage(static_cast<PetscErrorCode>(code), &text, nullptr);
  throw Error(fmt::format("{} failed: {}", call, text ? text : "unknown PETSc error"));
}

}  // namespace spall
