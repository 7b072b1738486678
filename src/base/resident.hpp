// Memory that this process has now.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// Bytes of this process that lie in memory; 0 where the system does not tell.
double resident_bytes();

}  // namespace spall
