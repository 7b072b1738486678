// What happens where two bodies meet: of non-smooth and of penalty contact alike.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "state/by_pair.hpp"
#include "state/material.hpp"

namespace spall {

/// What a case's cohesion is: a force (N), or N s in each step, as the reference engine reads it.
enum class CohesionLaw : std::uint8_t { force, impulse };

/// What happens where two bodies meet.
struct ContactLaw {
  double friction = 0;
  double restitution = 0;
  double cohesion = 0;        ///< N, attractive, on every pair with gap <= cohesion_range
  double cohesion_range = 0;  ///< m
  bool own_cohesion = false;  ///< an exception that events do not change
  CohesionLaw cohesion_law = CohesionLaw::force;
};

/// How rigid spheres hold together like the solid.
struct Cohesion {
  double force = 0;     ///< N: tensile strength = phi Z F / (pi d^2), phi = (pi/6) / cell
  double range = 0;     ///< m: the stretch at which the elastic solid bears its tensile strength
  double friction = 0;  ///< shear over tensile strength: yield/sqrt(3) (von Mises) over tensile
};
Cohesion cohesion_of(const Solid& solid, const Lattice& lattice, const std::string& place);

/// Whether bodies of some materials rub.
template <class Law>
bool has_friction(const ByPair<Law>& laws) {
  return laws.any([](const Law& law) { return law.friction > 0; });
}
/// Whether bodies of some materials hold together.
template <class Law>
bool has_cohesion(const ByPair<Law>& laws) {
  return laws.any([](const Law& law) { return law.cohesion > 0; });
}
/// Another cohesion (N) for all pairs that have the default's.
void set_cohesion(ByPair<ContactLaw>& laws, double cohesion);

}  // namespace spall
