// How many pairs are listed for those that touch.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <random>

#include "penalty_worlds.hpp"

namespace spall {
namespace {

struct Bed {
  std::vector<Sphere> spheres;
  double edge;  ///< m, of the box that repeats itself
};

/// Radii of 0.1 to 1 m, so many a radius as r^-3, at random in a box filled to 0.3, in motion: that
/// of bench/untuned, smaller.
Bed bed(int count) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> share;
  std::normal_distribution<double> motion;
  std::vector<double> radii;
  double volume = 0;
  for (int k = 0; k < count; ++k) {
    radii.push_back(std::pow(1 + share(random) * (std::pow(0.1, -2) - 1), -0.5));
    volume += 4 * pi / 3 * std::pow(radii.back(), 3);
  }
  std::ranges::sort(radii, std::greater{});  // the largest find their places first
  Bed bed{{}, std::cbrt(volume / 0.3)};
  const auto nearest = [&](Vec3 d) {
    for (double& x : d) x -= bed.edge * std::round(x / bed.edge);
    return d;
  };
  for (std::size_t k = 0; k < radii.size();) {
    const double r = radii[k];
    const Vec3 place = bed.edge * Vec3(share(random), share(random), share(random));
    if (std::ranges::any_of(bed.spheres, [&](const Sphere& other) {
          return nearest(place - other.position).norm() < r + other.radius;
        }))
      continue;
    bed.spheres.push_back({.radius = r,
                           .mass = 2500 * 4 * pi / 3 * r * r * r,
                           .position = place,
                           .velocity = Vec3(motion(random), motion(random), motion(random))});
    ++k;
  }
  return bed;
}

TEST(Listing, every_body_with_partners_is_more_work_than_one_without) {
  const Bed start = bed(300);
  Lab world = penalty_world(alone(), start.spheres, {}, {.restitution = 0.5});
  world.period.size = Vec3::Constant(start.edge);
  penalty_steps(world, 1e-4, 1);
  const NearPairs& near = world.penalty.touch;
  const std::vector<double> work = work_of(world.bodies, near);
  const Links pairs = links_of(near.windows);
  EXPECT_GT(pairs.i.size(), 100);
  for (const Index b : pairs.i) EXPECT_GT(work[b], 1) << b;
}

TEST(Listing, of_a_moving_bed_of_ten_sizes_is_at_most_eight_pairs_a_grain) {
  const Bed start = bed(3000);
  Lab world =
      penalty_world(testing_world(), start.spheres, {}, {.friction = 0.5, .restitution = 0.5});
  world.period.size = Vec3::Constant(start.edge);
  int searches = 0;
  for (int turn = 0; turn < 20; ++turn) {
    penalty_steps(world, 1e-4, 50);
    const double pairs = world.penalty.touch.pairs / 3000;
    EXPECT_LE(pairs, 8);
    EXPECT_GE(pairs, static_cast<double>(count_touching(world.bodies, world.penalty.touch)) / 3000);
    searches = world.penalty.touch.searches;
    if (turn % 5 == 4)
      fmt::print("{:.1f} pairs a grain listed, skin {:.3g} m\n", pairs, world.penalty.touch.skin);
  }
  EXPECT_GT(searches, 2);
}

}  // namespace
}  // namespace spall
