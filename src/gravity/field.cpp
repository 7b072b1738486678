// Checks what gravity cannot do, picks the method, and says how long a field may be held.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/field.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "gravity/direct.hpp"
#include "gravity/tree.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// How many bodies all ranks have, and whether any rank gives velocities. Throws on every rank if
/// any has rows that gravity cannot work with.
std::pair<std::int64_t, bool> require_sound(const Comm& comm, std::span<const double> mass,
                                            std::span<const Vec3> position,
                                            std::span<const Vec3> velocity) {
  const auto bad_masses =
      std::ranges::count_if(mass, [](double m) { return !(m >= 0 && std::isfinite(m)); });
  const auto bad_places =
      std::ranges::count_if(position, [](const Vec3& x) { return !x.allFinite(); });
  std::array<double, 6> sums{
      static_cast<double>(mass.size()), static_cast<double>(bad_masses),
      static_cast<double>(bad_places),  position.size() != mass.size() ? 1.0 : 0.0,
      velocity.empty() ? 0.0 : 1.0,     velocity.size() != mass.size() ? 1.0 : 0.0};
  comm.sum(sums);
  require(sums[1] == 0,
          "self-gravity needs finite masses, but {} bodies have an infinite or negative one: a "
          "body that never moves cannot take part; give it a mass or switch self-gravity off",
          sums[1]);
  require(sums[2] == 0, "self-gravity: {} bodies are at a place that is not finite", sums[2]);
  require(sums[3] == 0 && (sums[4] == 0 || sums[5] == 0),
          "self-gravity: numbers of masses, positions and velocities differ");
  return {static_cast<std::int64_t>(sums[0]), sums[4] > 0};
}

/// Bodies for which a tree costs as much as the exact sum, in which a body meets all others.
/// Measured from accuracies of 1e-2 to 1e-6 (bench/results/gravity.md).
double break_even(double accuracy) {
  return 2000 * std::pow(1e-3 / accuracy, 0.22);
}

}  // namespace

GravityMethod choose_gravity(const GravitySettings& settings, std::int64_t bodies) {
  if (settings.method != GravityMethod::automatic) return settings.method;
  return static_cast<double>(bodies) > 2 * break_even(settings.accuracy) ? GravityMethod::tree
                                                                         : GravityMethod::direct;
}

std::string describe_gravity(const GravitySettings& settings, std::int64_t bodies) {
  const std::string why = settings.method == GravityMethod::automatic ? " (automatic)" : "";
  switch (choose_gravity(settings, bodies)) {
    case GravityMethod::direct:
      return fmt::format("exact sum over the pairs of {} bodies{}", bodies, why);
    case GravityMethod::tree: {
      const TreeSettings tree = tree_settings(settings.accuracy);
      return fmt::format("tree of order {} over {} bodies, rms force error {:.0e}{}", tree.order,
                         bodies, settings.accuracy, why);
    }
    case GravityMethod::none:
    case GravityMethod::automatic:  // chosen above
      break;
  }
  return "none";
}

GravityField evaluate_gravity(const Comm& comm, const GravitySettings& settings,
                              std::span<const double> mass, std::span<const Vec3> position,
                              std::span<const Vec3> velocity) {
  if (settings.method == GravityMethod::none)
    return {std::vector<Vec3>(mass.size(), Vec3::Zero()), std::vector<double>(mass.size(), 0.0),
            std::vector<double>(velocity.size(), 0.0)};
  const auto [bodies, rates] = require_sound(comm, mass, position, velocity);
  if (choose_gravity(settings, bodies) == GravityMethod::direct)
    return evaluate_gravity_direct(comm, settings.constant, mass, position, velocity, rates);
  return evaluate_gravity_tree(comm, settings.constant, tree_settings(settings.accuracy), mass,
                               position, velocity);
}

GravityField evaluate_gravity_at(const Comm& comm, const GravitySettings& settings,
                                 std::span<const double> mass, std::span<const Vec3> position,
                                 std::span<const Vec3> places) {
  if (settings.method == GravityMethod::direct) {
    require_sound(comm, mass, position, {});
    return evaluate_gravity_direct_at(comm, settings.constant, mass, position, places);
  }
  // Massless bodies feel the others and are not felt.
  std::vector<double> all_mass(mass.begin(), mass.end());
  std::vector<Vec3> all_places(position.begin(), position.end());
  all_mass.resize(mass.size() + places.size(), 0.0);
  all_places.insert(all_places.end(), places.begin(), places.end());
  GravityField field = evaluate_gravity(comm, settings, all_mass, all_places, {});
  const auto first = static_cast<std::ptrdiff_t>(mass.size());
  field.acceleration.erase(field.acceleration.begin(), field.acceleration.begin() + first);
  field.potential.erase(field.potential.begin(), field.potential.begin() + first);
  return field;
}

ForceChange force_change(std::span<const double> mass, const GravityField& field) {
  ForceChange change;
  change.bodies = static_cast<double>(mass.size());
  for (std::size_t b = 0; b < mass.size(); ++b) {
    change.squares += mass[b] * mass[b] * field.acceleration[b].squaredNorm();
    change.fastest = std::max(change.fastest, mass[b] * field.rate[b]);
  }
  return change;
}

double holding_time(const GravitySettings& settings, const ForceChange& of_all) {
  if (of_all.squares == 0 || of_all.fastest == 0) return infinity;
  return settings.refresh * std::sqrt(of_all.squares / of_all.bodies) / of_all.fastest;
}

}  // namespace spall
