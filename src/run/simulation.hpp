// What runs and tests know of a simulation beside what programs do.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "analysis/deflection.hpp"
#include "engine/engine.hpp"
#include "output/restart.hpp"
#include "run/account.hpp"
#include "scene/case.hpp"
#include "scene/hand_over.hpp"
#include "scene/impactor.hpp"
#include "spall/simulation.hpp"

namespace spall {

/// What changed the bodies at the start of a phase.
struct PhaseEvents {
  SolverReport closing{.converged = true};  ///< of contacts at the former phase's last instant
  std::optional<Aim> aim;                   ///< of the impactor, where one was added
  BeforeImpact before;                      ///< as it flies at the target
  std::optional<HandOver> flow;             ///< where its flow was handed to the bodies
  /// J, that pairs hold by a new method beyond what they held by the former: bodies that overlap as
  /// that one bears them are pushed apart. And over what moves, was held or dissipated.
  double pushed = 0, pushed_share = 0;
};

}  // namespace spall
