// From the constants of a solid to the cohesion and friction of rigid spheres.
// SPDX-License-Identifier: BSD-3-Clause
#include "state/contact_law.hpp"

#include <cmath>

#include "spall/error.hpp"

namespace spall {

Cohesion cohesion_of(const Solid& solid, const Lattice& lattice, const std::string& place) {
  require(solid.tensile_strength > 0 && solid.youngs_modulus > 0 && solid.yield_strength > 0,
          "{} needs the material's tensile_strength, yield_strength and youngs_modulus", place);
  const double d = lattice.distance, phi = pi / 6 / lattice.cell;
  return {.force = solid.tensile_strength * pi * d * d / (phi * lattice.neighbours),
          .range = d * solid.tensile_strength / solid.youngs_modulus,
          .friction = solid.yield_strength / (std::sqrt(3.0) * solid.tensile_strength)};
}

void set_cohesion(ByPair<ContactLaw>& laws, double cohesion) {
  laws.for_each([&](ContactLaw& law) {
    if (!law.own_cohesion) law.cohesion = cohesion;
  });
}

}  // namespace spall
