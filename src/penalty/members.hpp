// What penalty contact sees of clumps: their spheres, each a body of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "penalty/touch_pairs.hpp"
#include "state/world.hpp"

namespace spall {

/// The spheres that the bodies of a world with shapes are made of, as rows that contacts know as
/// bodies. A sphere has the mass of its whole body, and its body's motion where it is. Empty where
/// all bodies are spheres: they are their own members.
struct Members {
  Bodies bodies;             ///< a row a sphere, in the order of its bodies; then those of ghosts
  std::vector<Index> whole;  ///< of owned rows: the row of the body
  std::vector<Vec3> arm;     ///< m, of owned rows: from the body's centre
  std::vector<Vec3> shift;   ///< m, of owned rows: what the period set them back by; may be empty
  std::vector<ForceRow> loads;  ///< of owned bodies, as `add_up_loads` leaves them
  std::vector<Vec3> found_at;   ///< m, of owned bodies: where they were at the last search
};

/// Those of the owned bodies as they lie now, without ghosts.
Members members_of(const World& world);

/// Owned members go with their bodies.
void follow_bodies(const World& world, Members& members);

/// After a search, which sets rows back into the period.
void note_shifts(const World& world, Members& members);

/// What contacts see of the world: its bodies, or their members.
inline Bodies& meeting(World& world, Members& members) {
  return world.shapes.empty() ? world.bodies : members.bodies;
}
inline const Bodies& meeting(const World& world, const Members& members) {
  return world.shapes.empty() ? world.bodies : members.bodies;
}

/// A member's id is that of its body times this, and its place in the shape. 1 where all bodies are
/// spheres.
BodyId members_a_body(const BodyShapes& shapes);
/// A memory by the ids of members, from one by those of bodies that names the spheres which touch.
/// The same where a body has one member.
SharedContacts by_members(const SharedContacts& contacts, BodyId members);
/// What pairs remember, by the ids of bodies; each on one rank with `once`, else on every rank that
/// has it. After a restart, up to the first search, what it came with.
SharedContacts remember(const World& world, const Members& members, const TouchPairs& touch,
                        bool once);

/// Of owned bodies, as the domain is cut by: that of their members.
std::vector<double> work_of_bodies(const World& world, const Members& members,
                                   const TouchPairs& touch);

/// The forces on owned members as forces and torques on their bodies. All rows are zero then.
void add_up_loads(const World& world, std::vector<ForceRow>& rows, Members& members);

/// Finds ghosts and pairs anew; cuts the domain before where the ranks' work differs by more than a
/// tenth. Springs stay with their pairs. Throws Error where space repeats itself so soon that a
/// body would meet two images of another. Collective.
void search_touch_pairs(World& world, const TouchRange& range, Members& members, TouchPairs& touch);

/// m, between two rows of the bodies; negative where they overlap.
double gap_between(const BodyShapes& shapes, const Bodies& bodies, Index i, Index j);

}  // namespace spall
