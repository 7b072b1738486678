// Rows of bodies as doubles that carry the bits of every field, for messages.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "spall/scene/bodies.hpp"

namespace spall {

/// Doubles that one value of a field takes in a packed row.
template <class T>
inline constexpr std::size_t packed_width = (sizeof(T) + sizeof(double) - 1) / sizeof(double);

/// Doubles of a packed row of such bodies.
inline std::size_t packed_row_width(const Bodies& bodies) {
  std::size_t width = 0;
  for_each_field(bodies, [&](const char*, const auto& field) {
    width += packed_width<typename std::remove_cvref_t<decltype(field)>::value_type>;
  });
  return width;
}

/// Appends row `b` of every field to `out`.
inline void pack_row(const Bodies& bodies, Index b, std::vector<double>& out) {
  for_each_field(bodies, [&](const char*, const auto& field) {
    using T = typename std::remove_cvref_t<decltype(field)>::value_type;
    const std::size_t at = out.size();
    out.resize(at + packed_width<T>);
    std::memcpy(out.data() + at, &field[b], sizeof(T));
  });
}

/// Appends packed rows of bodies with the same fields; `owned` is left to the caller.
inline void unpack_rows(Bodies& bodies, std::span<const double> rows) {
  std::size_t at = 0;
  while (at < rows.size()) {
    for_each_field(bodies, [&](const char*, auto& field) {
      using T = typename std::remove_cvref_t<decltype(field)>::value_type;
      T value;
      std::memcpy(static_cast<void*>(&value), rows.data() + at, sizeof(T));
      field.push_back(value);
      at += packed_width<T>;
    });
  }
}

/// Grows or cuts every field to `rows`; `owned` never exceeds it.
inline void resize(Bodies& bodies, Index rows) {
  for_each_field(bodies, [&](const char*, auto& field) { field.resize(rows); });
  bodies.owned = std::min(bodies.owned, rows);
}

}  // namespace spall
