// Non-smooth contact as an engine: rigid spheres with impacts, friction and cohesion.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "engine/type.hpp"
#include "pairs/neighbours.hpp"
#include "solver/settings.hpp"

namespace spall {

struct Rigid final : Engine {
  SolverSettings solver;
  Neighbours neighbours;

  explicit Rigid(const SolverSettings& settings = {}) : solver(settings) {}

  void check_steps(const World&, const PlannedSteps&) const override {}
  StepReport advance(World& world, const StepRequest& request) override;
  /// Contacts carry their share, so what rests stays at rest.
  SolverReport close_kick(World& world, double h) override;
  double energy(const World& world) const override;
  PairMemory remember(const World& world) const override;
  void restart_pairs(World& world, PairMemory memory) override;
  LinkedBodies links(const World& world) const override;
  std::optional<FoundPairs> found_pairs(const World& world) const override;
};

extern const EngineType rigid_engine;

}  // namespace spall
