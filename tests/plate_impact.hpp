// A plate of one metal flies at one of another: the state between them, and that of hand
// calculation by impedance match.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "lab.hpp"
#include "potential/settings.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"

namespace spall {

struct PlateImpact {
  std::string flyer, target;  ///< files of cases/materials, without .toml
  double speed = 0;           ///< m/s, of the flyer
  int seed = 1;               ///< of the crystals' orientations
  double length = 10;         ///< of each plate, in spacings
};

struct InterfaceState {
  double velocity = 0;  ///< m/s
  double pressure = 0;  ///< Pa
};

/// m/s, of a shock to a particle velocity u (m/s); and the pressure behind it (Pa).
inline double shock_speed(const Solid& s, double u) {
  return s.sound_speed + s.hugoniot_slope * u;
}
inline double shock_pressure(const Solid& s, double u) {
  return s.density * shock_speed(s, u) * u;
}

/// Where the target's Hugoniot meets that of the flyer, mirrored at its speed.
inline InterfaceState impedance_match(const Solid& flyer, const Solid& target, double speed) {
  double low = 0, high = speed;
  for (int halvings = 0; halvings < 60; ++halvings) {
    const double u = (low + high) / 2;
    (shock_pressure(target, u) < shock_pressure(flyer, speed - u) ? low : high) = u;
  }
  return {low, shock_pressure(target, low)};
}

struct ImpactResult {
  InterfaceState measured, by_hand;
};

/// Discs of equal spacing, 2.8 times as wide as long: nothing comes from the rim to the core in
/// which is measured before the shocks have run three quarters of the plates. `materials` is the
/// folder of the materials' files. Collective.
inline ImpactResult plate_impact(const Comm& comm, const PlateImpact& impact,
                                 const std::string& materials) {
  const double d = 0.25e-3, length = impact.length * d, core = 4 * d;
  std::string text = fmt::format(
      "seed = {}\n[pair_potential]\nmaterials = [\"flyer\", \"target\"]\n"
      "damping = 0.3\n[[phases]]\nname = \"impact\"\nstep = \"1 ns\"\n"
      "method = \"potential\"\nduration = \"1 us\"\n",
      impact.seed);
  const auto plate = [&](const char* name, const std::string& file, double centre, double speed) {
    text += fmt::format(
        "[materials.{0}]\nfile = \"{1}.toml\"\n[[groups]]\nname = \"{0}\"\nmaterial = \"{0}\"\n"
        "volume = {{shape = \"cylinder\", radius = {2}, height = {3}, center = [0, 0, {4}]}}\n"
        "packing = {{kind = \"fcc\", diameter = {5}, orientation = \"random\"}}\n"
        "velocity = [0, 0, {6}]\n",
        name, file, 1.4 * length, length, centre, d, speed);
  };
  plate("flyer", impact.flyer, -(length + d) / 2, impact.speed);
  plate("target", impact.target, (length + d) / 2, 0);
  const Case scene = parse_case(text, materials + "/impact.toml");
  const Solid &flyer = *scene.materials[0].solid, &target = *scene.materials[1].solid;
  ImpactResult result;
  result.by_hand = impedance_match(flyer, target, impact.speed);

  Lab world(make_world(comm, scene));
  world.bodies = make_bodies(scene, comm);
  world.potential.law = scene.engines.find<PotentialSettings>()->law;
  // Of each body id: the plate, where in the core, and whether it is near the other plate.
  std::vector<double> began;
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const Vec3& x = world.bodies.position[b];
    began.insert(began.end(), {static_cast<double>(world.bodies.id[b]),
                               x.head<2>().norm() < core ? x.z() : infinity});
  }
  began = comm.all_gather(began);
  std::vector<double> height(began.size() / 2);
  for (std::size_t k = 0; k < began.size(); k += 2)
    height[static_cast<std::size_t>(began[k])] = began[k + 1];

  const double u = result.by_hand.velocity;
  const double fastest = std::max(shock_speed(flyer, impact.speed - u), shock_speed(target, u));
  // s, in which the fastest wave crosses a plate.
  const double crossing = length / fastest;
  double h = 0.02 * d / impact.speed;
  for (int m = 0; m < 2; ++m) {
    double mass = infinity;
    for (Index b = 0; b < world.bodies.owned; ++b)
      if (world.bodies.material[b] == m) mass = std::min(mass, world.bodies.mass[b]);
    h = std::min(h, 0.4 * longest_step(world.potential.law(m, m), comm.min(mass)));
  }
  // Mean velocities: of the target's core, the flyer's, and of what is near on both sides.
  std::vector<std::array<double, 4>> rows;
  // Since the shock has passed through half of what is near the interface, 0.2 of the plate.
  double time = 0, met = infinity;
  while (time < met + 0.5 * crossing) {
    require(time < 3 * crossing + 2 * d / impact.speed, "the plates do not meet");
    potential_steps(world, h, 5);
    time += 5 * h;
    std::array<double, 8> sums{};
    for (Index b = 0; b < world.bodies.owned; ++b) {
      const double z = height[static_cast<std::size_t>(world.bodies.id[b])];
      if (z == infinity) continue;
      const auto add = [&](std::size_t what) {
        sums[2 * what] += 1;
        sums[2 * what + 1] += world.bodies.velocity[b].z();
      };
      add(world.bodies.material[b] == 1 ? 0 : 1);
      if (std::abs(z) > d && std::abs(z) < 3.5 * d) add(z > 0 ? 2 : 3);
    }
    comm.sum(sums);
    const auto mean = [&](int what) { return sums[2 * what + 1] / sums[2 * what]; };
    if (met == infinity && mean(2) > u / 2) met = time;
    if (time > met + 0.1 * crossing)
      rows.push_back({time, mean(0), mean(1), (mean(2) + mean(3)) / 2});
  }
  // What flows into the target's core a second is the pressure; and out of the flyer's.
  const auto slope = [&](int what) {
    double t = 0, v = 0, tt = 0, tv = 0;
    for (const auto& row : rows) t += row[0] / rows.size(), v += row[what] / rows.size();
    for (const auto& row : rows) {
      tt += (row[0] - t) * (row[0] - t);
      tv += (row[0] - t) * (row[what] - v);
    }
    return tv / tt;
  };
  result.measured.pressure = length * (target.density * slope(1) - flyer.density * slope(2)) / 2;
  std::size_t last = 0;
  for (std::size_t k = rows.size() / 2; k < rows.size(); ++k, ++last)
    result.measured.velocity += rows[k][3];
  result.measured.velocity /= static_cast<double>(last);
  return result;
}

}  // namespace spall
