// Clumps: which bodies hang together, by contact or by gravity, found without gathering them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "spall/base/comm.hpp"
#include "spall/contact/contacts.hpp"
#include "spall/domain/ghosts.hpp"
#include "spall/scene/bodies.hpp"

namespace spall {

/// Pairs of rows of `bodies` that count as connected; a pair with a ghost is on both ranks, as in
/// `Contacts`.
struct Links {
  std::vector<Index> i, j;
};

/// Row by row of this rank's bodies (ghosts too), the smallest id of all bodies that a chain of
/// links joins to it: the clump's name, the same on any number of ranks. Collective.
std::vector<BodyId> find_clumps(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                                const Links& links);

/// The pairs of spheres with a gap of at most `tolerance`, m.
Links links_of(const Contacts& contacts, double tolerance);

/// What moves and weighs like one body.
struct Clump {
  BodyId name = 0;               ///< smallest id in it
  std::int64_t count = 0;        ///< bodies
  double mass = 0;               ///< kg
  Vec3 position = Vec3::Zero();  ///< m, centre of mass
  Vec3 velocity = Vec3::Zero();  ///< m/s, mass-weighted mean
};

struct ClumpList {
  std::int64_t clumps = 0;     ///< how many there are
  std::vector<Clump> largest;  ///< by mass, then by name; the same on all ranks
};

/// Sums over each clump of the owned bodies, and lists the `listed` heaviest. Bodies with
/// `name[b] < 0` belong to none. Collective.
ClumpList weigh_clumps(const Comm& comm, const Bodies& bodies, std::span<const BodyId> name,
                       std::size_t listed = 10);

/// Whether the gravity of `clump` holds a body that is not in it: with the clump taken as a point
/// mass at its centre of mass, the energy of their relative motion is negative,
///
///   |v - V|^2 / 2 < G (M + m) / |x - X|.
bool is_bound(const Vec3& position, const Vec3& velocity, double mass, const Clump& clump,
              double gravity_constant);

/// Adds to `clump` the bodies that `is_bound` says it holds, singly: a piece that is held is held
/// body by body. Repeated with the grown clump until nothing more is bound. Gives `name[b] =
/// clump.name` to owned bodies that join; bodies with `name[b] < 0` never do. Returns the grown
/// clump. Collective.
Clump add_bound_bodies(const Comm& comm, const Bodies& bodies, double gravity_constant,
                       const Clump& clump, std::span<BodyId> name);

}  // namespace spall
