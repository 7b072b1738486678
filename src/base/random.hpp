// Random numbers that are the same on every machine, which the standard's distributions are not.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <random>

#include "spall/types.hpp"

namespace spall {

/// In [0, 1).
inline double uniform(std::mt19937_64& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

/// Of mean 0 and variance 1 (Box & Muller 1958).
inline double normal(std::mt19937_64& engine) {
  const double distance = std::sqrt(-2 * std::log(1 - uniform(engine)));
  return distance * std::cos(2 * pi * uniform(engine));
}

}  // namespace spall
