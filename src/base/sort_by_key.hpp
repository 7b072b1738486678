// Rows in the order of their keys, such as those of cells along a space-filling curve.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "spall/types.hpp"

namespace spall {

struct KeyOrder {
  std::vector<std::uint64_t> key;  ///< of each row
  std::vector<Index> row;
};

/// The same, sorted. Stable.
KeyOrder sort_by_key(KeyOrder order);

}  // namespace spall
