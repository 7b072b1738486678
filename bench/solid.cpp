// Aluminium by its material's law against what is known of it: shocks, tension, spall.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <string>

#include "solid_samples.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

/// Mean velocity along z and mass of the bodies about the axis, in bins one spacing wide from
/// `low`.
struct Profile {
  std::vector<double> velocity, mass;
};
Profile profile(const Lab& world, double low, double high, double radius, double width) {
  const auto bins = static_cast<std::size_t>((high - low) / width);
  std::vector<double> sums(2 * bins, 0.0);
  const Bodies& b = world.bodies;
  for (Index k = 0; k < b.owned; ++k) {
    const Vec3& x = b.position[k];
    const double at = (x.z() - low) / width;
    if (x.head<2>().norm() > radius || at < 0 || at >= static_cast<double>(bins)) continue;
    sums[static_cast<std::size_t>(at)] += b.mass[k];
    sums[bins + static_cast<std::size_t>(at)] += b.mass[k] * b.velocity[k].z();
  }
  world.comm.sum(sums);
  Profile p;
  for (std::size_t k = 0; k < bins; ++k) {
    p.mass.push_back(sums[k]);
    p.velocity.push_back(sums[k] > 0 ? sums[bins + k] / sums[k] : 0);
  }
  return p;
}

/// How much nearer along z two layers, three spacings thick, have come that began at `low` and
/// `high`.
double compression(const Lab& world, const std::vector<Vec3>& start, double low, double high,
                   double radius) {
  std::array<double, 6> sums{};
  const double half = 1.5 * world.potential.law.common().distance;
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const Vec3& x = start[static_cast<std::size_t>(world.bodies.id[b])];
    if (x.head<2>().norm() > radius) continue;
    for (int layer = 0; layer < 2; ++layer) {
      if (std::abs(x.z() - (layer == 0 ? low : high)) > half) continue;
      sums[3 * layer] += 1;
      sums[3 * layer + 1] += x.z();
      sums[3 * layer + 2] += world.bodies.position[b].z();
    }
  }
  world.comm.sum(sums);
  const auto mean = [&](int layer, int k) { return sums[3 * layer + k] / sums[3 * layer]; };
  return (mean(1, 1) - mean(0, 1)) / (mean(1, 2) - mean(0, 2));
}

/// Two crystals meet at +-up: the shock runs into each. The front is where the axis has lost half
/// of its speed; its speed is fitted while it crosses the second half of its way, so that its shape
/// is steady and nothing has come from the sides.
void shock(const Comm& comm, const Sample& m, const std::string& orientation, double up,
           double length) {
  const double radius = 1.5 * length, core = 4;
  const Vec3 rotation = turn(orientation);
  std::vector<Vec3> start;
  Lab world = make_discs(comm, m, {{-length, -0.5, radius, up}, {0.5, length, radius, -up}},
                         rotation, &start);
  const double h = std::min(m.step(), 0.02 * m.d / up);
  const double width = 2 * m.d;
  std::vector<double> times, places;
  double time = 0, ratio = 0;
  for (int k = 0; k < 20000; ++k) {
    potential_steps(world, h, 10);
    time += 10 * h;
    const Profile p = profile(world, 0, length * m.d, core * m.d, width);
    std::size_t at = p.velocity.size() - 1;
    while (at > 0 && p.velocity[at] > -up / 2) --at;
    std::size_t front = 0;
    while (front + 1 < p.velocity.size() && p.velocity[front] > -up / 2) ++front;
    if (front == 0) continue;
    const double rise =
        (p.velocity[front - 1] + up / 2) / (p.velocity[front - 1] - p.velocity[front]);
    const double place = width * (static_cast<double>(front) - 0.5 + rise);
    const double way = place / (m.d * length) + up * time / (m.d * length);  // in the crystal
    if (way > 0.4) {
      times.push_back(time);
      places.push_back(place);
      ratio = compression(world, start, 2 * m.d, 0.6 * (place + up * time), core * m.d);
    }
    if (way > 0.8) break;
  }
  double t = 0, x = 0, tt = 0, tx = 0;
  const auto n = static_cast<double>(times.size());
  for (std::size_t k = 0; k < times.size(); ++k) {
    t += times[k] / n;
    x += places[k] / n;
  }
  for (std::size_t k = 0; k < times.size(); ++k) {
    tt += (times[k] - t) * (times[k] - t);
    tx += (times[k] - t) * (places[k] - x);
  }
  const double us = tx / tt + up;
  if (comm.rank == 0)
    fmt::print("shock,{},{:g},{:.1f},{:.4f},{:.1f},{:.4f}\n", orientation, up, us, ratio,
               m.solid.sound_speed + m.solid.hugoniot_slope * up,
               1 / (1 - up / (m.solid.sound_speed + m.solid.hugoniot_slope * up)));
}

/// A bar whose parts fly apart, its ends at 5 % of the sound speed: the largest stress in its
/// middle.
void tension(const Comm& comm, const Sample& m, const std::string& orientation) {
  const double radius = 8, half = 14, speed = 0.05 * m.solid.sound_speed;
  Lab world = make_discs(comm, m, {{-half, half, radius, 0}}, turn(orientation));
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.velocity[b].z() = speed * world.bodies.position[b].z() / (half * m.d);
  const double h = m.step();
  double strongest = 0, strain_at = 0;
  for (int k = 1; k * 5 * h * speed < 0.05 * half * m.d; ++k) {
    potential_steps(world, h, 5);
    double force = 0;
    const Bodies& bodies = world.bodies;
    const double reach = m.law.cutoff;
    std::vector<double> near;
    for (Index b = 0; b < bodies.owned; ++b)
      if (std::abs(bodies.position[b].z()) < reach)
        near.insert(near.end(), bodies.position[b].data(), bodies.position[b].data() + 3);
    near = comm.all_gather(near);
    for (std::size_t i = 0; i < near.size(); i += 3)
      for (std::size_t j = 0; j < near.size(); j += 3) {
        if (near[i + 2] >= 0 || near[j + 2] < 0) continue;
        const Vec3 x(near[j] - near[i], near[j + 1] - near[i + 1], near[j + 2] - near[i + 2]);
        force -= pair_force(m.law, x.norm()) * x.z() / x.norm();
      }
    const double stress = force / (pi * radius * radius * m.d * m.d);
    if (stress > strongest) {
      strongest = stress;
      strain_at = k * 5 * h * speed / (half * m.d);
    }
  }
  if (comm.rank == 0)
    fmt::print("tension,{},{:g},{:.3g},{:.4f},{:.3g}\n", orientation, speed, strongest, strain_at,
               m.solid.spall_strength);
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    require(argc >= 5,
            "usage: bench_solid CASE shock|tension|spall ORIENTATION DAMPING [SPEED LENGTH]: the "
            "law is that of the case's material; orientations are 100, 110, 111 or a seed");
    const Case scene = read_case(argv[1], {"pair_potential.damping=" + std::string(argv[4])});
    Sample m{*scene.materials[0].solid, scene.engines.find<PotentialSettings>()->law.common(), 0,
             scene.engines.find<PotentialSettings>()->law.common().distance};
    m.mass = sphere_mass(m.solid, {12, std::sqrt(0.5), m.d});
    const std::string what = argv[2];
    const double speed = argc > 5 ? std::atof(argv[5]) : 0,
                 length = argc > 6 ? std::atof(argv[6]) : 0;
    if (what == "shock") shock(comm, m, argv[3], speed, length);
    if (what == "tension") tension(comm, m, argv[3]);
    if (what == "spall") spall_test(comm, m, argv[3], speed, length);
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
