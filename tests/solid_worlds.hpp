// Crystals of solids with a stress a body, and what their bodies tell.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cmath>
#include <vector>

#include "scene/scene.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {

/// A material of the library, as a case has it that names it.
inline Material material_of_library(std::string_view name) {
  return parse_case(
             fmt::format("[materials.named]\nlibrary = \"{}\"\n[[groups]]\nname = \"all\"\n"
                         "material = \"named\"\nvolume = {{shape = \"sphere\", radius = 1}}\n"
                         "packing = {{kind = \"fcc\", diameter = 1}}\n[[phases]]\n"
                         "name = \"only\"\nmethod = \"solid\"\nstep = 1\nduration = 1\n",
                         name),
             "x.toml")
      .materials[0];
}

inline Eigen::Matrix3d turn(const Vec3& about) {
  return Eigen::AngleAxisd(about.norm(), about.normalized()).toRotationMatrix();
}
inline const Eigen::Matrix3d turned = turn({0.5, -0.9, 0.3});
inline const Eigen::Matrix3d as_is = Eigen::Matrix3d::Identity();

/// Sites of an fcc crystal of spacing `d` (m), turned, where `inside`.
template <class F>
std::vector<Sphere> crystal(double d, double density, const Eigen::Matrix3d& turn, double radius,
                            F&& inside) {
  std::vector<Sphere> spheres;
  const double mass = density * d * d * d / std::sqrt(2.0);
  const int n = static_cast<int>(radius / d * std::sqrt(2.0)) + 2;
  for (int i = -n; i <= n; ++i)
    for (int j = -n; j <= n; ++j)
      for (int k = -n; k <= n; ++k) {
        const Vec3 x = turn * (d / std::sqrt(2.0) * Vec3(i, j, k));
        if ((i + j + k) % 2 == 0 && inside(x))
          spheres.push_back({.radius = d / 2, .mass = mass, .position = x});
      }
  return spheres;
}
inline std::vector<Sphere> ball(double d, double density, const Eigen::Matrix3d& turn,
                                double radius) {
  return crystal(d, density, turn, radius, [&](const Vec3& x) { return x.norm() < radius; });
}

inline Lab world_of(const Comm& comm, const std::vector<Sphere>& spheres, const SolidLaw& law) {
  Lab world = make_world(comm, spheres, {});
  world.solid.laws = {law};
  world.materials = {{.name = "copper"}};
  return world;
}

/// The body nearest to the origin, of all ranks: what `f(bodies, row)` tells of it.
template <class F>
std::vector<double> of_the_middle(const Lab& world, F&& f) {
  const Bodies& bodies = world.bodies;
  Index nearest = 0;
  double distance = infinity;
  for (Index b = 0; b < bodies.owned; ++b)
    if (const double r = bodies.position[b].norm(); r < distance) {
      distance = r;
      nearest = b;
    }
  const bool here = world.comm.min(distance) == distance;
  return world.comm.all_gather(here ? f(bodies, nearest) : std::vector<double>{});
}
/// Pa, of the body in the middle.
inline Eigen::Matrix3d stress_of_the_middle(const Lab& world) {
  const auto s = of_the_middle(world, [](const Bodies& bodies, Index b) {
    const Vec3 &direct = bodies.direct_stress[b], &shear = bodies.shear_stress[b];
    return std::vector<double>{direct[0], direct[1], direct[2],         shear[0],
                               shear[1],  shear[2],  bodies.pressure[b]};
  });
  Eigen::Matrix3d stress;
  stress << s[0], s[5], s[4], s[5], s[1], s[3], s[4], s[3], s[2];
  return stress - s[6] * Eigen::Matrix3d::Identity();
}

inline double of_the_middle_body(const Lab& world, std::vector<double> Bodies::*field) {
  return of_the_middle(world, [&](const Bodies& bodies, Index b) {
    return std::vector<double>{(bodies.*field)[b]};
  })[0];
}

struct Sums {
  double kinetic = 0, internal = 0, heat = 0;
  Vec3 momentum = Vec3::Zero(), angular = Vec3::Zero();
};
inline Sums sums_of(const Lab& world) {
  std::array<double, 9> all{};
  const Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) {
    const Vec3 p = bodies.mass[b] * bodies.velocity[b], l = bodies.position[b].cross(p);
    all[0] += p.dot(bodies.velocity[b]) / 2;
    all[1] += bodies.internal_energy[b];
    all[2] += bodies.heat[b];
    for (int k = 0; k < 3; ++k) {
      all[3 + k] += p[k];
      all[6 + k] += l[k];
    }
  }
  world.comm.sum(all);
  return {all[0], all[1], all[2], {all[3], all[4], all[5]}, {all[6], all[7], all[8]}};
}

/// A ball of bodies that are held to a motion, with this damage.
inline Lab held_ball(double d, const SolidLaw& law, double damage = 0) {
  auto spheres = ball(d, law.density, turned, 3.2 * d);
  for (Sphere& s : spheres) s.mass = infinity;
  Lab world = world_of(testing_world(), spheres, law);
  for (Index b = 0; b < world.bodies.owned; ++b) world.bodies.damage[b] = damage;
  return world;
}

/// Moves bodies with the gradient `rate` (1/s) of velocity.
inline void deform(Lab& world, const Eigen::Matrix3d& rate, double h, int steps) {
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.velocity[b] = rate * world.bodies.position[b];
  solid_steps(world, h, steps);
}

}  // namespace spall
