// Penalty contact as an engine: grains that touch by springs and dashpots.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "engine/smooth.hpp"
#include "engine/type.hpp"
#include "penalty/members.hpp"
#include "penalty/penalty.hpp"

namespace spall {

struct Penalty final : Engine {
  ByPair<PenaltySettings> settings;
  Splitting integrator = leapfrog;
  Members members;
  TouchPairs touch;             ///< of what meets: bodies, or members
  std::vector<ForceRow> loads;  ///< of what meets, while steps go on
  double overlap = 0;  ///< largest over the smaller radius, of the last steps, on this rank

  explicit Penalty(const ByPair<PenaltySettings>& of_case) : settings(of_case) {}

  void check_steps(const World& world, const PlannedSteps& steps) const override;
  StepReport advance(World& world, const StepRequest& request) override;
  double energy(const World& world) const override;
  PairMemory remember(const World& world) const override;
  Index ghosts(const World& world) const override;
  void restart_pairs(World& world, PairMemory memory) override;
  LinkedBodies links(const World& world) const override;
  std::optional<FoundPairs> found_pairs(const World& world) const override;
};

extern const EngineType penalty_engine;

}  // namespace spall
