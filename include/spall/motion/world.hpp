// All that a step changes: bodies, their neighbours, gravity's pending kick, and the energy ledger.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/base/comm.hpp"
#include "spall/base/timer.hpp"
#include "spall/contact/neighbours.hpp"
#include "spall/force/gravity.hpp"
#include "spall/force/near_pairs.hpp"
#include "spall/force/pair_potential.hpp"
#include "spall/force/pair_sweep.hpp"
#include "spall/force/penalty.hpp"
#include "spall/force/touch_pairs.hpp"
#include "spall/force/walls.hpp"
#include "spall/scene/bodies.hpp"
#include "spall/scene/case.hpp"

namespace spall {

/// Gravity acts in kicks at the instants when its field is evaluated (leapfrog; r-RESPA where
/// contact steps are shorter than the interval between kicks).
struct GravityKick {
  bool evaluated = false;      ///< the field is that of the present positions
  int steps_left = 0;          ///< until the next kick
  double interval = 0;         ///< s, from the last kick to the next
  double closed = 0;           ///< s, the interval that ended with the last kick
  double load = 0;             ///< s, of the kick that the coming step's contacts carry; 0: none
  double remembered_load = 0;  ///< s, of the kick that the pairs' impulses carried
  double largest = 0;          ///< m/s^2, largest acceleration of a body
  double fall = 0;             ///< s, in which no body falls further than a kick may carry it
  double hold = 0;             ///< s, that the present field may be held
  bool may_hold = true;  ///< `fall` spans two steps: the next evaluation bounds its change too
  double potential = 0;  ///< J over all ranks, at the last evaluation; uniform field too
  std::int64_t evaluations = 0;
};

/// Energy that went somewhere since the start, J; sums over this rank's part.
struct Ledger {
  double dissipated = 0;     ///< by contacts and dashpots, less the work of heat's pressure
  double cohesion_work = 0;  ///< by cohesion on the bodies
  double corrections = 0;  ///< gained by the bodies, height included, as overlaps were taken apart
};

struct World {
  Comm comm;
  std::vector<Plane> planes;
  std::vector<Cylinder> cylinders;
  Period period;
  ContactLaw law;
  GravitySettings gravity;
  Vec3 uniform_gravity = Vec3::Zero();
  Bodies bodies;
  Neighbours neighbours;
  PairPotential potential;
  NearPairs near;
  std::vector<PairRow> rows;     ///< of the bodies, while steps of the pair potential go on
  std::vector<double> crowding;  ///< of the bodies, where the potential has an embedding part
  Pushes pushes;                 ///< of the bodies, at the same time
  PenaltySettings penalty;
  TouchPairs touch;
  std::vector<ForceRow> loads;  ///< of the bodies, while steps of penalty contact go on
  std::vector<Vec3> ahead;      ///< m/s, velocities expected in the middle of the next kick
  GravityKick kick;
  Ledger ledger;
  StageTimes times;

  Walls walls() const { return {planes, cylinders}; }

  bool has_gravity() const {
    return gravity.method != GravityMethod::none || !uniform_gravity.isZero(0);
  }

  /// f(name, value) for what must go on after a restart beside bodies and contacts.
  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    auto& kick = self.kick;
    f("kick.evaluated", kick.evaluated);
    f("kick.steps_left", kick.steps_left);
    f("kick.evaluations", kick.evaluations);
    f("kick.interval", kick.interval);
    f("kick.closed", kick.closed);
    f("kick.remembered_load", kick.remembered_load);
    f("kick.largest", kick.largest);
    f("kick.fall", kick.fall);
    f("kick.hold", kick.hold);
    f("kick.may_hold", kick.may_hold);
    f("kick.potential", kick.potential);
    auto& ledger = self.ledger;
    f("ledger.dissipated", ledger.dissipated);
    f("ledger.cohesion_work", ledger.cohesion_work);
    f("ledger.corrections", ledger.corrections);
    f("law.cohesion", self.law.cohesion);
    for (auto& [stage, seconds] : self.times) f("seconds." + stage, seconds);
  }
};

/// A world with a case's laws and no bodies yet.
inline World make_world(const Comm& comm, const Case& scene) {
  World world;
  world.comm = comm;
  world.planes = scene.planes;
  world.cylinders = scene.cylinders;
  world.period = scene.period;
  world.law = scene.contact;
  world.potential = scene.potential.value_or(PairPotential{});
  world.penalty = scene.penalty.value_or(PenaltySettings{});
  world.gravity = scene.gravity;
  world.uniform_gravity = scene.uniform_gravity;
  return world;
}

}  // namespace spall
