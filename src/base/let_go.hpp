// Memory that what comes needs more.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// Frees what the containers hold. `vector = {}` would empty one and keep its memory.
template <class... Containers>
void let_go(Containers&... containers) {
  ((containers = Containers()), ...);
}

}  // namespace spall
