// Copper, elastic and ductile: crystals of it, and two pieces that meet.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "solid_worlds.hpp"

namespace spall {

inline constexpr double d = 1e-3;  // m

inline const Solid copper{
    .density = 8930,
    .sound_speed = 3940,
    .hugoniot_slope = 1.489,
    .gruneisen = 2.02,
    .youngs_modulus = 124e9,
    .poisson_ratio = 0.34,
    .yield_strength = 90e6,
    .spall_strength = 1.2e9,
    .specific_heat = 385,
    .melting_point = 1358,
    .johnson_cook = {.a = 90e6, .b = 292e6, .n = 0.31, .c = 0.025, .m = 1.09}};
inline const SolidLaw elastic = solid_law(copper, false, "copper");
inline const SolidLaw ductile = solid_law(copper, true, "copper");

template <class F>
std::vector<Sphere> crystal(const Eigen::Matrix3d& turn, double radius, F&& inside) {
  return spall::crystal(d, copper.density, turn, radius, inside);
}
inline std::vector<Sphere> ball(const Eigen::Matrix3d& turn, double radius) {
  return spall::ball(d, copper.density, turn, radius);
}

/// A ball that is deformed in another way at each place, at some 20 m/s.
inline std::vector<Sphere> stirred_ball() {
  auto spheres = ball(turned, 2.6 * d);
  for (Sphere& s : spheres) {
    const Vec3 x = s.position / d;
    s.velocity = 20 * Vec3(std::sin(x.y()), x.x() * 0.3, std::cos(x.x() + x.z()));
  }
  return spheres;
}

/// Two balls of different groups that meet.
inline std::vector<Sphere> two_balls(double speed, double radius = 2.6 * d) {
  std::vector<Sphere> all;
  for (int side : {-1, 1})
    for (Sphere s : ball(side < 0 ? as_is : turned, radius)) {
      s.position += side * Vec3(radius + 0.6 * d, 0.3 * d, 0);
      s.velocity = -side * Vec3(speed, 0, 0);
      all.push_back(s);
    }
  return all;
}
inline Lab of_two(const Comm& comm, const std::vector<Sphere>& spheres, const SolidLaw& law) {
  Lab world = world_of(comm, spheres, law);
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.group[b] = spheres[world.bodies.id[b]].velocity.x() < 0;
  return world;
}
inline Lab world_of_two(const Comm& comm, double speed, const SolidLaw& law) {
  return of_two(comm, two_balls(speed), law);
}

/// Of pieces that met at `speed` and yielded.
inline void expect_kept(const Lab& world, const Sums& before, double speed) {
  const Sums after = sums_of(world);
  const double scale = before.kinetic / speed;
  EXPECT_LE((after.momentum - before.momentum).norm(), 1e-12 * scale);
  EXPECT_LE((after.angular - before.angular).norm(), 1e-12 * scale * 3 * d);
  EXPECT_GT(after.heat, 0.1 * before.kinetic);
  const double contacts = world.solid.energy(world) - (after.internal - after.heat);
  EXPECT_NEAR(after.kinetic + after.internal + contacts, before.kinetic, 1e-2 * before.kinetic);
}

}  // namespace spall
