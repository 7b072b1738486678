// What follows from the constants of a solid.
// SPDX-License-Identifier: BSD-3-Clause
#include "state/material.hpp"

#include <algorithm>

namespace spall {

double temperature(const Solid& solid, double heat) {
  const double c = solid.specific_heat, T = room_temperature + heat / c;
  if (solid.melting_point == 0 || T < solid.melting_point) return T;
  const double warming = c * (solid.melting_point - room_temperature);  // all, where none is told
  const double melting = std::max(solid.melt_energy, warming);
  return solid.melting_point + std::max(0.0, heat - melting) / c;
}

double sphere_mass(const Solid& solid, const Lattice& lattice) {
  return solid.bulk_density() * lattice.volume();
}

std::string pair_name(const std::vector<Material>& materials, int a, int b) {
  return materials[a].name + " and " + materials[b].name;
}

}  // namespace spall
