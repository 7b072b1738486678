// Who is near whom: ghosts and pairs that stay valid while bodies move less than their reach.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "pairs/broad_phase.hpp"
#include "pairs/search.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Gaps up to this part of the smaller radius are contacts even at rest: what pushes one contact
/// may close its neighbour in the same step.
inline constexpr double near_contact = 0.01;

struct Neighbours : Search {
  Pairs pairs;
  SharedContacts carried;       ///< impulses to start from, of a restart; taken by the next search
  bool valid = false;           ///< false: search before the next step, as after a change of bodies
  std::vector<double> reach;    ///< m: how far a body may come from there, a step's motion included
  Vec3 drift = Vec3::Zero();    ///< m/s: motion that all share, on top of that
  Vec3 drifted = Vec3::Zero();  ///< m: by which places have moved with it since
};

/// What pairs remember, by id; each contact on one rank with `once`, else on every rank that has
/// it. After a restart, up to the first search, what it came with.
SharedContacts remember(const Bodies& bodies, const Neighbours& neighbours, bool once);

/// Of owned bodies: contacts and bodies are what a step costs; a pair with a ghost is work on both
/// ranks.
std::vector<double> work_of(const Bodies& bodies, const Pairs& pairs);

/// Makes ghosts and pairs current for a step `h` (s): copies the ghosts' new state, and where a
/// body might leave its reach searches pairs anew; before a search cuts the domain anew where the
/// ranks' work (bodies and contacts) differs by more than a tenth. Impulses stay with their pairs.
/// Collective.
void update_neighbours(const Comm& comm, Bodies& bodies, const std::vector<Plane>& planes, double h,
                       double cohesion_range, Neighbours& neighbours);

}  // namespace spall
