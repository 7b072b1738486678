// Gravity of a world: what is asked for, and where its kicks are in time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/types.hpp"

namespace spall {

enum class GravityMethod { none, direct, tree, automatic };

struct GravitySettings {
  GravityMethod method = GravityMethod::none;
  double constant = 6.67430e-11;  ///< m^3/(kg s^2), CODATA 2018
  double accuracy = 1e-4;         ///< rms relative force error asked of the tree
  double refresh = 1e-2;  ///< the field is held until a force may have changed by this, relative to
                          ///< the rms force
  double near_clumps = 2;  ///< sums of the radii, up to which clumps attract by their parts; 0: not
};

/// Gravity acts in kicks at the instants when its field is evaluated (leapfrog; r-RESPA where
/// contact steps are shorter than the interval between kicks).
struct GravityKick {
  bool evaluated = false;       ///< the field is that of the present positions
  int steps_left = 0;           ///< until the next kick
  double interval = 0;          ///< s, from the last kick to the next
  double closed = 0;            ///< s, the interval that ended with the last kick
  double load = 0;              ///< s, of the kick that the coming step's contacts carry; 0: none
  double remembered_load = 0;   ///< s, of the kick that the pairs' impulses carried
  double remembered_scale = 0;  ///< sqrt(J), of E then; 0 where something met
  double largest = 0;           ///< m/s^2, largest acceleration of a body
  double fall = 0;              ///< s, in which no body falls further than a kick may carry it
  double hold = 0;              ///< s, that the present field may be held
  bool may_hold = true;  ///< `fall` spans two steps: the next evaluation bounds its change too
  double potential = 0;  ///< J over all ranks, at the last evaluation; uniform field too
  std::int64_t evaluations = 0;
};

}  // namespace spall
