// What a case says of the shapes of bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "keys/input_files.hpp"
#include "keys/section.hpp"
#include "scene/case.hpp"

namespace spall {

/// Puts the spheres into all tables [shapes.NAME] that name a `file` of a surface, and adds them to
/// `kept` as changes, with which the case needs the file no more. Throws Error, with file, line and
/// key.
void insert_filled_shapes(toml::table& root, const std::string& file,
                          std::vector<std::string>& kept, const InputFiles& files);

/// [shapes.NAME]: a list of spheres, or how an ellipsoid or a surface is filled with them.
void read_shape(Section& in, ListedShape& shape);

/// Gives the case the shapes that its groups name, and the groups their numbers. A shape of one
/// sphere is the sphere. Throws Error on names that are not there, and on what shapes are not
/// modelled with.
void gather_shapes(Case& scene);

}  // namespace spall
