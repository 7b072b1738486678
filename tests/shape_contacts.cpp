// Which spheres of two clumps are contacts of a step.
// SPDX-License-Identifier: BSD-3-Clause
#include <random>
#include <set>

#include "clump_worlds.hpp"
#include "rigid/narrow_phase.hpp"
#include "testing.hpp"

namespace spall {
namespace {

using SpherePairs = std::set<std::pair<std::int32_t, std::int32_t>>;

/// Those that come nearer than `near` of the smaller radius while both bodies fly on and turn, seen
/// at a few hundred instants of the step.
SpherePairs met_in_flight(const Lab& world, double h, double near) {
  const Bodies& bodies = world.bodies;
  SpherePairs met;
  constexpr int instants = 400;
  for (int k = 0; k <= instants; ++k) {
    const double t = h * k / instants;
    const auto spheres = [&](Index b) {
      const Vec3 center = bodies.position[b] + t * bodies.velocity[b];
      const Quaternion turn = turned_by(t * bodies.angular_velocity[b], bodies.orientation[b]);
      std::vector<ShapeSphere> placed = shape_of(world.shapes, bodies, b).spheres;
      for (ShapeSphere& one : placed) one = placed_sphere(one, center, bodies.radius[b], turn);
      return placed;
    };
    const auto of_i = spheres(0), of_j = spheres(1);
    for (std::size_t a = 0; a < of_i.size(); ++a)
      for (std::size_t b = 0; b < of_j.size(); ++b) {
        const double gap = (of_j[b].at - of_i[a].at).norm() - of_i[a].radius - of_j[b].radius;
        if (gap <= near * std::min(of_i[a].radius, of_j[b].radius)) met.emplace(a, b);
      }
  }
  return met;
}

TEST(ShapeContacts, are_all_pairs_of_spheres_that_come_near_within_a_step) {
  const BodyShapes shapes = with_sphere({dumbbell(), boulder()});
  Pairs pair;
  pair.i = {0}, pair.j = {1}, pair.plane = {-1};
  std::mt19937_64 random(5);
  int met_at_all = 0, far = 0, found_at_all = 0;
  for (int turn = 0; turn < 4000; ++turn) {
    // Some are slow and near, some fast, some spin, some are far larger than the other.
    const double speed = turn % 4 == 0 ? 0 : 3, spin = turn % 3 == 0 ? 0.4 : 0;
    const double larger = turn % 5 == 0 ? 5 : 1, h = 0.5;
    std::vector<ShapedBody> two(2);
    for (ShapedBody& one : two) {
      one.shape = 1 + turn % 2;
      one.velocity = speed * random_vector(random);
      one.spin = spin * random_vector(random);
      one.orientation = random_turn(random);
    }
    two[1].radius = larger;
    two[1].position = (1.2 + larger) * random_vector(random);
    const Lab world = make_world(alone(), shapes, two, {});
    const Contacts contacts = find_contacts(world.bodies, world.shapes, {}, pair, h, ContactLaw{});
    SpherePairs found;
    for (const SphereContact& at : contacts.spheres) found.emplace(at.of_i, at.of_j);
    const SpherePairs met = met_in_flight(world, h, near_contact);
    for (const auto& [a, b] : met) EXPECT_TRUE(found.contains({a, b})) << turn << ": " << a << b;
    // Without spin nothing else is one, but for what comes near between two instants.
    if (spin == 0) {
      const SpherePairs nearly = met_in_flight(world, h, 1.05 * near_contact + 0.01 * speed * h);
      for (const auto& [a, b] : found) EXPECT_TRUE(nearly.contains({a, b})) << turn;
    }
    met_at_all += static_cast<int>(met.size());
    found_at_all += static_cast<int>(found.size());
    far += met.empty();
  }
  EXPECT_GT(far, 400);
  EXPECT_GT(met_at_all, 4000);
  EXPECT_LT(found_at_all, 1.5 * met_at_all);
}

}  // namespace
}  // namespace spall
