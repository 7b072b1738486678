// A bar of metal is pulled at its ends: it flows at its flow stress, and does not part before it
// fails.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "solid/flow_stress.hpp"
#include "solid_worlds.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3, radius = 4 * d, length = 24 * d;  // m
constexpr double held = 2 * d;                               // m, at each end

/// A bar whose ends are drawn apart so that it grows at `rate` (1/s).
Lab pulled_bar(const SolidLaw& law, const Eigen::Matrix3d& turn, double rate) {
  auto spheres = crystal(d, law.density, turn, length, [](const Vec3& x) {
    return std::hypot(x.x(), x.y()) < radius && std::abs(x.z()) < length / 2;
  });
  for (Sphere& s : spheres) {
    s.velocity = {0, 0, rate * s.position.z()};
    if (std::abs(s.position.z()) > length / 2 - held) s.mass = infinity;
  }
  return world_of(testing_world(), spheres, law);
}

/// Pa, over the middle of the bar: the mean stress along it; the mean flow stress.
struct Middle {
  double stress = 0, flow = 0;
};
Middle middle_of(const Lab& world, double rate) {
  const Bodies& bodies = world.bodies;
  const SolidLaw& law = world.solid.laws[0];
  std::array<double, 3> sums{};
  for (Index b = 0; b < bodies.owned; ++b) {
    if (std::abs(bodies.position[b].z()) > 4 * d) continue;
    const double volume = 1 / bodies.compression[b];
    const double heat = bodies.heat[b] / (d * d * d / std::sqrt(2.0) * law.density);
    const double flow =
        flow_stress_of(law, heat / law.melting_heat()).at(bodies.plastic_strain[b], rate).stress;
    sums[0] += volume;
    sums[1] += volume * (bodies.direct_stress[b].z() - bodies.pressure[b]);
    sums[2] += volume * flow;
  }
  world.comm.sum(sums);
  return {sums[1] / sums[0], sums[2] / sums[0]};
}
/// Of bodies that are not held: those are stretched without growing thinner.
double most_damage(const Lab& world) {
  double most = 0;
  for (Index b = 0; b < world.bodies.owned; ++b)
    if (std::isfinite(world.bodies.mass[b])) most = std::max(most, world.bodies.damage[b]);
  return world.comm.max(most);
}

TEST(PulledBar, bears_its_flow_stress_and_does_not_part_while_it_is_whole) {
  for (const char* material : {"copper", "aluminium_6061_t6", "steel_4340"}) {
    const SolidLaw law = solid_law(*material_of_library(material).solid, true, material);
    for (const Eigen::Matrix3d& turn : {as_is, turned}) {
      // A tenth in as long as sound runs twelve times along it.
      const double rate = 0.1 / (12 * length / law.sound_speed());
      const double h = 0.15 * d / law.sound_speed();
      Lab world = pulled_bar(law, turn, rate);
      double last = 0;
      for (double strain : {0.06, 0.1, 0.2}) {
        solid_steps(world, h, static_cast<int>((strain - last) / (rate * h)));
        last = strain;
        const Middle middle = middle_of(world, rate);
        const bool whole = most_damage(world) < 1;
        // It necks towards the end, and 6061-T6 tears there by its strain.
        EXPECT_TRUE(whole || strain > 0.1) << material << " " << strain;
        const double error = strain > 0.1 ? 0.1 : 0.03;
        const double beyond = std::abs(middle.stress / middle.flow - 1);
        EXPECT_TRUE(!whole || beyond < error) << material << " " << strain << " " << beyond;
      }
    }
  }
}

}  // namespace
}  // namespace spall
