// Energy: kinetic + potentials + dissipated - given stays what it was; the rest is unexplained.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/run/account.hpp"

#include <algorithm>

#include "spall/base/require.hpp"

namespace spall {

void Account::book_event(const Diagnostics& before, double potential_before,
                         const Diagnostics& after, double potential_after) {
  given_ += after.kinetic + potential_after - before.kinetic - potential_before;
  momentum_ += after.momentum - before.momentum;
  angular_momentum_ += after.angular_momentum - before.angular_momentum;
}

void Account::book_cohesion(double before, double after, double bonds) {
  given_ -= (after - before) * bonds;
}

Balance Account::balance(const Diagnostics& sums, double gravitational, double bonds) {
  Balance result{.sums = sums, .gravitational = gravitational, .bonds = bonds};
  const double energy =
      sums.kinetic + gravitational + bonds + sums.dissipated - sums.corrections - given_;
  if (opened_ == 0) {
    opened_ = 1;
    initial_ = energy;
    momentum_ = sums.momentum;
    angular_momentum_ = sums.angular_momentum;
  }
  result.unexplained_energy = energy - initial_;
  result.momentum_drift = (sums.momentum - momentum_).norm();
  result.angular_momentum_drift = (sums.angular_momentum - angular_momentum_).norm();
  momentum_drift_ = std::max(momentum_drift_, result.momentum_drift);
  angular_momentum_drift_ = std::max(angular_momentum_drift_, result.angular_momentum_drift);
  return result;
}

template <class Self, class F>
void Account::for_each(Self& self, F&& f) {
  f("account.opened", self.opened_);
  f("account.initial", self.initial_);
  f("account.given", self.given_);
  for (int k = 0; k < 3; ++k) {
    f("account.momentum." + std::to_string(k), self.momentum_[k]);
    f("account.angular_momentum." + std::to_string(k), self.angular_momentum_[k]);
  }
  f("account.momentum_drift", self.momentum_drift_);
  f("account.angular_momentum_drift", self.angular_momentum_drift_);
}

void Account::save(std::map<std::string, double>& scalars) const {
  for_each(*this, [&](const std::string& name, double value) { scalars[name] = value; });
}

void Account::load(const std::map<std::string, double>& scalars) {
  for_each(*this, [&](const std::string& name, double& value) {
    const auto found = scalars.find(name);
    require(found != scalars.end(), "the restart file has no '{}'", name);
    value = found->second;
  });
}

}  // namespace spall
