// Rows of bodies: all fields grow and shrink together.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/bodies.hpp"

#include <algorithm>

namespace spall {

void fill_fields(Bodies& bodies) {
  for_each_field(
      bodies, [&](const auto& info, auto& field) { field.resize(bodies.id.size(), info.initial); });
}

void resize(Bodies& bodies, Index rows) {
  bodies.id.resize(rows);
  fill_fields(bodies);
  bodies.owned = std::min(bodies.owned, rows);
}

Index append_row(Bodies& bodies) {
  bodies.id.push_back(0);
  fill_fields(bodies);
  return bodies.size() - 1;
}

void set_fields(Bodies& bodies, const FieldSet& fields) {
  for_each_field(bodies, [&](const auto& info, auto& field) {
    if (!fields.has(info.field)) field = {};
  });
  bodies.fields = fields;
  fill_fields(bodies);
}

}  // namespace spall
