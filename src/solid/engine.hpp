// Solids with a stress a body, as an engine.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "engine/smooth.hpp"
#include "engine/type.hpp"
#include "pairs/near_pairs.hpp"
#include "solid/contacts.hpp"
#include "solid/law.hpp"
#include "solid/rows.hpp"
#include "solid/sweep.hpp"

namespace spall {

struct SolidSettings {
  bool elastic = false;        ///< nothing yields or tears
  std::vector<SolidLaw> laws;  ///< by material, once derived; of those that no body is of, none
};

struct Elastoplastic final : Engine {
  std::vector<SolidLaw> laws;  ///< by material
  NearPairs near;
  SamePiece same;                   ///< of the pairs
  SolidContacts contacts;           ///< of the pairs
  std::vector<double> rest_volume;  ///< m^3, of the bodies, ghosts included; as all below
  std::vector<double> reach;        ///< m, up to which a body sees others of its piece
  std::vector<MotionRow> rows;
  std::vector<ShapeRow> shapes;
  std::vector<ResponseRow> responses;
  std::vector<PushRow> forces;

  explicit Elastoplastic(std::vector<SolidLaw> of_materials) : laws(std::move(of_materials)) {}

  void check_steps(const World& world, const PlannedSteps& steps) const override;
  StepReport advance(World& world, const StepRequest& request) override;
  double energy(const World& world) const override;
  PairMemory remember(const World&) const override { return {}; }
  void restart_pairs(World& world, PairMemory memory) override;
  LinkedBodies links(const World& world) const override;
};

/// s, of steps of bodies of this spacing (m) that meet at up to `speed` (m/s).
double longest_step(const SolidLaw& law, double spacing, double speed);

extern const EngineType solid_engine;

}  // namespace spall
