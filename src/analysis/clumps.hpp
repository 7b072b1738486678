// Clumps: which bodies hang together, by contact or by gravity, found without gathering them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "domain/ghosts.hpp"
#include "pairs/links.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// The name of the clump of each body, row by row, ghosts too: the smallest id of all bodies that a
/// chain of links joins to it. It is the same on any number of ranks. Collective.
std::vector<BodyId> find_clumps(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                                const Links& links);

/// What moves and weighs like one body.
struct Clump {
  BodyId name = 0;               ///< smallest id in it
  std::int64_t count = 0;        ///< bodies
  double mass = 0;               ///< kg
  Vec3 position = Vec3::Zero();  ///< m, centre of mass
  Vec3 velocity = Vec3::Zero();  ///< m/s, mass-weighted mean
};

/// The heaviest clumps of the owned bodies, at most `listed`, by mass, then by name. Bodies with
/// `name[b] < 0` belong to none. Collective, the same on all ranks.
std::vector<Clump> heaviest_clumps(const Comm& comm, const Bodies& bodies,
                                   std::span<const BodyId> name, std::size_t listed);

/// This rank's share of all clumps, each on one of the ranks. Collective.
std::vector<Clump> share_of_clumps(const Comm& comm, const Bodies& bodies,
                                   std::span<const BodyId> name);

/// Whether the gravity of `clump` holds a body that is not in it: with the clump taken as a point
/// mass at its centre of mass, the energy of their relative motion is negative,
///
///   |v - V|^2 / 2 < G (M + m) / |x - X|.
bool is_bound(const Vec3& position, const Vec3& velocity, double mass, const Clump& clump,
              double gravity_constant);

/// Adds to `clump` the bodies that it holds by `is_bound`, and returns the grown clump. Bodies are
/// judged one by one, also those of a connected piece. This is repeated with the grown clump until
/// nothing more is bound. Owned bodies that join get `name[b] = clump.name`; bodies with
/// `name[b] < 0` never join. Collective.
Clump add_bound_bodies(const Comm& comm, const Bodies& bodies, double gravity_constant,
                       const Clump& clump, std::span<BodyId> name);

}  // namespace spall
