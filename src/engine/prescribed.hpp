// Bodies of infinite mass: fixed ones, and those that move as their group's motion prescribes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/flight.hpp"
#include "state/world.hpp"

namespace spall {

/// Whatever acts on it, its motion stays: it is fixed, or moves as prescribed.
inline bool is_held(const Bodies& bodies, Index b) {
  return bodies.mass[b] == infinity;
}

/// Bodies of moving groups get their velocities of the time from `from` on, means over `h` (s): a
/// step at these velocities ends where it must. Their spins, too. Ghosts are left alone. Returns
/// the rows.
std::vector<Index> set_prescribed_velocities(World& world, double from, double h);

/// m/s^2 over all ranks: what drives bodies of each group at most, from time `from` to time `to`.
/// Empty where nothing is prescribed. Collective.
std::vector<double> prescribed_accelerations(const World& world, double from, double to);

/// m/s over all ranks, at most: the speed at which two spheres, of clumps too, or one and a wall,
/// may meet within `lasts` (s) from `world.time` on, wherever they are now. Those of moving groups
/// go their ways and do not act on each other; all others fly straight on. Collective.
double largest_meeting_speed(const World& world, double lasts);

/// A body that moves as prescribed, where it must be now.
struct PrescribedPlace {
  Index row;
  Vec3 position;
};
/// Time goes on by `t` (s): `world.time`. Tells where bodies of moving groups are then, and adds
/// their mean velocities meanwhile to `velocities`.
std::vector<PrescribedPlace> advance_prescribed(World& world, double t, RowBox& velocities);
/// The same, and puts them there.
void move_prescribed(World& world, double t);

/// The held body `b`, at `x`, received an impulse (N s) and a turn (N m s): enters both, and the
/// work that this took.
void book_held(World& world, Index b, const Vec3& x, const Vec3& impulse, const Vec3& turn);

/// Throws Error, which begins with `place`, on every rank, where a fixed body has a velocity or a
/// spin, or where a body is not where its group's motion has it by now. Collective.
void check_held(const World& world, const std::string& place);

}  // namespace spall
