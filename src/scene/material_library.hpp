// What handbooks and papers say of materials, as texts that the program carries.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace spall {

/// A file of cases/materials.
struct LibraryMaterial {
  std::string_view name;  ///< of the file, without its ending
  std::string_view
      text;  ///< TOML: the keys of [materials.NAME.solid]; its comments name the sources
};

/// In the order of their names.
std::span<const LibraryMaterial> material_library();

/// Throws Error, which names what there is, where there is none of that name.
const LibraryMaterial& library_material(std::string_view name);

/// A line a material: its name, what it is, and which constants are known.
std::string describe_material_library();

}  // namespace spall
