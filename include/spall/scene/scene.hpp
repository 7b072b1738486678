// From a case's recipes to bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "spall/base/comm.hpp"
#include "spall/scene/bodies.hpp"
#include "spall/scene/case.hpp"

namespace spall {

/// How many bodies each group makes.
std::vector<std::int64_t> count_bodies(const Case& scene);

/// kg, of each of the `count` spheres of a group, were it not fixed.
double mass_of_one(const Case& scene, const Group& group, std::int64_t count);

/// The bodies of all groups: ids 0 … N-1 in the order of the case, whatever the number of ranks;
/// this rank gets a contiguous share of the ids. Random packings keep clear of earlier groups and
/// of planes. Throws Error, the same on every rank, on no bodies, more ranks than bodies, bodies
/// that overlap earlier ones or planes by more than allowed, and packings that do not fit.
/// Every rank runs through the whole recipe, so nothing is sent.
Bodies make_bodies(const Case& scene, const Comm& comm);

/// What a case will make and run: bodies, masses, packings, memory, phases and their step limits.
std::string describe(const Case& scene);

}  // namespace spall
