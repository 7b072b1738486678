// Asks each phase's engine about a copy of the world, so that nothing moves.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/later_steps.hpp"

#include <algorithm>

#include "engine/type.hpp"
#include "scene/impactor.hpp"

namespace spall {

void check_later_steps(const World& world, const Case& scene, const Clock& clock) {
  const auto next = static_cast<std::size_t>(clock.phase) + 1;
  if (next >= scene.phases.size()) return;
  World later = world;
  Bodies& bodies = later.bodies;
  resize(bodies, bodies.owned);
  later.time = clock.time - clock.time_in_phase;
  for (std::size_t p = next; p < scene.phases.size(); ++p) {
    const Phase &one = scene.phases[p], &former = scene.phases[p - 1];
    later.time += former.lasts();
    if (former.until == PhaseEnd::settled) later.motions.clear();  // it may end sooner
    std::ranges::fill(bodies.velocity, Vec3::Zero());
    if (one.cohesion) set_cohesion(later.contact, *one.cohesion);
    // Bodies may lie elsewhere then: an impactor that would miss them now may hit, and one that
    // would begin in a wall may not.
    if (one.impactor && would_hit(later.comm, *one.impactor, bodies, scene.shapes))
      place_impactor(later.comm, scene, *one.impactor, bodies);
    one.engine->make(one.settings)
        ->check_steps(later, {.h = one.step, .lasts = one.duration, .place = one.place});
  }
}

}  // namespace spall
