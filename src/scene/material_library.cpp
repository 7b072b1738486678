// The library's texts; what they hold, told line by line.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/material_library.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <vector>

#include "keys/toml_text.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr LibraryMaterial texts[] = {
#include <material_library.inc>  // by cmake/material_library.cmake
};

}  // namespace

std::span<const LibraryMaterial> material_library() {
  return texts;
}

const LibraryMaterial& library_material(std::string_view name) {
  const auto found = std::ranges::find(texts, name, &LibraryMaterial::name);
  if (found != std::end(texts)) return *found;
  std::vector<std::string_view> names;
  for (const LibraryMaterial& material : texts) names.push_back(material.name);
  throw Error(
      fmt::format("\"{}\" is not in the library of materials: {}", name, fmt::join(names, ", ")));
}

std::string describe_material_library() {
  const auto line = [](std::string_view name, const std::string& title, const std::string& known) {
    return fmt::format("{:<23} {:<30} {}\n", name, title, known);
  };
  std::string told = line("library", "", "known beside shocks and elasticity");
  for (const LibraryMaterial& material : texts) {
    const toml::table table = parse_toml(std::string(material.text), std::string(material.name));
    std::string known;
    const auto tell = [&](const char* key, const char* what) {
      if (table.contains(key)) known += (known.empty() ? "" : ", ") + std::string(what);
    };
    tell("yield_strength", "yield");
    tell("johnson_cook_a", "flow stress");
    tell("steinberg_y0", "flow stress under pressure");
    tell("johnson_cook_d1", "strain at failure");
    tell("spall_strength", "spall");
    tell("fracture_energy", "toughness");
    tell("weibull_k", "flaws");
    tell("lundborg_limit", "strength under pressure");
    tell("failed_friction", "friction");
    tell("distension", "pores");
    tell("melting_point", "melting");
    tell("melt_energy", "its energy");
    told += line(material.name, table["title"].value_or(std::string()), known);
  }
  return told +
         "\nA case takes one by [materials.plate] library = \"copper\".\n"
         "`spall materials NAME` prints its constants and their sources: a file to change them "
         "in.\n";
}

}  // namespace spall
