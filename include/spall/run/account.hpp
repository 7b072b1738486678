// What a run must account for: where energy went, and what momenta the free system must have.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "spall/output/diagnostics.hpp"

namespace spall {

/// One line of the books, at an instant when positions and velocities are synchronous.
struct Balance {
  Diagnostics sums;
  double gravitational = 0;           ///< J, self-gravity and uniform field
  double bonds = 0;                   ///< J, <= 0
  double unexplained_energy = 0;      ///< J: what no entry explains
  double momentum_drift = 0;          ///< kg m/s, against what the events gave
  double angular_momentum_drift = 0;  ///< kg m^2/s
};

/// Events (an impactor, another cohesion) change the sums from outside; the books follow.
class Account {
 public:
  /// Sums before and after an event that changed the bodies, gravity evaluated both times.
  void book_event(const Diagnostics& before, double potential_before, const Diagnostics& after,
                  double potential_after);
  /// Cohesion goes from `before` to `after` (N) on bonds with that sum of (range - gap).
  void book_cohesion(double before, double after, double bonds);

  Balance balance(const Diagnostics& sums, double gravitational, double bonds);

  void save(std::map<std::string, double>& scalars) const;
  void load(const std::map<std::string, double>& scalars);

  double largest_momentum_drift() const { return momentum_drift_; }
  double largest_angular_momentum_drift() const { return angular_momentum_drift_; }

 private:
  template <class Self, class F>
  static void for_each(Self& self, F&& f);

  double opened_ = 0;   // 1 when the first balance has set what follows
  double initial_ = 0;  // J, energy at the start
  double given_ = 0;    // J, by events
  Vec3 momentum_ = Vec3::Zero(), angular_momentum_ = Vec3::Zero();  // that the bodies must have
  double momentum_drift_ = 0, angular_momentum_drift_ = 0;          // largest so far
};

}  // namespace spall
