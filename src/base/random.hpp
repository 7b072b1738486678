// Random numbers that are the same on every machine, which the standard's distributions are not.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "base/hash.hpp"
#include "spall/types.hpp"

namespace spall {

/// Numbers of which each costs the same from the first on: for a stream of each body's own
/// (splitmix64; Steele, Lea & Flood 2014).
class CounterEngine {
 public:
  explicit CounterEngine(std::uint64_t seed) : state_(seed) {}
  std::uint64_t operator()() { return mix(state_ += 0x9e3779b97f4a7c15); }

 private:
  std::uint64_t state_;
};

/// In [0, 1).
template <class Engine>
double uniform(Engine& engine) {
  return static_cast<double>(engine() >> 11) * 0x1p-53;
}

/// Of mean 0 and variance 1 (Box & Muller 1958).
template <class Engine>
double normal(Engine& engine) {
  const double distance = std::sqrt(-2 * std::log(1 - uniform(engine)));
  return distance * std::cos(2 * pi * uniform(engine));
}

}  // namespace spall
