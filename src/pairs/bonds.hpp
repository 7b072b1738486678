// Bonds between neighbours that break for good: found, kept by the ids of their bodies, lost.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

struct NearPairs;

/// The bonds of owned bodies, each with both: row b is bound to the ids other[start[b]] up to
/// other[start[b + 1]]; rows beyond the last have none.
struct Bonds {
  std::vector<Index> start{0};
  std::vector<BodyId> other;

  Index count(Index row) const {
    return row + 1 < std::ssize(start) ? start[row + 1] - start[row] : 0;
  }
  bool has(Index row, BodyId id) const;
};

/// Those that hold now; none where bonds do not break or have not been made yet.
std::optional<Bonds> bonds_of(const Bodies& bodies, const NearPairs& near);

/// m, up to which the bodies of two rows are bound where bonds are made; 0: never. An empty one:
/// bonds do not break.
using BondReach = std::function<double(Index, Index)>;

/// The bonds of bodies nearer to each other than their reach; booked as the bonds that the bodies
/// were made with.
void make_bonds(Bodies& bodies, NearPairs& near, const BondReach& reach);
/// Those of the pairs found that were bound before.
void recall_bonds(const Bodies& bodies, const Bonds& bonds, NearPairs& near);

/// Sends every owned body to rank `owner[b]`, and its bonds with it. Collective.
void migrate(const Comm& comm, Bodies& bodies, std::optional<Bonds>& bonds,
             const std::vector<int>& owner);

/// `damage` of the owned bodies: the share of the bonds that they were made with that are broken.
void measure_damage(Bodies& bodies, const NearPairs& near);

}  // namespace spall
