// Space that repeats itself.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "spall/types.hpp"

namespace spall {

/// Directions in which space repeats itself: bodies lie in [low, low + size). Images are ghosts.
struct Period {
  Vec3 low = Vec3::Zero();   ///< m
  Vec3 size = Vec3::Zero();  ///< m; 0: this direction does not repeat

  bool any() const { return !size.isZero(0); }
  /// The image of `x` that lies inside, which is its own image.
  Vec3 wrapped(Vec3 x) const {
    for (int k = 0; k < 3; ++k) {
      if (size[k] == 0) continue;
      x[k] -= size[k] * std::floor((x[k] - low[k]) / size[k]);
      if (x[k] >= low[k] + size[k]) x[k] = low[k];  // rounded up to the end
    }
    return x;
  }
  /// The image of `x` that is nearest to `other`.
  Vec3 nearest(Vec3 x, const Vec3& other) const {
    for (int k = 0; k < 3; ++k)
      if (size[k] > 0) x[k] += size[k] * std::round((other[k] - x[k]) / size[k]);
    return x;
  }
};

}  // namespace spall
