// Draws each body's own numbers, takes their common motion away, then scales what is left.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/thermal.hpp"

#include <array>
#include <cmath>

#include "base/random.hpp"

namespace spall {

std::vector<Vec3> thermal_velocities(const Comm& comm, std::span<const double> mass,
                                     std::span<const BodyId> number, double rms,
                                     std::uint64_t seed) {
  std::vector<Vec3> velocity(mass.size(), Vec3::Zero());
  std::array<double, 5> sums{};  // momentum, mass, and how many move
  for (std::size_t b = 0; b < mass.size(); ++b) {
    if (!std::isfinite(mass[b])) continue;
    CounterEngine engine(mix(seed + static_cast<std::uint64_t>(number[b])));
    for (int d = 0; d < 3; ++d) sums[d] += mass[b] * (velocity[b][d] = normal(engine));
    sums[3] += mass[b];
    ++sums[4];
  }
  comm.sum(sums);
  double squares = 0;
  for (std::size_t b = 0; b < mass.size(); ++b) {
    if (!std::isfinite(mass[b])) continue;
    velocity[b] -= Vec3(sums[0], sums[1], sums[2]) / sums[3];
    squares += velocity[b].squaredNorm();
  }
  const double scale = rms * std::sqrt(3 * sums[4] / comm.sum(squares));
  for (Vec3& v : velocity) v *= scale;
  return velocity;
}

}  // namespace spall
