// All that a step changes whatever its engine: bodies, gravity's pending kick, the energy ledger.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/timer.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "state/body_shape.hpp"
#include "state/by_pair.hpp"
#include "state/contact_law.hpp"
#include "state/cut.hpp"
#include "state/gravity.hpp"
#include "state/material.hpp"
#include "state/period.hpp"
#include "state/prescribed_motion.hpp"
#include "state/reaction.hpp"
#include "state/walls.hpp"

namespace spall {

/// What bodies are made of and what is around them: given by the case, the same for all engines.
struct Surroundings {
  std::uint64_t seed = 1;  ///< of all that is drawn
  std::vector<Material> materials;
  BodyShapes shapes;  ///< empty: all bodies are spheres
  ByPair<ContactLaw> contact;
  std::vector<Plane> planes;
  std::vector<Cylinder> cylinders;
  Period period;
  Cut cut = Cut::bisection;
  GravitySettings gravity;
  Vec3 uniform_gravity = Vec3::Zero();  ///< m/s^2
  /// By group; empty where no group moves as prescribed.
  std::vector<std::optional<PrescribedMotion>> motions;

  Walls walls() const { return {planes, cylinders}; }
  /// m/s^2, where bodies do not attract each other: the uniform field, which smooth forces carry in
  /// each of their own kicks.
  Vec3 steady_gravity() const {
    return gravity.method == GravityMethod::none ? uniform_gravity : Vec3::Zero();
  }
  bool has_gravity() const {
    return gravity.method != GravityMethod::none || !uniform_gravity.isZero(0);
  }
  /// Gravity turns bodies, too.
  bool has_near_clumps() const {
    return gravity.method != GravityMethod::none && gravity.near_clumps > 0 && !shapes.empty();
  }
};

/// Energy that went somewhere since the start, J; sums over this rank's part.
struct Ledger {
  double dissipated = 0;     ///< by contacts and dashpots, less the work of heat's pressure
  double cohesion_work = 0;  ///< by cohesion on the bodies
  double corrections = 0;  ///< gained by the bodies, height included, as overlaps were taken apart
  double own_work = 0;     ///< by forces of the program that uses Spall
  double fallen = 0;  ///< height in the uniform field, m g z, that bodies regained as they were set
                      ///< back into a period: they are deeper than their places say
  double prescribed_work = 0;  ///< by bodies that move as prescribed, on the others
  double gained = 0;  ///< by the bodies in steps whose hits gave energy; less in `dissipated`
};

/// Forces of a program: adds to the force (N) on each owned body, row by row.
using OwnForce = std::function<void(const Bodies&, std::span<Vec3> force)>;

struct World : Surroundings {
  Comm comm;
  Bodies bodies;
  double time = 0;  ///< s since the start, of the positions: what prescribed motions go by
  GravityKick kick;
  Ledger ledger;
  Reactions reactions;
  StageUses stages;
  std::vector<OwnForce> own_forces;

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
    f("kick.remembered_scale", kick.remembered_scale);
    f("kick.largest", kick.largest);
    f("kick.fall", kick.fall);
    f("kick.hold", kick.hold);
    f("kick.may_hold", kick.may_hold);
    f("kick.potential", kick.potential);
    auto& ledger = self.ledger;
    f("ledger.dissipated", ledger.dissipated);
    f("ledger.cohesion_work", ledger.cohesion_work);
    f("ledger.corrections", ledger.corrections);
    f("ledger.own_work", ledger.own_work);
    f("ledger.fallen", ledger.fallen);
    f("ledger.prescribed_work", ledger.prescribed_work);
    f("ledger.gained", ledger.gained);
    for_each_reaction(self.reactions.of_walls, "reaction.wall.", f);
    for_each_reaction(self.reactions.of_groups, "reaction.group.", f);
    for (auto& [stage, use] : self.stages) f("seconds." + stage, use.seconds);
  }

 private:
  template <class All, class F>
  static void for_each_reaction(All& all, const std::string& name, F&& f) {
    for (std::size_t n = 0; n < all.size(); ++n)
      for (int k = 0; k < 3; ++k) {
        const std::string component = name + std::to_string(n) + "." + "xyz"[k];
        f(component + ".impulse", all[n].impulse[k]);
        f(component + ".moment", all[n].moment[k]);
      }
  }
};

}  // namespace spall
