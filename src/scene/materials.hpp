// What a case says of materials, and the laws that follow from it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// [materials.NAME]: the density of a sphere, or the constants of a solid.
void read_material(Section& in, Material& material);

/// The place in `materials` of what the key `material` of a table names; `same_material` where it
/// is left out.
int find_material(const Section& in, const std::string& name,
                  const std::vector<Material>& materials);

/// Puts the constants of the files and of the library that materials name into their tables
/// [materials.NAME.solid], and the same as overrides into `kept`: a restart needs neither.
void insert_named_constants(toml::table& root, const std::string& file,
                            std::vector<std::string>& kept, const InputFiles& files);

/// Turns the lattices whose orientation is left to the seed.
void draw_orientations(Case& scene);

/// What the groups are made of, as laws see it.
std::vector<MaterialUse> material_uses(const Case& scene);

/// The cohesion that the case leaves to a material, for the lattice of its groups; then the laws of
/// pairs of materials.
void derive_contact_law(Case& scene, std::span<const MaterialUse> uses);

}  // namespace spall
