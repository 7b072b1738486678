// By radix: least significant digits first, only those in which keys differ.
// SPDX-License-Identifier: BSD-3-Clause
#include "base/sort_by_key.hpp"

#include <array>
#include <numeric>

namespace spall {

void sort_by_key(std::vector<KeyedRow>& rows) {
  constexpr int digit_bits = 11;
  constexpr std::uint64_t mask = (1 << digit_bits) - 1;
  std::uint64_t differ = 0;
  for (const KeyedRow& r : rows) differ |= r.key ^ rows.front().key;
  std::vector<KeyedRow> other(rows.size());
  for (int shift = 0; shift < 64; shift += digit_bits) {
    if ((differ >> shift & mask) == 0) continue;
    std::array<std::size_t, mask + 1> start{};
    for (const KeyedRow& r : rows) ++start[r.key >> shift & mask];
    std::exclusive_scan(start.begin(), start.end(), start.begin(), std::size_t{0});
    for (const KeyedRow& r : rows) other[start[r.key >> shift & mask]++] = r;
    rows.swap(other);
  }
}

}  // namespace spall
