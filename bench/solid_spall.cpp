// A plate flies at one twice as thick: where waves of release meet, the crystal tears.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "solid_samples.hpp"

namespace spall {
namespace {

constexpr double core =
    4;  // spacings about the axis in which is measured: nothing comes from the rim

/// What the bodies of a layer, by where they began, do in the mean.
struct Layer {
  double began = 0, place = 0, velocity = 0, virial = 0;
};

/// Layers a spacing thick from the target's front face to its back.
std::vector<Layer> measure_layers(Lab& world, const std::vector<Vec3>& start, std::size_t layers) {
  const Bodies& bodies = world.bodies;
  const double d = world.potential.law.common().distance;
  std::vector<double> sums(5 * layers, 0.0);
  const auto add = [&](Index b, int what, double value) {
    const Vec3& x = start[static_cast<std::size_t>(bodies.id[b])];
    const auto at = static_cast<std::size_t>(std::max(0.0, x.z() / d));
    if (x.z() > 0 && at < layers && x.head<2>().norm() < core * d)
      sums[static_cast<std::size_t>(what) * layers + at] += value;
  };
  for_each_near_pair(world, world.potential, [&](Index i, Index j, const Vec3& x, bool bound) {
    const double r = x.norm(), force = pair_force(world.potential.law.common(), r);
    const double half = bound || force > 0 ? -force * x.z() * x.z() / r / 2 : 0;
    for (Index b : {i, j})
      if (b < bodies.owned) add(b, 3, half);
  });
  for (Index b = 0; b < bodies.owned; ++b) {
    add(b, 0, 1);
    add(b, 1, start[static_cast<std::size_t>(bodies.id[b])].z());
    add(b, 2, bodies.position[b].z());
    add(b, 4, bodies.velocity[b].z());
  }
  world.comm.sum(sums);
  std::vector<Layer> result;
  for (std::size_t k = 0; k < layers; ++k) {
    const auto mean = [&](std::size_t what) { return sums[what * layers + k] / sums[k]; };
    if (sums[k] > 0) result.push_back({mean(1), mean(2), mean(4), mean(3)});
  }
  return result;
}

}  // namespace

/// Prints the largest tension that a layer bore, that which the free surface tells by its
/// pull-back, rho c du/2 (c: of the front's arrival there), and how far from it the target tore.
void spall_test(const Comm& comm, const Sample& m, const std::string& orientation, double speed,
                double length) {
  // Releases meet after three passes of the flyer, the surface knows after four; five from the rim.
  const double radius = core + 5 * length;
  std::vector<Vec3> start;
  Lab world = make_discs(comm, m,
                         {{-0.5 - length, -0.5, radius, speed}, {0.5, 2 * length + 0.5, radius, 0}},
                         turn(orientation), &start);
  const auto layers = static_cast<std::size_t>(2 * length);
  const double h = m.step(), volume = m.mass / m.solid.density;
  constexpr int steps = 10;
  double strongest = 0, highest = 0, lowest = 0, hit = 0, arrival = 0;
  const double pass = length * m.d / sound_speeds(m.law, m.mass).along_100;  // the slowest
  for (double time = 0; hit == 0 || time < hit + 5 * pass; time += steps * h) {
    potential_steps(world, h, steps);
    const auto layer = measure_layers(world, start, layers);
    for (const Layer& one : layer) strongest = std::max(strongest, one.virial / volume);
    if (hit == 0 && layer.front().velocity > speed / 4) hit = time;
    const double surface = layer.back().velocity;
    if (arrival == 0 && surface > speed / 2) arrival = time;
    if (surface > highest) highest = lowest = surface;
    lowest = std::min(lowest, surface);
  }
  const auto layer = measure_layers(world, start, layers);
  std::size_t torn = 1;
  const auto stretch = [&](std::size_t k) {
    return (layer[k].place - layer[k - 1].place) - (layer[k].began - layer[k - 1].began);
  };
  for (std::size_t k = 1; k < layer.size(); ++k)
    if (stretch(k) > stretch(torn)) torn = k;
  const double sound = 2 * length * m.d / (arrival - hit);
  if (comm.rank == 0)
    fmt::print("spall,{},{:g},{:.4g},{:.4g},{:.4g},{:.3g},{:.1f},{:.4g}\n", orientation, speed,
               strongest, m.solid.density * sound * (highest - lowest) / 2, m.solid.spall_strength,
               length, 2 * length + 0.5 - (layer[torn].began + layer[torn - 1].began) / (2 * m.d),
               stretch(torn) / m.d);
}

}  // namespace spall
