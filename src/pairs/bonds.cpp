// A bond is a bit beside its pair while the pair is listed; from one list to the next it is an id.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/bonds.hpp"

#include <algorithm>
#include <bit>
#include <numeric>

#include "domain/migration.hpp"
#include "pairs/near_pairs.hpp"
#include "state/rows_of_ids.hpp"

namespace spall {
namespace {

/// Binds the pairs for which `holds(row, partner)`.
template <class Holds>
void bind_pairs(NearPairs& near, Holds&& holds) {
  for (NearWindow& window : near.windows)
    window.bound.assign(window.partners.size() / doubles_a_row, 0);
  for_each_pair(near.windows,
                [&](std::size_t w, std::size_t slot, std::size_t l, Index i, Index j) {
                  if (holds(i, j)) near.windows[w].bound[slot] |= 1 << l;
                });
}

/// Calls `f(i, j)` with either end of each bond that is an owned body: one with a ghost is on both
/// ranks, as its pair is.
template <class F>
void for_each_end(const Bodies& bodies, const NearPairs& near, F&& f) {
  for (const NearWindow& window : near.windows)
    for_each_slot(window, [&](std::size_t slot, const Index* own, const Index* partners) {
      for (unsigned left = window.bound[slot]; left != 0; left &= left - 1) {
        const int lane = std::countr_zero(left);
        const Index i = own[lane] / doubles_a_row, j = partners[lane] / doubles_a_row;
        f(i, j);
        if (j < bodies.owned) f(j, i);
      }
    });
}

/// With room for `counts` of each row; row b's next place is start[b].
Bonds with_room(std::vector<Index> counts) {
  Bonds bonds;
  counts.push_back(0);
  std::exclusive_scan(counts.begin(), counts.end(), counts.begin(), 0);
  bonds.other.resize(counts.back());
  bonds.start = std::move(counts);
  return bonds;
}

/// All places are taken: start[b] is where row b ends, and becomes where it begins.
void close(Bonds& bonds) {
  std::shift_right(bonds.start.begin(), bonds.start.end(), 1);
  bonds.start.front() = 0;
}

}  // namespace

bool Bonds::has(Index row, BodyId id) const {
  if (count(row) == 0) return false;
  // All at once: a dozen are compared faster than one after another.
  bool found = false;
  for (Index k = start[row]; k < start[row + 1]; ++k) found |= other[k] == id;
  return found;
}

std::optional<Bonds> bonds_of(const Bodies& bodies, const NearPairs& near) {
  if (near.skin == 0) return near.bonds;
  if (!near.bonds_break) return {};
  std::vector<Index> counts(bodies.owned, 0);
  for_each_end(bodies, near, [&](Index i, Index) { ++counts[i]; });
  Bonds bonds = with_room(std::move(counts));
  for_each_end(bodies, near,
               [&](Index i, Index j) { bonds.other[bonds.start[i]++] = bodies.id[j]; });
  close(bonds);
  return bonds;
}

void make_bonds(Bodies& bodies, NearPairs& near, const BondReach& reach_of) {
  bind_pairs(near, [&](Index i, Index j) {
    const double reach = reach_of(i, j);
    return (bodies.position[i] - bodies.position[j]).squaredNorm() < reach * reach;
  });
  std::fill(bodies.bonds.begin(), bodies.bonds.end(), 0);
  for_each_end(bodies, near, [&](Index i, Index) { ++bodies.bonds[i]; });
}

void recall_bonds(const Bodies& bodies, const Bonds& bonds, NearPairs& near) {
  bind_pairs(near, [&](Index i, Index j) { return bonds.has(i, bodies.id[j]); });
}

void migrate(const Comm& comm, Bodies& bodies, std::optional<Bonds>& bonds,
             const std::vector<int>& owner) {
  SharedContacts none;
  if (!bonds) return migrate(comm, bodies, none, owner);
  ByRank<std::int64_t> rows;
  for (Index b = 0; b < bodies.owned; ++b) {
    auto& row = rows[owner[b]];
    row.insert(row.end(), {bodies.id[b], bonds->count(b)});
    if (bonds->count(b) == 0) continue;
    const auto first = bonds->other.begin() + bonds->start[b];
    row.insert(row.end(), first, first + bonds->count(b));
  }
  rows = comm.exchange(std::move(rows));
  migrate(comm, bodies, none, owner);

  const RowsOfIds row_of(bodies);
  const auto for_each_body = [&](auto&& f) {
    for (const auto& [rank, from] : rows)
      for (auto at = from.begin(); at != from.end(); at += 2 + at[1]) f(row_of.find(at[0]), at);
  };
  std::vector<Index> counts(bodies.owned, 0);
  for_each_body([&](Index b, auto at) { counts[b] = static_cast<Index>(at[1]); });
  *bonds = with_room(std::move(counts));
  for_each_body([&](Index b, auto at) {
    std::copy_n(at + 2, at[1], bonds->other.begin() + bonds->start[b]);
  });
}

void measure_damage(Bodies& bodies, const NearPairs& near) {
  const std::optional<Bonds> now = bonds_of(bodies, near);
  if (!now || !bodies.has(Field::damage)) return;
  for (Index b = 0; b < bodies.owned; ++b) {
    const double made = bodies.bonds[b];
    bodies.damage[b] = made > 0 ? 1 - now->count(b) / made : 0;
  }
}

}  // namespace spall
