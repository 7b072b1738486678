// Entries lie with a body, by the other's id.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/recall.hpp"

#include <algorithm>
#include <numeric>

namespace spall {

Recall::Recall(const Bodies& bodies, const ContactMemory& memory)
    : bodies_(bodies), rows_(bodies), start_(bodies.owned + 2, 0) {
  std::vector<Index> holder(memory.size());
  for (std::size_t m = 0; m < holder.size(); ++m) {
    holder[m] = rows_.find(memory.i[m]);
    if (holder[m] < 0 && memory.j[m] >= 0) holder[m] = rows_.find(memory.j[m]);
    if (holder[m] >= 0) ++start_[holder[m] + 2];
  }
  std::partial_sum(start_.begin(), start_.end(), start_.begin());
  entries_.resize(start_.back());
  for (std::size_t m = 0; m < holder.size(); ++m)
    if (const Index b = holder[m]; b >= 0)
      entries_[start_[b + 1]++] = {bodies.id[b] == memory.i[m] ? memory.j[m] : memory.i[m],
                                   static_cast<Index>(m)};
  for (Index b = 0; b < bodies.owned; ++b)
    std::sort(entries_.begin() + start_[b], entries_.begin() + start_[b + 1],
              [](const Entry& a, const Entry& c) {
                return a.other != c.other ? a.other < c.other : a.at < c.at;
              });
}

std::span<const Recall::Entry> Recall::find(Index row, BodyId other) const {
  const std::span<const Entry> all(entries_.data() + start_[row],
                                   static_cast<std::size_t>(start_[row + 1] - start_[row]));
  const auto found = std::ranges::equal_range(all, other, {}, &Entry::other);
  return {found.begin(), found.end()};
}

}  // namespace spall
