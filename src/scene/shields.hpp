// [[shields]]: which groups are walls that a run judges, and which way leads through them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

void read_shield(Section& in, Shield& shield);

/// Looks the walls up by name, finds their rear where it is left out, and throws Error where a wall
/// cannot be judged.
void find_shield_walls(Case& scene);

/// m: how far beyond the edge of a plate a line from `from` along `velocity` meets the plane of its
/// middle; negative where it meets the plate. `spacing` (m): beyond the rim of a wall of such
/// bodies, which is not judged.
double miss_of_line(const Volume& plate, const Vec3& from, const Vec3& velocity,
                    double spacing = 0);

/// m: the largest of a volume's widths along its axes, as seen along `flight`, a unit vector.
double width_across(const Volume& volume, const Vec3& flight);

/// m: how wide the rim of a wall is that is not judged.
double rim_of(double half_width, double spacing);

/// m/s, towards the wall along `normal`, of a group that is before it and whose line of flight
/// meets it; else 0.
double speed_of_flight(const Group& wall, const Group& other, const Vec3& normal);

/// The same along `normal` or against it.
double speed_from_either_side(const Group& wall, const Group& other, const Vec3& normal);

/// Its own axis that leads through a plate; -1 of a volume that is none.
int axis_through(const Volume& volume);

/// "shield_rear": the section of a wall in results.
std::string results_of(const Shield& shield);

/// "_rear_2" of "rear-2": what sections of results of a group end in.
std::string section_end(const std::string& group);

}  // namespace spall
