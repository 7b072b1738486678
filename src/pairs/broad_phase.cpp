// The list in the order of the rows, pairs with ghosts first; impulses by the ids of their bodies.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/broad_phase.hpp"

#include <algorithm>
#include <array>

#include "pairs/grid.hpp"
#include "pairs/recall.hpp"

namespace spall {

Pairs find_pairs(const Bodies& bodies, std::span<const double> reach,
                 const std::vector<Plane>& planes) {
  // Rows come in the order of their cells.
  std::vector<Index> partners;
  std::vector<std::array<std::size_t, 2>> of_row(bodies.owned);
  std::size_t first = 0;
  find_partners(bodies, {.of_rows = reach}, ListedWith::lower_row, partners, [&](Index row, Index) {
    of_row[row] = {first, partners.size()};
    first = partners.size();
  });

  Pairs boundary, interior;
  const auto add = [&](Index a, Index b, std::int32_t plane) {
    if (b >= 0 && bodies.id[a] > bodies.id[b]) std::swap(a, b);
    Pairs& part = a >= bodies.owned || b >= bodies.owned ? boundary : interior;
    part.i.push_back(a);
    part.j.push_back(b);
    part.plane.push_back(plane);
  };
  for (Index b = 0; b < bodies.owned; ++b)
    for (std::size_t k = of_row[b][0]; k < of_row[b][1]; ++k) add(b, partners[k], -1);
  for (Index b = 0; b < bodies.owned; ++b)
    for (std::size_t k = 0; k < planes.size(); ++k)
      if (planes[k].normal.dot(bodies.position[b] - planes[k].point) <=
          bodies.radius[b] + 2 * reach[b])
        add(b, ground, static_cast<std::int32_t>(k));

  Pairs pairs = std::move(boundary);
  pairs.boundary = pairs.size();
  pairs.i.insert(pairs.i.end(), interior.i.begin(), interior.i.end());
  pairs.j.insert(pairs.j.end(), interior.j.begin(), interior.j.end());
  pairs.plane.insert(pairs.plane.end(), interior.plane.begin(), interior.plane.end());
  return pairs;
}

ContactMemory remember(const Bodies& bodies, const Pairs& pairs, bool once) {
  const auto is_kept = [&](const CarriedImpulse& carried) {
    return !(once && pairs.i[carried.pair] >= bodies.owned);
  };
  const bool shapes = bodies.has(Field::shape);
  ContactMemory memory;
  memory.reserve(std::ranges::count_if(pairs.carried, is_kept));
  for (const CarriedImpulse& carried : pairs.carried) {
    if (!is_kept(carried)) continue;
    const Index i = pairs.i[carried.pair], j = pairs.j[carried.pair];
    memory.add(bodies.id[i], j == ground ? -1 - pairs.plane[carried.pair] : bodies.id[j],
               carried.impulse);
    if (shapes) memory.name_spheres({carried.of_i, carried.of_j});
  }
  return memory;
}

void recall(const Bodies& bodies, const ContactMemory& memory, Pairs& pairs) {
  const Recall kept(bodies, memory);
  pairs.carried.reserve(memory.size());
  for (Index p = 0; p < pairs.size(); ++p) {
    const bool wall = pairs.j[p] == ground;
    if (memory.spheres.empty()) {
      const Index m =
          wall ? kept.of_wall(pairs.i[p], pairs.plane[p]) : kept.of_pair(pairs.i[p], pairs.j[p]);
      if (m >= 0) pairs.carried.push_back({.pair = p, .impulse = memory.impulse[m]});
      continue;
    }
    const auto found = wall ? kept.all_of_wall(pairs.i[p], pairs.plane[p])
                            : kept.all_of_pair(pairs.i[p], pairs.j[p]);
    const auto first = static_cast<std::ptrdiff_t>(pairs.carried.size());
    for (const Recall::Entry& entry : found) {
      const auto [of_i, of_j] = memory.spheres[entry.at];
      // A restart may tell of a contact on both of its ranks.
      const bool known =
          std::any_of(pairs.carried.begin() + first, pairs.carried.end(),
                      [&](const CarriedImpulse& c) { return c.of_i == of_i && c.of_j == of_j; });
      if (!known) pairs.carried.push_back({p, of_i, of_j, memory.impulse[entry.at]});
    }
  }
}

}  // namespace spall
