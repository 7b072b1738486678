// Solids with a stress a body, as an engine.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "engine/smooth.hpp"
#include "engine/type.hpp"
#include "pairs/flight.hpp"
#include "pairs/near_pairs.hpp"
#include "solid/contacts.hpp"
#include "solid/law.hpp"
#include "solid/rows.hpp"
#include "solid/sweep.hpp"

namespace spall {

struct SolidSettings {
  bool elastic = false;        ///< nothing yields or tears
  double courant = 0;          ///< as in `Elastoplastic`
  std::vector<SolidLaw> laws;  ///< by material, once derived; without density: it is no solid
};

/// So many inner lists of pairs follow each other until the skin of a search is used up.
inline constexpr double inner_lists = 5;

/// Which bodies act in each part of a step, and which once a stride of several parts. Owned bodies
/// that do not rest; lists rise.
struct Strides {
  double lasts = 0;        ///< s, from one time that all act to the next; 0: none is slow
  double least_limit = 0;  ///< s, of a part, below which all act before
  int parts_to_look = 0;   ///< before it is judged again whether a stride pays, where none is slow
  std::vector<std::uint8_t> is_slow;  ///< ghosts included
  std::vector<Index> brisk, slow;
  PiecePairs brisk_pairs;          ///< those with a brisk body, where any is slow
  std::vector<RowHalf> from;       ///< m, where bodies were when all acted last
  RowBox slow_box;                 ///< m/s, holds the velocities of slow bodies
  bool long_kicks = false;         ///< all act now, and some for a stride
  std::vector<Vec3> kick_by_slow;  ///< m/s, of brisk bodies: what they got more when all acted last
  double work = 1;                 ///< a part, of one in which all act
  double served = 0;               ///< the work since pairs were found
  bool cut_waits = false;  ///< they were found within a stride, where bodies change no ranks
};

struct Elastoplastic final : Engine {
  std::vector<SolidLaw> laws;  ///< by material
  /// 0: steps are as they are asked for. Else each is parted, as in `longest_step`, by the spacing
  /// and the speed of sound of compressed bodies and by the speeds of neighbours, step by step.
  double courant = 0;
  double next_part = 0;    ///< s, that the last step leaves to the next; 0: not known
  std::int64_t parts = 0;  ///< steps made with their forces, since it was made
  std::int64_t acts = 0;   ///< bodies of this rank that acted in them
  NearPairs near;
  PiecePairs pairs;        ///< those of one piece
  SolidContacts contacts;  ///< of the pairs
  /// By group: at rest without stress, and near no other when pairs were found. Its bodies are in
  /// no pairs, and do not act until pairs are found again.
  std::vector<std::uint8_t> rests;
  std::vector<double> rest_volume;  ///< m^3, of the bodies, ghosts included; as all below
  std::vector<double> reach;        ///< m, up to which a body sees others of its piece
  std::vector<MotionRow> rows;
  std::vector<ShapeRow> shapes;
  std::vector<ResponseRow> responses;
  std::vector<PushRow> impulses;
  std::vector<double> waves;  ///< 1/s, of owned bodies: the share of a spacing that sound crosses
  Strides strides;
  double fastest_pair2 = 0;  ///< 1/s^2, of neighbours of one piece, as `sweep_shapes` found it last

  explicit Elastoplastic(std::vector<SolidLaw> of_materials, double of_spacing = 0)
      : laws(std::move(of_materials)), courant(of_spacing) {}

  void check_steps(const World& world, const PlannedSteps& steps) const override;
  StepReport advance(World& world, const StepRequest& request) override;
  double energy(const World& world) const override;
  PairMemory remember(const World&) const override { return {}; }
  void restart_pairs(World& world, PairMemory memory) override;
  LinkedBodies links(const World& world) const override;
};

/// Of a spacing: what sound and bodies that meet cross in a step at most.
inline constexpr double usual_courant = 0.2;

/// s, of steps of bodies of this spacing d (m) that meet at up to `speed` V (m/s):
/// courant d/(c + 4 s V), with the slope s of the shock speed.
double longest_step(const SolidLaw& law, double spacing, double speed,
                    double courant = usual_courant);

extern const EngineType solid_engine;

}  // namespace spall
