// What laws ask of the groups of a case.
// SPDX-License-Identifier: BSD-3-Clause
#include "engine/type.hpp"

#include "spall/error.hpp"

namespace spall {

void check_images(const Surroundings& around, const std::string& place) {
  require(!around.period.any() || around.gravity.method == GravityMethod::none,
          "{}: [periodic] needs gravity.method = \"none\": images do not attract", place);
}

Lattice shared_lattice(const Surroundings& around, std::span<const MaterialUse> uses, int material,
                       const std::string& place) {
  const MaterialUse* first = nullptr;
  for (const MaterialUse& use : uses) {
    if (use.material != material || use.lattice.neighbours == 0) continue;
    if (!first) first = &use;
    require(use.lattice.neighbours == first->lattice.neighbours &&
                use.lattice.distance == first->lattice.distance,
            "{}: the lattice is not that of groups.{}, which is of the same material; a law that "
            "follows from the material needs one lattice",
            use.place, first->group);
  }
  require(first, "{} = \"{}\": no group of it is a lattice, from which the law follows", place,
          around.materials[material].name);
  return first->lattice;
}

}  // namespace spall
