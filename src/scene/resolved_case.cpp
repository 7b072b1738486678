// Only names of files depend on where a case stands.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/resolved_case.hpp"

#include <filesystem>

#include "keys/toml_text.hpp"

namespace spall {

std::string resolved_text(toml::table root, const Case& scene) {
  if (root.contains("reference")) root.insert_or_assign("reference", "reference.toml");
  if (toml::table* materials = root["materials"].as_table())
    for (auto&& [name, node] : *materials)
      if (toml::table& material = *node.as_table(); material.contains("solid"))
        for (const char* source : {"file", "library"}) material.erase(source);
  if (toml::table* shapes = root["shapes"].as_table())
    for (auto&& [name, node] : *shapes)
      if (toml::table& shape = *node.as_table(); shape.contains("file"))
        for (const char* source : {"file", "count"}) shape.erase(source);
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    const auto name_whole = [&](const char* table, const std::string& file) {
      if (file.empty()) return;
      root["groups"][g][table].as_table()->insert_or_assign(
          "file", std::filesystem::absolute(file).lexically_normal().string());
    };
    name_whole("volume", group.volume.file);
    name_whole("packing", group.packing.file);
  }
  return toml_text(root);
}

}  // namespace spall
