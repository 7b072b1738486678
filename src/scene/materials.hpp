// What a case says of materials, and the laws that follow from it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "section.hpp"
#include "spall/scene/case.hpp"

namespace spall {

/// [materials.NAME]: the density of a sphere, or the constants of a solid.
void read_material(Section& in, Material& material);

/// The key `material` of a law that may follow from a material.
void read_derived_law(Section& in, std::string_view meaning, std::optional<DerivedLaw>& law);

/// Puts what the files that materials name hold into their tables [materials.NAME.solid], and the
/// same as overrides into `overrides`: a restart needs no such file.
void insert_material_files(toml::table& root, const std::string& file,
                           std::vector<std::string>& overrides);

/// Turns the lattices whose orientation is left to the seed.
void draw_orientations(Case& scene);

/// The laws that the case leaves to its materials, for the lattices of its groups.
void derive_laws(Case& scene);

}  // namespace spall
