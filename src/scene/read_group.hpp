// The keys of [[groups]]: a recipe of bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// `folder`: where files that a group names lie unless their paths are absolute.
void read_group(Section& in, Group& group, const std::vector<Material>& materials,
                const std::string& folder);

/// Reads the meshes that the groups' volumes name.
void load_meshes(Case& scene, const InputFiles& files);

}  // namespace spall
