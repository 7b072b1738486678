// Where functions of some bodies are zero.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "solid/rows.hpp"

namespace spall {

inline PairLanes magnitude_of(const PairLanes& v) {
  return larger(v, -v);
}

/// Where `over(at)`, negative at `low` and positive at `high`, is at most `error`, in the lanes
/// that are asked for; others stay where they are. Newton's steps by its `slope(at)`, or a half of
/// the bracket where they leave it or shrink too slowly.
template <class F, class G>
PairLanes root_within(const PairMask& asked, PairLanes low, PairLanes high, PairLanes at,
                      const PairLanes& error, F&& over, G&& slope) {
  PairLanes last = high - low;
  for (int iteration = 0; iteration < 100; ++iteration) {
    const PairLanes value = over(at);
    const PairMask off = asked & (magnitude_of(value) > error);
    if (!any_lane(off)) break;
    low = select(value < 0.0, at, low);
    high = select(value < 0.0, high, at);
    const PairLanes next = at - value / slope(at), half = 0.5 * (low + high);
    const PairMask good = (next > low) & (next < high) & (magnitude_of(next - at) <= 0.5 * last);
    const PairLanes from = std::exchange(at, select(off, select(good, next, half), at));
    last = magnitude_of(at - from);
  }
  return at;
}

}  // namespace spall
