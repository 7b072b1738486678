// Each level of instructions that this machine has gives the same results to round-off, and the
// same bits again.
// SPDX-License-Identifier: BSD-3-Clause
#include <functional>

#include "base/kernels.hpp"
#include "gravity/direct.hpp"
#include "gravity/tree.hpp"
#include "gravity_sets.hpp"
#include "pair_potentials.hpp"
#include "penalty_worlds.hpp"

namespace spall {
namespace {

/// Calls `numbers` twice at each level; differences are relative to the largest number.
void compare_levels(double tolerance, const std::function<std::vector<double>()>& numbers) {
  const Instructions best = instructions();
  std::vector<double> reference;
  for (const Instructions level : {Instructions::v2, Instructions::v3, Instructions::v4}) {
    if (level > best) continue;
    use_instructions(level);
    const std::vector<double> first = numbers(), again = numbers();
    EXPECT_EQ(first, again) << instructions_name();
    if (level == Instructions::v2) reference = first;
    ASSERT_EQ(first.size(), reference.size());
    double largest = 0;
    for (double x : reference) largest = std::max(largest, std::abs(x));
    for (std::size_t k = 0; k < first.size(); ++k)
      EXPECT_NEAR(first[k], reference[k], tolerance * largest) << instructions_name();
  }
  use_instructions(best);
}

std::vector<double> state_of(const Lab& world) {
  std::vector<double> state;
  for (const Sphere& s : spheres_of(world))
    for (const Vec3* v : {&s.position, &s.velocity, &s.spin})
      state.insert(state.end(), v->data(), v->data() + 3);
  return state;
}

TEST(Levels, pair_potentials) {
  std::vector<Sphere> crystal;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> motion(-0.1, 0.1);
  for (int i = 0; i < 8; ++i)
    for (int j = 0; j < 8; ++j)
      for (int k = (i + j) % 2; k < 8; k += 2)
        crystal.push_back({.radius = 0.55,
                           .position = 0.77 * Vec3(i, j, k),
                           .velocity = {motion(random), motion(random), motion(random)}});
  for (PairPotential law : {lennard_jones, mie, morse, sprung, breaking, embedded})
    for (double damping : {0.0, 0.1}) {
      law.damping = damping;
      compare_levels(1e-12, [&] {
        Lab world = make_world(testing_world(), crystal, {});
        world.potential.law = law;
        potential_steps(world, 0.01, 10);
        auto state = state_of(world);
        state.push_back(potential_energy(world));
        return state;
      });
    }
}

TEST(Levels, penalty_contact) {
  PenaltySettings sticky;
  sticky.adhesion = Adhesion::jkr;
  sticky.adhesion_strength = 200;
  const PenaltySettings hooke{.model = PenaltyModel::hooke, .stiffness = 1e6};
  for (const PenaltySettings& settings : {hooke, sticky})
    compare_levels(1e-11, [&] {
      Lab world = penalty_world(testing_world(), crowd(150, 0.3, 0.1), settings,
                                {.friction = 0.5, .restitution = 0.5});
      penalty_steps(world, 1e-4, 20);
      auto state = state_of(world);
      state.push_back(contact_energy(world));
      return state;
    });
}

TEST(Levels, contact_problems) {
  for (double friction : {0.0, 0.5})
    compare_levels(1e-6, [&] {  // of the solver's tolerance
      Lab world = make_world(testing_world(), crowd(150, 0.3, 0.1), {.friction = friction});
      advance(world, 0.1, 2);
      return state_of(world);
    });
}

TEST(Levels, gravity) {
  const Comm comm = testing_world();
  const Points mine = share(comm, random_ball(2000, 5));
  for (const bool tree : {false, true})
    compare_levels(1e-12, [&] {
      const GravityField field =
          tree ? evaluate_gravity_tree(comm, 1, tree_settings(1e-3), mine.mass, mine.position,
                                       mine.velocity)
               : evaluate_gravity_direct(comm, 1, mine.mass, mine.position, mine.velocity, true);
      std::vector<double> numbers(field.potential);
      for (const Vec3& a : field.acceleration)
        numbers.insert(numbers.end(), a.data(), a.data() + 3);
      return numbers;
    });
}

}  // namespace
}  // namespace spall
