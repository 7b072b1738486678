// Gravity between clumps that are near each other: by their parts, not by their centres alone.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "gravity/field.hpp"
#include "state/world.hpp"

namespace spall {

/// Where the two bodies of a pair are nearer than `near_clumps` sums of their radii, and one of
/// them is a clump, their parts attract each other as points at their centres of mass. From half of
/// that distance on this fades out. With U the energy of a pair, x its distance over the furthest
/// one, and y = 2 x - 1 from 0 on,
///
///   U = U_centres + S (U_parts - U_centres),   S = 1 - y^3 (10 - 15 y + 6 y^2).
///
/// Forces and torques are the derivatives of U: energy, momentum and angular momentum are kept.
/// Enters the change into the `field` of the owned bodies' centres; its rates stay theirs. Returns
/// angular accelerations (rad/s^2) of owned bodies. Collective.
std::vector<Vec3> attract_near_clumps(const World& world, GravityField& field);

/// What the search for near bodies goes by: what it takes of owned bodies, and how far each of them
/// reaches beyond its sphere (m).
struct NearSearch {
  Bodies bodies;
  std::vector<double> reach;
};
NearSearch search_for_near_clumps(const Bodies& bodies, double near_clumps);

}  // namespace spall
