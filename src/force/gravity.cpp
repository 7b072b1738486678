// Checks what gravity cannot do, picks the method, and says how long a field may be held.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/gravity.hpp"

#include <algorithm>
#include <cmath>

#include "spall/base/require.hpp"
#include "spall/force/gravity_direct.hpp"

namespace spall {
namespace {

/// Throws on every rank if any rank has a mass or place that gravity cannot work with.
void require_finite(const Comm& comm, std::span<const double> mass,
                    std::span<const Vec3> position) {
  std::int64_t bad_masses = 0, bad_places = 0;
  for (double m : mass) bad_masses += !(m >= 0 && std::isfinite(m));
  for (const Vec3& x : position) bad_places += !x.allFinite();
  bad_masses = comm.sum(bad_masses);
  bad_places = comm.sum(bad_places);
  require(bad_masses == 0,
          "self-gravity needs finite masses, but {} bodies have an infinite or negative one: a "
          "fixed body cannot attract others; switch gravity off or give it a mass",
          bad_masses);
  require(bad_places == 0, "self-gravity: {} bodies are at a place that is not finite", bad_places);
}

}  // namespace

GravityField evaluate_gravity(const Comm& comm, const GravitySettings& settings,
                              std::span<const double> mass, std::span<const Vec3> position,
                              std::span<const Vec3> velocity) {
  if (settings.method == GravityMethod::none)
    return {std::vector<Vec3>(mass.size(), Vec3::Zero()), std::vector<double>(mass.size(), 0.0),
            std::vector<double>(mass.size(), 0.0)};
  require_finite(comm, mass, position);
  return evaluate_gravity_direct(comm, settings.constant, mass, position, velocity);
}

double holding_time(const Comm& comm, const GravitySettings& settings, std::span<const double> mass,
                    const GravityField& field) {
  double squares = 0, fastest_change = 0;  // N^2, N/s
  for (std::size_t b = 0; b < mass.size(); ++b) {
    squares += mass[b] * mass[b] * field.acceleration[b].squaredNorm();
    fastest_change = std::max(fastest_change, mass[b] * field.rate[b]);
  }
  squares = comm.sum(squares);
  fastest_change = comm.max(fastest_change);
  const auto count = comm.sum(static_cast<std::int64_t>(mass.size()));
  if (squares == 0 || fastest_change == 0) return infinity;
  return settings.refresh * std::sqrt(squares / static_cast<double>(count)) / fastest_change;
}

}  // namespace spall
