// Counts are reduced over all ranks, so that all divide alike.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/curve.hpp"

#include <numeric>

namespace spall {

namespace {

/// Halves stretch `s`, of whose equal parts `bodies` are known, as far as these go; adds those that
/// are left to `undivided`.
void halve(std::vector<Stretch>& all, Index s, std::span<const double> bodies, double grain,
           std::vector<Index>& undivided) {
  if (all[s].bodies <= grain || all[s].bit < 0) return;
  if (bodies.size() == 1) return undivided.push_back(s);
  const std::size_t half = bodies.size() / 2;
  const std::array parts{bodies.first(half), bodies.last(half)};
  const double lower = std::accumulate(parts[0].begin(), parts[0].end(), 0.0);
  const std::array halves{
      Stretch{all[s].low, all[s].middle(), all[s].bit - 1, lower},
      Stretch{all[s].middle(), all[s].high, all[s].bit - 1, all[s].bodies - lower}};
  for (int k = 0; k < 2; ++k)
    if (halves[1 - k].bodies == 0) {
      all[s] = halves[k];
      return halve(all, s, parts[k], grain, undivided);
    }
  const auto first = static_cast<Index>(all.size());
  all[s].children = {first, first + 1};
  all.insert(all.end(), halves.begin(), halves.end());
  for (int k = 0; k < 2; ++k) halve(all, first + k, parts[k], grain, undivided);
}

}  // namespace

std::vector<Stretch> divide_curve(const Comm& comm, std::span<const KeyedRow> rows, double bodies,
                                  int leaf_size) {
  constexpr int generations = 3;  // by one reduction
  constexpr double stretches = 512;
  const double grain = std::max<double>(bodies / stretches, leaf_size);
  std::vector<Stretch> all(1);
  all[0].bodies = bodies;
  std::vector<Index> undivided;
  for (halve(all, 0, std::span(&bodies, 1), grain, undivided); !undivided.empty();) {
    std::vector<double> counts;
    const auto parts_of = [&](Index s) {
      return std::size_t{1} << std::min(generations, all[s].bit + 1);
    };
    for (Index s : undivided) {
      const std::size_t parts = parts_of(s);
      const std::uint64_t width = (std::uint64_t{2} << all[s].bit) / parts;
      std::size_t before = first_at(rows, all[s].low);
      for (std::size_t k = 1; k <= parts; ++k) {
        const std::size_t after = first_at(rows, all[s].low + k * width);
        counts.push_back(static_cast<double>(after - before));
        before = after;
      }
    }
    comm.sum(counts);
    std::vector<Index> next;
    for (std::size_t at = 0; Index s : undivided) {
      const std::size_t parts = parts_of(s);  // before it is divided
      halve(all, s, std::span(counts).subspan(at, parts), grain, next);
      at += parts;
    }
    undivided = std::move(next);
  }
  return all;
}

}  // namespace spall
