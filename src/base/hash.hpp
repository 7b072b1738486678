// The one mixer of bits: of hash tables, checksums and streams of random numbers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace spall {

/// Scatters numbers over all 64 bits: the finaliser of splitmix64.
inline std::uint64_t mix(std::uint64_t x) {
  x ^= x >> 30;
  x *= 0xbf58476d1ce4e5b9;
  x ^= x >> 27;
  x *= 0x94d049bb133111eb;
  return x ^ x >> 31;
}

}  // namespace spall
