// Pair potentials as an engine: solids and fluids of bodies that act on many neighbours.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "engine/smooth.hpp"
#include "engine/type.hpp"
#include "pairs/near_pairs.hpp"
#include "potential/pair_potential.hpp"
#include "potential/sweep.hpp"
#include "potential/walls.hpp"

namespace spall {

struct Potential final : Engine {
  ByPair<PairPotential> law;
  Splitting integrator = leapfrog;
  NearPairs near;
  std::vector<AtWall> at_walls;  ///< bodies near walls, of the last search
  std::vector<PairRow> rows;     ///< of the bodies, while steps go on
  std::vector<double> crowding;  ///< of the bodies, where the law has an embedding part
  Pushes pushes;                 ///< of the bodies, at the same time
  std::vector<Vec3> ahead;       ///< m/s, velocities expected in the middle of the next kick

  explicit Potential(ByPair<PairPotential> of_pairs) : law(std::move(of_pairs)) {}

  void check_steps(const World& world, const PlannedSteps& steps) const override;
  StepReport advance(World& world, const StepRequest& request) override;
  double energy(const World& world) const override;
  PairMemory remember(const World& world) const override;
  void restart_pairs(World& world, PairMemory memory) override;
  void measure_fields(World& world) const override;
  LinkedBodies links(const World& world) const override;
  std::optional<FoundPairs> found_pairs(const World& world) const override;
};

/// "copper and steel", of two indices into the materials.
std::string names_of_pair(const Surroundings& around, int a, int b);

extern const EngineType potential_engine;

}  // namespace spall
