// The flow of an impact, handed over to the bodies that lie where it launches matter.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "scene/case.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// What crossed, and whether it closes. Speeds are relative to the target's before the impact.
struct HandOver {
  double a = 0, delta = 0;  ///< m, kg/m^3, of the impactor
  double hand_over = 0;     ///< m
  /// Launched within `hand_over`, by the formulas. Its momentum leaves with the impactor's body,
  /// against the flight; its mass stays with the bodies.
  double inner_mass = 0, inner_momentum = 0, inner_energy = 0;  ///< kg, kg m/s (along), J
  /// Launched beyond it, by the formulas, up to the last body or the end of the flow.
  double outer_mass = 0, outer_momentum = 0, outer_energy = 0;  ///< kg, kg m/s (sum of sizes), J
  double found_mass = 0;                                        ///< kg, of bodies in its way
  double given_momentum = 0;  ///< kg m/s, that these got against the flight
  double reach = 0;           ///< m, the end of the flow, or the last body
  double count = 0;           ///< bodies that got some
  double energy = 0;          ///< J, brought by the impactor
  double flow_energy = 0;  ///< J, kinetic energy that the target's bodies gained, recoil included
  /// J, that of the impactor's body afterwards: of the inner momentum in its mass alone, which says
  /// nothing of what was launched within; that is inner_energy.
  double carrier_energy = 0;
  double heat = 0;  ///< J, energy - flow_energy - carrier_energy: no body has it
  /// Of the impactor's m U, and of m U times the reach: what the recoil left open.
  double momentum_closure = 0, angular_closure = 0;

  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    f("hand_over.a", self.a);
    f("hand_over.delta", self.delta);
    f("hand_over.hand_over", self.hand_over);
    f("hand_over.inner_mass", self.inner_mass);
    f("hand_over.inner_momentum", self.inner_momentum);
    f("hand_over.inner_energy", self.inner_energy);
    f("hand_over.outer_mass", self.outer_mass);
    f("hand_over.outer_momentum", self.outer_momentum);
    f("hand_over.outer_energy", self.outer_energy);
    f("hand_over.found_mass", self.found_mass);
    f("hand_over.given_momentum", self.given_momentum);
    f("hand_over.reach", self.reach);
    f("hand_over.count", self.count);
    f("hand_over.energy", self.energy);
    f("hand_over.flow_energy", self.flow_energy);
    f("hand_over.carrier_energy", self.carrier_energy);
    f("hand_over.heat", self.heat);
    f("hand_over.momentum_closure", self.momentum_closure);
    f("hand_over.angular_closure", self.angular_closure);
  }
};

/// Replaces the hit of `impactor`, whose body `id` is on its line of flight already.
///
/// A half-space launches the column 3 k rho x / (2 pi) of its mass at the distance x from the site
/// with the speed v(x). Rays along the flight find whose mass that is: the outermost bodies, until
/// their mass makes up the column. Each body gets the momentum of what it has there, so the
/// momentum does not depend on its size: a body that is launched in part flies more slowly. What
/// is launched within the hand-over is smaller than bodies; its momentum is given to the
/// impactor's body, which flies back with it. All other mass of the target recoils as a rigid body,
/// so that momentum and angular momentum stay what they were with the impactor. The target is what
/// hangs together with the first body in the way: by chains of gaps, each narrower than the mean of
/// both radii. Other bodies get nothing.
///
/// Bodies hold no ghosts. The same bits of the launches on any number of ranks; the recoil's to
/// round-off. Throws Error, with the impactor's place, where no body lies in the way of the flow.
/// Collective.
HandOver hand_over_flow(const Comm& comm, const Impactor& impactor, BodyId id, Bodies& bodies);

}  // namespace spall
