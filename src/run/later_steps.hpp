// Steps of phases to come: refused before the first phase is paid for.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "output/restart.hpp"
#include "scene/case.hpp"
#include "state/world.hpp"

namespace spall {

/// Throws Error, as the start of a phase does, where the step of a phase behind that of `clock` is
/// too long for these bodies. How they will move then is not known: they are taken to be at rest,
/// only an impactor comes with its speed, and moving groups with theirs where it is known when the
/// phase begins. So what is refused here is refused later in any case. Collective.
void check_later_steps(const World& world, const Case& scene, const Clock& clock);

}  // namespace spall
