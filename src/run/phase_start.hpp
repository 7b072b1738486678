// What happens at the start of a phase, with what it gives or takes booked.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "spall/motion/world.hpp"
#include "spall/run/account.hpp"
#include "spall/run/verdict.hpp"
#include "spall/scene/impactor.hpp"

namespace spall {

/// Removes the drift and adds the impactor, as the phase asks for; the verdict looks at the pile
/// before it comes. Returns its aim where there is one. Collective.
std::optional<Aim> change_bodies(World& world, const Case& scene, const Phase& phase,
                                 Account& account, Verdict& verdict);

/// The overlaps of a state become energy where phases of penalty contact begin, and are none any
/// more where they end; a change of cohesion gives or takes what the bonds hold. `cohesion_before`
/// (N) and `energy_before` (J, where that was penalty contact) belong to the former phase.
/// Collective.
void book_springs(World& world, Method method, Method former, double cohesion_before,
                  double energy_before, Account& account);

}  // namespace spall
