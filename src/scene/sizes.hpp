// Radii of unequal spheres: power laws, lognormal ones, lists.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "keys/section.hpp"

namespace spall {

enum class SizeLaw { power, lognormal, list };

/// How radii are distributed, by number of spheres.
struct Sizes {
  SizeLaw law = SizeLaw::power;
  double smallest = 0, largest = 0;  ///< m; there are none beyond
  double exponent = 0;               ///< of power: N(>r) ~ r^-exponent between the limits
  double median = 0;                 ///< m, of lognormal without limits
  double spread = 0;                 ///< of lognormal: standard deviation of ln r
  std::vector<double> radii = {};    ///< m, of list
  std::vector<double> shares = {};   ///< of list: of the number of spheres; they add up to 1
};

/// Reads the table `sizes` of a packing of `count` spheres.
void read_sizes(Section& in, Sizes& sizes, std::int64_t count);

/// m, `count` radii, the largest first; the same on every machine. Those of a list are as many as
/// their shares say, rounded; others are drawn independently.
std::vector<double> draw_radii(const Sizes& sizes, std::int64_t count, std::uint64_t seed);

}  // namespace spall
