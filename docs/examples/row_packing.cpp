// A packing in one file: spheres in a row through the middle of a volume. Compiled by the tests.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/packing.hpp"
#include "scene/shape.hpp"

namespace spall {
namespace {

/// What its keys say.
struct Row {
  double gap = 0;  ///< m, between the surfaces
};

void read(Section& in, Packing& packing) {
  Row row;
  in.take("gap", "of row: between the surfaces", row.gap, not_negative(dimension::length));
  packing.own = row;
}

void place(const PackingRequest& request) {
  const double radius = request.packing.radius;
  const double pitch = 2 * radius + std::any_cast<const Row&>(request.packing.own).gap;
  const double room = half_widths(request.volume).x() - radius;  // of centres, both ways
  const auto last = static_cast<std::int64_t>(room / pitch);
  for (std::int64_t k = -last; k <= last; ++k) {
    const Vec3 center = request.volume.center + static_cast<double>(k) * pitch * Vec3::UnitX();
    if (depth(request.volume, center) >= radius) request.put({.center = center, .radius = radius});
  }
}

}  // namespace

extern const PackingType row_packing;
const PackingType row_packing{.name = "row", .read = read, .place = place};

}  // namespace spall
