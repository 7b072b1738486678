// Rows of bodies as doubles that carry the bits of the fields with a trait, for messages.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstring>
#include <span>
#include <vector>

#include "spall/bodies.hpp"

namespace spall {

/// Doubles that one value of a field takes in a packed row.
template <class T>
inline constexpr std::size_t packed_width = (sizeof(T) + sizeof(double) - 1) / sizeof(double);

/// Doubles of a packed row of such bodies.
inline std::size_t packed_row_width(const Bodies& bodies, unsigned any_of) {
  std::size_t width = 0;
  for_each_field(bodies, [&]<class T>(const TypedField<T>& info, const auto&) {
    if (info.is(any_of)) width += packed_width<T>;
  });
  return width;
}

/// Appends a value's bits to `out`.
template <class T>
void pack_value(const T& value, std::vector<double>& out) {
  const std::size_t at = out.size();
  out.resize(at + packed_width<T>);
  std::memcpy(out.data() + at, &value, sizeof(T));
}
template <class T>
T unpack_value(const double* at) {
  T value;
  std::memcpy(static_cast<void*>(&value), at, sizeof(T));
  return value;
}

/// Appends row `b` of every field with one of these traits to `out`.
inline void pack_row(const Bodies& bodies, Index b, unsigned any_of, std::vector<double>& out) {
  for_each_field(bodies, [&]<class T>(const TypedField<T>& info, const auto& field) {
    if (info.is(any_of)) pack_value(field[b], out);
  });
}

/// Appends packed rows of bodies with the same fields, which get defaults where they were not
/// packed; `owned` is left to the caller.
inline void unpack_rows(Bodies& bodies, std::span<const double> rows, unsigned any_of) {
  std::size_t at = 0;
  while (at < rows.size()) {
    for_each_field(bodies, [&]<class T>(const TypedField<T>& info, auto& field) {
      T value = info.initial;
      if (info.is(any_of)) {
        value = unpack_value<T>(rows.data() + at);
        at += packed_width<T>;
      }
      field.push_back(value);
    });
  }
}

}  // namespace spall
