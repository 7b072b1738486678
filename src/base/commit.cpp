// A file of its own: it is built anew with each commit.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/commit.hpp"

#include <spall_commit.hpp>  // by cmake/commit.cmake

namespace spall {

const char* commit_of_build() {
  return SPALL_COMMIT;
}

}  // namespace spall
