// Counts are reduced over all ranks, so that all cut alike.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/curve.hpp"

#include <numeric>

namespace spall {

void radix_sort(std::vector<KeyedRow>& rows) {
  constexpr int digit_bits = 11;
  constexpr std::uint64_t mask = (1 << digit_bits) - 1;
  std::vector<KeyedRow> other(rows.size());
  for (int shift = 0; shift < key_bits; shift += digit_bits) {
    std::array<std::size_t, mask + 1> start{};
    for (const KeyedRow& r : rows) ++start[r.key >> shift & mask];
    if (std::ranges::max(start) == rows.size()) continue;
    std::exclusive_scan(start.begin(), start.end(), start.begin(), std::size_t{0});
    for (const KeyedRow& r : rows) other[start[r.key >> shift & mask]++] = r;
    rows.swap(other);
  }
}

std::vector<Stretch> divide_curve(const Comm& comm, std::span<const KeyedRow> rows, double bodies,
                                  double grain) {
  std::vector<Stretch> all(1);
  all[0].bodies = bodies;
  for (std::vector<Index> large{0}; !large.empty();) {
    std::erase_if(large, [&](Index s) { return all[s].bodies <= grain || all[s].bit < 0; });
    std::vector<double> lower(large.size());
    for (std::size_t k = 0; k < large.size(); ++k)
      lower[k] = static_cast<double>(first_at(rows, all[large[k]].middle()) -
                                     first_at(rows, all[large[k]].low));
    comm.sum(lower);
    std::vector<Index> next;
    for (std::size_t k = 0; k < large.size(); ++k) {
      Stretch& s = all[large[k]];
      Stretch low{s.low, s.middle(), s.bit - 1, lower[k]};
      Stretch high{s.middle(), s.high, s.bit - 1, s.bodies - lower[k]};
      if (low.bodies == 0 || high.bodies == 0) {
        s = low.bodies == 0 ? high : low;
        next.push_back(large[k]);
        continue;
      }
      const auto at = static_cast<Index>(all.size());
      s.children = {at, at + 1};
      next.insert(next.end(), {at, at + 1});
      all.push_back(low);
      all.push_back(high);
    }
    large = std::move(next);
  }
  return all;
}

std::vector<int> deal_out(const Comm& comm, std::span<const Stretch> all) {
  std::vector<int> owner(all.size(), -1);
  double before = 0;
  const auto deal = [&](auto&& self, Index s) -> void {
    if (all[s].children[0] == Cell::none) {
      owner[s] = static_cast<int>((before + all[s].bodies / 2) / all[0].bodies * comm.size);
      before += all[s].bodies;
    } else {
      for (Index child : all[s].children) self(self, child);
    }
  };
  deal(deal, 0);
  return owner;
}

}  // namespace spall
