// Morton keys: a space-filling curve on which bodies that are near in space are near in memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "spall/types.hpp"

namespace spall {

/// Spreads the low 21 bits of `x` to every third bit.
inline std::uint64_t spread_bits(std::uint64_t x) {
  x &= 0x1fffff;
  x = (x | x << 32) & 0x1f00000000ffff;
  x = (x | x << 16) & 0x1f0000ff0000ff;
  x = (x | x << 8) & 0x100f00f00f00f00f;
  x = (x | x << 4) & 0x10c30c30c30c30c3;
  x = (x | x << 2) & 0x1249249249249249;
  return x;
}

/// The key of a cell: bits of x first, then of y and z.
inline std::uint64_t interleave(std::uint64_t x, std::uint64_t y, std::uint64_t z) {
  return spread_bits(x) | spread_bits(y) << 1 | spread_bits(z) << 2;
}

/// Key of the cell of width `edge` around the origin that holds `position`; positions beyond 2^20
/// cells share the outermost ones.
inline std::uint64_t morton_key(const Vec3& position, double edge) {
  constexpr double half = 1 << 20;
  const auto cell = [&](int k) {
    return static_cast<std::uint64_t>(
        std::clamp(std::floor(position[k] / edge) + half, 0.0, 2 * half - 1));
  };
  return interleave(cell(0), cell(1), cell(2));
}

/// Keys of the 27 cells around the one with this key, itself among them. Cells beyond the outermost
/// are those at the other end.
inline std::array<std::uint64_t, 27> keys_around(std::uint64_t key) {
  constexpr std::uint64_t along = 0x1249249249249249;  // every third bit
  std::uint64_t part[3][3];
  for (int k = 0; k < 3; ++k) {
    const std::uint64_t mask = along << k, here = key & mask, unit = std::uint64_t{1} << k;
    part[k][0] = (here - unit) & mask;
    part[k][1] = here;
    part[k][2] = ((here | ~mask) + unit) & mask;
  }
  std::array<std::uint64_t, 27> keys;
  for (int n = 0; n < 27; ++n) keys[n] = part[0][n % 3] | part[1][n / 3 % 3] | part[2][n / 9];
  return keys;
}

}  // namespace spall
