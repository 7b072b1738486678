// Names become places once all materials are known, that of the impactor included.
// SPDX-License-Identifier: BSD-3-Clause
#include "engine/between.hpp"

#include <algorithm>

namespace spall {

int find_material(const std::vector<Material>& materials, const std::string& name,
                  const std::string& place) {
  const auto found = std::ranges::find(materials, name, &Material::name);
  require(found != materials.end(), "{}: \"{}\" is not in [materials]", place, name);
  return static_cast<int>(found - materials.begin());
}

std::array<int, 2> NamedPair::find(const std::vector<Material>& materials) const {
  return {find_material(materials, names[0], place), find_material(materials, names[1], place)};
}

}  // namespace spall
