// Ranks in blocks of blocks: whoever talks to a few blocks of each size has heard of all ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

/// Consecutive ranks. A block of several falls into nearly equal parts, down to single ranks.
struct RankBlock {
  int first = 0, count = 1;

  static constexpr int most_parts = 8;

  bool has(int rank) const { return rank >= first && rank < first + count; }
  int parts() const { return std::min(count, most_parts); }
  RankBlock part(int k) const {
    const auto begin = static_cast<int>(part_begin(count, k, parts()));
    return {first + begin, static_cast<int>(part_begin(count, k + 1, parts())) - begin};
  }
  /// The rank of it that `other`, anywhere, turns to: so all of them are asked by about as many.
  int partner_of(int other) const { return first + other % count; }
};

/// The blocks that `rank` of so many is in, each a part of the one before.
inline std::vector<RankBlock> blocks_of(int rank, int ranks) {
  std::vector<RankBlock> blocks{{0, ranks}};
  while (blocks.back().count > 1)
    for (int k = 0; k < blocks.back().parts(); ++k)
      if (const RankBlock part = blocks.back().part(k); part.has(rank)) {
        blocks.push_back(part);
        break;
      }
  return blocks;
}

/// How often the largest block can be divided.
inline int block_levels(int ranks) {
  int levels = 0;
  for (; ranks > 1; ranks = (ranks + RankBlock::most_parts - 1) / RankBlock::most_parts) ++levels;
  return levels;
}

}  // namespace spall
