// Energy: kinetic + potentials + dissipated - given stays what it was; the rest is unexplained.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/account.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace spall {

void Account::book_event(const Diagnostics& before, double potential_before,
                         const Diagnostics& after, double potential_after) {
  given_ += after.kinetic + potential_after - before.kinetic - potential_before;
  momentum_ += after.momentum - before.momentum;
  angular_momentum_ += after.angular_momentum - before.angular_momentum;
}

Balance Account::balance(const Diagnostics& sums, double potential, double bonds) {
  const double gravitational = potential - sums.fallen;
  Balance result{.sums = sums, .gravitational = gravitational, .bonds = bonds};
  const double energy = sums.kinetic + gravitational + bonds + sums.dissipated - sums.corrections -
                        sums.own_work - sums.prescribed_work - given_;
  const Vec3 momentum = sums.momentum - sums.given_momentum;
  const Vec3 angular_momentum = sums.angular_momentum - sums.given_angular_momentum;
  if (opened_ == 0) {
    opened_ = 1;
    initial_ = energy;
    momentum_ = momentum;
    angular_momentum_ = angular_momentum;
  }
  if (reopens_ == 1) initial_ = energy - unexplained_;
  reopens_ = 0;
  result.unexplained_energy = energy - initial_;
  result.momentum_drift = (momentum - momentum_).norm();
  result.angular_momentum_drift = (angular_momentum - angular_momentum_).norm();
  unexplained_ = result.unexplained_energy;
  momentum_scale_ = std::max(momentum_scale_, sums.momentum_scale);
  angular_scale_ = std::max(angular_scale_, sums.angular_momentum_scale);
  momentum_drift_ = std::max(momentum_drift_, result.momentum_drift);
  angular_momentum_drift_ = std::max(angular_momentum_drift_, result.angular_momentum_drift);
  return result;
}

void Account::add_drifts(ResultTable& table, double momentum,
                         std::optional<double> angular_momentum) const {
  // Where nothing ever moved there is nothing to drift.
  const auto relative = [](double drift, double unit, double scale) {
    if (unit > 0) return drift / unit;
    return scale > 0 ? drift / scale : 0;
  };
  table.add("conservation", "linear", relative(momentum_drift_, momentum, momentum_scale_), "",
            momentum > 0 ? "largest drift of momentum, of the impactor's"
                         : "largest drift of momentum, of the largest sum of m |v|");
  if (!angular_momentum) return;
  table.add("conservation", "angular",
            relative(angular_momentum_drift_, *angular_momentum, angular_scale_), "",
            *angular_momentum > 0
                ? "largest drift of angular momentum, of the impactor's on the pile's rim"
                : "largest drift of angular momentum, of the largest sum of m |x| |v|");
}

namespace {

/// What the energy that no entry explains is compared with.
struct Measure {
  double energy;  // J
  std::string_view name, reason;
};

Measure measure(const Diagnostics& sums) {
  // Where next to nothing is dissipated, of the kinetic energy, what is would make any error look
  // large, or none at all.
  constexpr double next_to_nothing = 1e-6;
  if (sums.fall > std::max(sums.kinetic, sums.dissipated))  // both are little but round-off
    return {sums.fall, "what gravity gives in a step", "bodies rest"};
  if (sums.dissipated > next_to_nothing * sums.kinetic)
    return {sums.dissipated, "what was dissipated", ""};
  return {sums.kinetic, "the kinetic energy",
          sums.dissipated < -next_to_nothing * sums.kinetic
              ? "energy was gained, dissipated is negative"
              : "next to nothing was dissipated"};
}

}  // namespace

double Account::open_share(const Diagnostics& sums) const {
  const double whole = measure(sums).energy;
  return whole > 0 ? unexplained_ / whole : 0;
}

std::string Account::warning(const Diagnostics& sums) const {
  constexpr double open = 0.05;  // the report's bound, too
  // What is lost of little that was dissipated says nothing about motion.
  constexpr double seen = 1e-3;
  const double share = open_share(sums);
  if (std::abs(share) <= open || std::abs(unexplained_) <= seen * std::max(sums.kinetic, sums.fall))
    return "";
  return fmt::format("{:.3g} J, {:.2g} of {}, {}: do not believe this run", std::abs(unexplained_),
                     std::abs(share), measure(sums).name,
                     unexplained_ > 0 ? "come out of nothing" : "are lost without an entry");
}

void Account::add_energies(ResultTable& table, const Diagnostics& sums, double potential) const {
  const Measure of = measure(sums);
  const bool other = !of.reason.empty() && of.energy > 0;
  table.add("conservation", "energy_unexplained", open_share(sums), "",
            fmt::format("energy that no entry explains, of {}",
                        other ? "energy_measure" : "what was dissipated"));
  if (other)
    table.add("conservation", "energy_measure", of.energy, "J",
              fmt::format("{}: {}", of.name, of.reason));
  if (const std::string told = warning(sums); !told.empty())
    table.add("conservation", "warning", told);
  table.add("conservation", "dissipated", sums.dissipated, "J");
  if (sums.gained > 0)
    table.add("conservation", "gained_by_restitution", sums.gained, "J",
              "in steps whose hits gave energy to clumps: restitution with friction may");
  if (sums.prescribed_work != 0)
    table.add("conservation", "prescribed_work", sums.prescribed_work, "J",
              "by groups that move as prescribed, on the others");
  table.add("conservation", "kinetic", sums.kinetic, "J");
  table.add("conservation", "gravitational", potential - sums.fallen, "J");
}

}  // namespace spall
