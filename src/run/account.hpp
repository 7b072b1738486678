// What a run must account for: where energy went, and what momenta the free system must have.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <optional>
#include <string>

#include "output/diagnostics.hpp"
#include "output/results.hpp"

namespace spall {

/// One line of the books, at an instant when positions and velocities are synchronous.
struct Balance {
  Diagnostics sums;
  double gravitational = 0;           ///< J, self-gravity and uniform field
  double bonds = 0;                   ///< J, <= 0
  double unexplained_energy = 0;      ///< J: what no entry explains
  double momentum_drift = 0;          ///< kg m/s, against what events, walls and held bodies gave
  double angular_momentum_drift = 0;  ///< kg m^2/s
};

/// Events (an impactor, another cohesion) change the sums from outside; the books follow.
class Account {
 public:
  /// Sums before and after an event that changed the bodies, gravity evaluated both times.
  void book_event(const Diagnostics& before, double potential_before, const Diagnostics& after,
                  double potential_after);
  /// An event gave this much (J).
  void book_energy(double given) { given_ += given; }

  /// The run goes on with other laws: what bodies hold by them now is none of their doing.
  void change_laws() { reopens_ = opened_; }

  /// `potential`: J, of gravity with bodies where they are.
  Balance balance(const Diagnostics& sums, double potential, double bonds);

  /// Drifts over these units (kg m/s, kg m^2/s), or where they are 0 over what the bodies carry.
  /// Angular momentum is left out where space repeats itself: there it has no centre.
  void add_drifts(ResultTable& table, double momentum,
                  std::optional<double> angular_momentum) const;
  void add_energies(ResultTable& table, const Diagnostics& sums, double potential) const;
  /// What a user must know where the account does not close; else empty.
  std::string warning(const Diagnostics& sums) const;

  /// What a restart file keeps.
  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    f("account.opened", self.opened_);
    f("account.reopens", self.reopens_);
    f("account.initial", self.initial_);
    f("account.given", self.given_);
    for (int k = 0; k < 3; ++k) {
      f(fmt::format("account.momentum.{}", k), self.momentum_[k]);
      f(fmt::format("account.angular_momentum.{}", k), self.angular_momentum_[k]);
    }
    f("account.momentum_drift", self.momentum_drift_);
    f("account.angular_momentum_drift", self.angular_momentum_drift_);
    f("account.momentum_scale", self.momentum_scale_);
    f("account.angular_momentum_scale", self.angular_scale_);
    f("account.unexplained", self.unexplained_);
  }

 private:
  /// Energy that no entry explains, of what was dissipated or, if that is next to nothing, of the
  /// kinetic energy.
  double open_share(const Diagnostics& sums) const;

  double opened_ = 0;   // 1 when the first balance has set what follows
  double reopens_ = 0;  // 1 when the next balance sets the energy at the start anew
  double initial_ = 0;  // J, energy at the start
  double given_ = 0;    // J, by events
  // What the bodies must have, but for what walls and held bodies gave.
  Vec3 momentum_ = Vec3::Zero(), angular_momentum_ = Vec3::Zero();
  double momentum_drift_ = 0, angular_momentum_drift_ = 0;  // largest so far
  double momentum_scale_ = 0, angular_scale_ = 0;  // largest sums of m |v|, m |x| |v| so far
  double unexplained_ = 0;                         // J, at the last balance
};

}  // namespace spall
