// Least significant digits first, only those in which keys differ.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/sort_by_key.hpp"

#include <array>
#include <numeric>

namespace spall {

KeyOrder sort_by_key(KeyOrder order) {
  constexpr int digit = 11;
  const std::size_t n = order.key.size();
  std::uint64_t differ = 0;
  for (std::uint64_t key : order.key) differ |= key ^ order.key.front();
  KeyOrder sorted{std::vector<std::uint64_t>(n), std::vector<Index>(n)};
  const auto value = [](std::uint64_t key, int shift) { return key >> shift & ((1 << digit) - 1); };
  for (int shift = 0; shift < 64; shift += digit) {
    if (value(differ, shift) == 0) continue;
    std::array<std::size_t, (1 << digit) + 1> start{};
    for (std::uint64_t key : order.key) ++start[value(key, shift) + 1];
    std::partial_sum(start.begin(), start.end(), start.begin());
    for (std::size_t k = 0; k < n; ++k) {
      const std::size_t at = start[value(order.key[k], shift)]++;
      sorted.key[at] = order.key[k];
      sorted.row[at] = order.row[k];
    }
    std::swap(order, sorted);
  }
  return order;
}

}  // namespace spall
