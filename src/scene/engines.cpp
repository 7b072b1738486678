// One line an engine.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/engines.hpp"

#include <algorithm>
#include <array>

#include "penalty/engine.hpp"
#include "potential/engine.hpp"
#include "rigid/engine.hpp"
#include "solid/engine.hpp"

namespace spall {

std::span<const EngineType* const> all_engines() {
  static constexpr std::array engines{
      &rigid_engine,
      &potential_engine,
      &penalty_engine,
      &solid_engine,
  };
  return engines;
}

double bytes_a_body(const EngineType& engine, const Surroundings& around, double contacts) {
  struct Use {
    const EngineType* engine;
    double body, contact, contact_without_friction;  // bytes
  };
  // Peaks of dense packings of 10,000 to a million bodies on one and two ranks, ghosts included.
  // Contacts of springs and of potentials are lanes of their bodies' rows: touching costs nothing.
  static constexpr std::array uses{Use{&rigid_engine, 830, 360, 190},
                                   Use{&potential_engine, 800, 0, 0},
                                   Use{&penalty_engine, 900, 0, 0}, Use{&solid_engine, 2000, 0, 0}};
  const auto found = std::ranges::find(uses, &engine, &Use::engine);
  const Use& use = found == uses.end() ? uses.front() : *found;
  if (around.shapes.empty())
    return use.body +
           contacts * (has_friction(around.contact) ? use.contact : use.contact_without_friction);
  std::size_t most = 0;
  for (const BodyShape& shape : around.shapes) most = std::max(most, shape.spheres.size());
  if (&engine == &penalty_engine)  // a sphere of a clump is a row like a body
    return use.body * static_cast<double>(1 + most);
  // Counted from what a step keeps of a body, of each of its spheres, and of a contact with its
  // arms; three contacts a pair are many.
  constexpr double of_body = 420, of_sphere = 56, of_arms = 224, contacts_a_pair = 3;
  return use.body + of_body + of_sphere * static_cast<double>(most) +
         contacts_a_pair * contacts * (use.contact + of_arms);
}

}  // namespace spall
