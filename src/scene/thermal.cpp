// Draws in the order of the bodies, takes their common motion away, then scales what is left.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/thermal.hpp"

#include <cmath>

#include "base/random.hpp"

namespace spall {

std::vector<Vec3> thermal_velocities(std::span<const double> mass, double rms, std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<Vec3> velocity(mass.size(), Vec3::Zero());
  Vec3 momentum = Vec3::Zero();
  double all = 0;
  for (std::size_t b = 0; b < mass.size(); ++b) {
    if (!std::isfinite(mass[b])) continue;
    for (double& component : velocity[b]) component = normal(engine);
    momentum += mass[b] * velocity[b];
    all += mass[b];
  }
  double squares = 0;
  std::int64_t components = 0;
  for (std::size_t b = 0; b < mass.size(); ++b) {
    if (!std::isfinite(mass[b])) continue;
    velocity[b] -= momentum / all;
    squares += velocity[b].squaredNorm();
    components += 3;
  }
  const double scale = rms * std::sqrt(static_cast<double>(components) / squares);
  for (Vec3& v : velocity) v *= scale;
  return velocity;
}

}  // namespace spall
