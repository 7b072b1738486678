// Which commit a build is of.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// As bench/commit.sh tells it, such as "f20451a" or "f20451a-dirty"; "unknown" of a tree without
/// git.
const char* commit_of_build();

}  // namespace spall
