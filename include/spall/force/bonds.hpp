// Bonds between neighbours that break for good: found, kept by the ids of their bodies, lost.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "spall/base/comm.hpp"
#include "spall/scene/bodies.hpp"

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

/// The bonds of bodies of one group that are nearer to each other than `reach` (m); booked as the
/// bonds that the bodies were made with.
void make_bonds(Bodies& bodies, NearPairs& near, double reach);
/// Those of the pairs found that were bound before.
void recall_bonds(const Bodies& bodies, const Bonds& bonds, NearPairs& near);

/// Bonds on their way to the ranks to which their bodies go: sent before bodies migrate, arranged
/// by rows after it. Both collective.
using SentBonds = std::vector<std::vector<std::int64_t>>;
SentBonds send_bonds(const Comm& comm, const Bodies& bodies, const Bonds& bonds,
                     const std::vector<int>& owner);
Bonds arrange_bonds(const Bodies& bodies, const SentBonds& sent);

/// `damage` of the owned bodies: the share of the bonds that they were made with that are broken.
void measure_damage(Bodies& bodies, const NearPairs& near);

}  // namespace spall
