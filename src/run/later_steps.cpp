// Asks each phase's engine about a copy of the world, so that nothing moves.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/later_steps.hpp"

#include <algorithm>

#include "engine/type.hpp"
#include "scene/impactor.hpp"

namespace spall {

void check_later_steps(const World& world, const Case& scene, std::size_t phase) {
  if (phase + 1 >= scene.phases.size()) return;
  World later = world;
  Bodies& bodies = later.bodies;
  resize(bodies, bodies.owned);
  for (std::size_t p = phase + 1; p < scene.phases.size(); ++p) {
    const Phase& one = scene.phases[p];
    std::ranges::fill(bodies.velocity, Vec3::Zero());
    if (one.cohesion) set_cohesion(later.contact, *one.cohesion);
    // Bodies may lie elsewhere then: an impactor that would miss them now may hit.
    if (one.impactor && would_hit(later.comm, *one.impactor, bodies))
      add_impactor(later.comm, scene, *one.impactor, bodies);
    one.engine->make(one.settings)->check_step(later, one.step, one.place);
  }
}

}  // namespace spall
