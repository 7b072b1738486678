// From a case's recipes to bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "scene/case.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// What a group makes.
struct GroupContent {
  std::int64_t count = 0;                   ///< bodies
  std::int64_t movable = 0;                 ///< of them, unless the whole group is fixed
  double volume = 0;                        ///< m^3, of the bodies
  double mass = 0;                          ///< kg, of the movable, before it is scaled
  double lightest = infinity;               ///< kg, of the movable, before it is scaled
  double smallest = infinity, largest = 0;  ///< m, radii

  /// One body more; its mass counts where it moves.
  void add(double with_radius, double with_mass, bool moves) {
    ++count;
    smallest = std::min(smallest, with_radius);
    largest = std::max(largest, with_radius);
    if (!moves) return;
    ++movable;
    mass += with_mass;
    lightest = std::min(lightest, with_mass);
  }
  /// What the mass of each body is multiplied with, for the total that the group asks for.
  double mass_factor(const Group& group) const {
    return group.total_mass && mass > 0 ? *group.total_mass / mass : 1;
  }
};
/// As its recipe makes them: meshes and packings of files must have been read.
std::vector<GroupContent> measure_groups(const Case& scene);
/// As they are, but for their volumes: a run that goes on does not read files again. Masses are
/// scaled already. Collective.
std::vector<GroupContent> measure_bodies(const Comm& comm, const Case& scene, const Bodies& bodies);

/// The fields of a case's bodies: what spins, gravity and its engines request.
FieldSet fields_of(const Case& scene);

/// A world with a case's surroundings and no bodies yet.
World make_world(const Comm& comm, const Case& scene);

/// The number of the group that spheres of a program are in: after the impactor's.
inline std::int32_t group_of_spheres(const Case& scene) {
  return static_cast<std::int32_t>(scene.groups.size()) + 1;
}

/// The bodies of all groups: ids 0 … N-1 in the order of the case, whatever the number of ranks;
/// this rank gets a contiguous share of the ids. Random packings keep clear of earlier groups and
/// of planes. Throws Error, the same on every rank, on no bodies, more ranks than bodies, bodies
/// that overlap earlier ones or planes by more than allowed, and packings that do not fit.
/// Every rank runs through the whole recipe, but for looking where random packings have room, which
/// they share. Collective.
Bodies make_bodies(const Case& scene, const Comm& comm);

/// Bytes that a rank of so many needs at most, on top of what the program takes before it has
/// bodies.
double bytes_of_a_rank(const Case& scene, const std::vector<GroupContent>& contents, int ranks,
                       double bytes_of_program);
/// What a case will make: bodies, masses, packings, and the memory that a rank of so many needs,
/// on top of what the program takes before it has bodies.
std::string describe_bodies(const Case& scene, int ranks, double bytes_of_program);
/// A sentence for each lattice whose mass is more than 5 % off that of its volume.
std::vector<std::string> unfilled_lattices(const Case& scene,
                                           const std::vector<GroupContent>& contents);
/// What a case will run: what is switched off, phases and their step limits.
std::string describe_phases(const Case& scene, const std::vector<GroupContent>& contents);

}  // namespace spall
