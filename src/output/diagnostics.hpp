// The sums that a run is judged by: momenta, energies, speeds over all bodies of all ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "state/world.hpp"

namespace spall {

/// Bodies of infinite mass count nowhere.
struct Diagnostics {
  double mass = 0;                             ///< kg
  Vec3 centre = Vec3::Zero();                  ///< m, of mass
  double gyration_radius = 0;                  ///< m, rms distance of the mass from its centre
  Vec3 momentum = Vec3::Zero();                ///< kg m/s
  Vec3 angular_momentum = Vec3::Zero();        ///< kg m^2/s, about the origin, spins included
  double momentum_scale = 0;                   ///< kg m/s, sum of m |v|
  double angular_momentum_scale = 0;           ///< kg m^2/s, sum of m |x| |v|
  double kinetic = 0;                          ///< J, translation and rotation
  double rms_speed = 0;                        ///< m/s, mass-weighted
  double dissipated = 0, corrections = 0;      ///< J, of the ledger
  double own_work = 0, fallen = 0;             ///< J, of the ledger
  double prescribed_work = 0, gained = 0;      ///< J, of the ledger
  double fall = 0;                             ///< J, by gravity in its last interval, from rest
  Vec3 given_momentum = Vec3::Zero();          ///< kg m/s, by walls and held bodies so far
  Vec3 given_angular_momentum = Vec3::Zero();  ///< kg m^2/s, about the origin
};

/// Collective.
Diagnostics diagnose(const World& world);

/// The first of this rank's bodies whose place, velocity or spin is no finite number; without one,
/// their count.
Index first_lost(const Bodies& bodies);
/// The smallest id of such bodies of all ranks; infinity without one. Collective.
double first_lost_id(const Comm& comm, const Bodies& bodies);

}  // namespace spall
