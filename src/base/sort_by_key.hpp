// Rows in the order of their keys, such as those of cells along a space-filling curve.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "spall/types.hpp"

namespace spall {

struct KeyedRow {
  std::uint64_t key;
  Index row;
};

/// Stable: equal keys keep their order.
void sort_by_key(std::vector<KeyedRow>& rows);

}  // namespace spall
