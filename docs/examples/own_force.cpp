// A force of a program that uses Spall: a callback on arrays. Compiled by the tests.
// SPDX-License-Identifier: BSD-3-Clause
#include <spall/spall.hpp>

namespace spall {

/// A uniform field of light pressure (Pa, along x) on the cross-section of each body.
void add_light_pressure(Simulation& simulation, double pressure) {
  simulation.add_force([pressure](const Bodies& bodies, std::span<Vec3> force) {
    for (Index b = 0; b < bodies.owned; ++b)
      force[b].x() += pressure * pi * bodies.radius[b] * bodies.radius[b];
  });
}

}  // namespace spall
