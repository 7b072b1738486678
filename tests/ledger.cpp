// The ledger of steps to the last joule, and a state that goes on with the same bits.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <random>

#include "clump_worlds.hpp"
#include "engine/free_turn.hpp"
#include "gravity/kick.hpp"
#include "output/diagnostics.hpp"
#include "run/simulation.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

const Plane floor_plane{.point = Vec3::Zero(), .normal = Vec3::UnitZ()};

/// Spheres of several sizes pressed into each other, with random motion and spins.
std::vector<Sphere> tangle(int count) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Sphere> spheres(count);
  for (Sphere& s : spheres) {
    s.radius = 1 + 0.4 * uniform(random);
    s.mass = 2 * std::pow(s.radius, 3);
    for (int k = 0; k < 3; ++k) {
      s.position[k] = 1.3 * std::cbrt(count) * uniform(random);
      s.velocity[k] = uniform(random);
      s.spin[k] = uniform(random);
    }
  }
  return spheres;
}

TEST(Ledger, explains_every_joule_of_a_step_of_overlapping_spheres_without_gravity) {
  for (double friction : {0.0, 0.6})
    for (double restitution : {0.0, 0.7}) {
      Lab world = make_world(testing_world(), tangle(60),
                             {.friction = friction, .restitution = restitution});
      const double start = diagnose(world).kinetic;
      for (int step = 0; step < 5; ++step) {
        const Diagnostics before = diagnose(world);
        nonsmooth_step(world, 0.05, {.tolerance = 1e-3}, 1);
        const Diagnostics now = diagnose(world);
        const double spent = now.dissipated - before.dissipated;
        const double gained = now.corrections - before.corrections;
        // Identities of sums, however well the contacts are solved: round-off is left.
        EXPECT_NEAR(now.kinetic - before.kinetic, gained - spent, 1e-12 * start) << step;
        EXPECT_TRUE(step > 0 || spent > 0);
        EXPECT_TRUE(step > 0 || std::abs(gained) > 1e-6 * start);
      }
    }
}

TEST(Ledger, books_the_work_of_forces_of_the_program_beside_that_of_contacts) {
  Lab world = make_world(testing_world(), tangle(40), {.friction = 0.4, .restitution = 0.3});
  const auto pull = [](const Bodies& bodies, std::span<Vec3> force) {
    for (std::size_t b = 0; b < force.size(); ++b)
      force[b] += Vec3(3, -1, 2) - 0.5 * bodies.position[b];
  };
  world.own_forces.emplace_back(pull);
  const Diagnostics before = diagnose(world);
  nonsmooth_step(world, 0.05, {.tolerance = 1e-3}, 1);
  const Diagnostics now = diagnose(world);
  EXPECT_NEAR(now.kinetic - before.kinetic, now.own_work + now.corrections - now.dissipated,
              1e-12 * before.kinetic);
  EXPECT_GT(std::abs(now.own_work), 1e-3 * before.kinetic);
}

TEST(Ledger, books_the_height_that_a_correction_gives) {
  // A sphere at rest, pressed into the floor, is lifted: the corrections gain what it weighs there.
  const double m = 3, r = 0.5, g = 9.8, overlap = 0.02 * r;
  Lab world = make_world(alone(), {{.radius = r, .mass = m, .position = {0, 0, r - overlap}}},
                         {.friction = 0.5});
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -g};
  advance(world, 1e-3, 1);
  const Sphere after = spheres_of(world)[0];
  const double lifted = after.position.z() - (r - overlap);
  EXPECT_GT(lifted, overlap / 2);
  EXPECT_NEAR(after.velocity.norm(), 0, 1e-12 * g);
  EXPECT_NEAR(diagnose(world).corrections, m * g * lifted, 1e-12 * m * g * r);
}

TEST(Ledger, books_the_bonds_that_a_correction_opens) {
  // Cohesion has pulled on the way into an overlap, too: who opens it gives that back. Bodies are
  // at rest, so only those that it pulls over a gap move by themselves, by h^2 F/m.
  const ContactLaw law{.friction = 0.5, .cohesion = 40, .cohesion_range = 0.01};
  constexpr double h = 1e-5;
  for (const bool clumps : {false, true}) {
    std::vector<ShapedBody> bodies;
    for (const Sphere& s : tangle(60))
      bodies.push_back({.shape = clumps ? 1 : 0,
                        .radius = s.radius,
                        .mass = s.mass,
                        .position = s.position,
                        .orientation = turned_by(s.spin, Quaternion::Identity())});
    Lab world = make_world(testing_world(), with_sphere({dumbbell()}), bodies, law);
    if (!clumps) world.shapes.clear();
    const double before = world.rigid.energy(world);
    const Diagnostics start = diagnose(world);
    advance(world, h, 1, {.tolerance = 1e-6});
    const Diagnostics now = diagnose(world);
    const double opened = world.rigid.energy(world) - before;
    EXPECT_GT(opened, law.cohesion * law.cohesion_range);
    EXPECT_NEAR(now.corrections - start.corrections, opened, 1e-6 * opened) << clumps;
  }
}

TEST(Ledger, books_the_bonds_that_a_correction_closes) {
  // The middle one is pushed by half of its overlap into the range of the third.
  const ContactLaw law{.cohesion = 40, .cohesion_range = 0.025};
  const double overlap = 0.01, gap = 0.026;
  Lab world = make_world(testing_world(),
                         {{.position = {0, 0, 0}},
                          {.position = {2 - overlap, 0, 0}},
                          {.position = {4 - overlap + gap, 0, 0}}},
                         law);
  const double before = world.rigid.energy(world);
  EXPECT_NEAR(before, -law.cohesion * (law.cohesion_range + overlap), 1e-12 * law.cohesion);
  advance(world, 1e-7, 1);
  const double opened = world.rigid.energy(world) - before;
  EXPECT_LT(opened, 0.7 * law.cohesion * overlap);
  EXPECT_NEAR(diagnose(world).corrections, opened, 1e-9 * law.cohesion);
}

TEST(Ledger, of_cohesion_as_an_impulse_has_no_bonds) {
  // What it takes from bodies that part is dissipated, whatever the step.
  const ContactLaw law{.cohesion = 3, .cohesion_range = 1, .cohesion_law = CohesionLaw::impulse};
  for (const double h : {0.01, 0.001}) {
    Lab world = make_world(alone(),
                           {{.mass = 2, .velocity = {-4, 0, 0}},
                            {.mass = 2, .position = {2, 0, 0}, .velocity = {4, 0, 0}}},
                           law);
    const Diagnostics before = diagnose(world);
    advance(world, h, 2);
    const Diagnostics now = diagnose(world);
    EXPECT_EQ(world.rigid.energy(world), 0);
    EXPECT_NEAR(now.dissipated, before.kinetic - now.kinetic, 1e-12 * before.kinetic);
    EXPECT_GT(now.dissipated, before.kinetic / 2);
  }
}

TEST(Ledger, closes_for_a_ball_that_bounces_in_a_uniform_field) {
  // Between impacts and in them kinetic energy + height + what was dissipated stays, when
  // velocities are brought to the instant of the positions by the kick's work (half of it is still
  // to come).
  const double m = 2, r = 0.5, g = 9.8, drop = 3;
  std::vector<double> errors;
  for (double h : {2e-3, 1e-3, 5e-4}) {
    Lab world = make_world(alone(), {{.radius = r, .mass = m, .position = {0, 0, r + drop}}},
                           {.restitution = 0.6});
    world.planes = {floor_plane};
    world.uniform_gravity = {0, 0, -g};
    double worst = 0;
    for (int k = 0; k * h < 2; ++k) {
      evaluate_field(world);
      const Diagnostics sums = diagnose(world);
      const double potential = world.kick.potential;
      const StepReport report = nonsmooth_step(world, h, solved_exactly(), 1);
      const GravityKick& kick = world.kick;
      const double lag =
          kick.closed > 0 ? report.gravity_work * kick.closed / (kick.closed + kick.interval) : 0;
      const double energy = sums.kinetic + potential + lag + sums.dissipated - sums.corrections;
      worst = std::max(worst, std::abs(energy - m * g * (r + drop)));
    }
    errors.push_back(worst / (m * g * drop));
  }
  // An impact falls anywhere in a step: the height at which it is met is off by up to v h.
  EXPECT_LT(errors[0], 3 * 2e-3);
  EXPECT_LT(errors[2], errors[0] / 2);
}

// Going on -----------------------------------------------------------------------------------

std::map<std::string, double> physics_of(const RestartState& state) {
  std::map<std::string, double> kept;
  for (const auto& [name, value] : state.scalars)
    if (!name.starts_with("seconds.")) kept[name] = value;
  return kept;
}

const std::string fall = R"(
[materials.rock]
density = "1600 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
cohesion = "0.01 N"
cohesion_range = "1 cm"
[gravity]
method = "direct"
[[groups]]
name = "cloud"
material = "rock"
volume = {shape = "sphere", radius = "6 m"}
packing = {kind = "random", radius = "1 m", count = 40}
[[phases]]
name = "fall"
step = "5 s"
duration = "2000 s"
)";

TEST(Simulation, saved_between_two_kicks_of_gravity_goes_on_with_the_same_bits) {
  const Case scene = parse_case(fall, "fall.toml");
  const Comm comm = testing_world();
  Simulation first(comm, Scene(std::make_shared<Case>(scene)));
  first.begin_phase();
  const auto balance = [&](Simulation& run) {
    evaluate_field(run.world());
    return run.account().balance(diagnose(run.world()), run.world().kick.potential, 0);
  };
  balance(first);
  for (int k = 0; k < 200; ++k) first.advance(1 << 30, false);
  while (first.synchronous()) first.advance(1 << 30, false);
  ASSERT_GT(first.world().kick.steps_left, 0);
  ASSERT_GT(diagnose(first.world()).dissipated, 0);
  RestartState state = first.save();
  const RestartState copy = state;
  Simulation second(comm, Scene(std::make_shared<Case>(scene)), copy);
  first.go_on(state);
  const auto to_next_kicks = [](Simulation& run) {
    for (int k = 0; k < 60 || !run.synchronous(); ++k) run.advance(1 << 30, false);
  };
  to_next_kicks(first);
  to_next_kicks(second);
  const Balance one = balance(first), two = balance(second);
  EXPECT_EQ(one.unexplained_energy, two.unexplained_energy);
  EXPECT_EQ(one.momentum_drift, two.momentum_drift);
  EXPECT_EQ(one.angular_momentum_drift, two.angular_momentum_drift);
  const RestartState a = first.save(), b = second.save();
  EXPECT_EQ(physics_of(a), physics_of(b));
  EXPECT_EQ(a.clock.time, b.clock.time);
  EXPECT_EQ(a.clock.step_in_phase, b.clock.step_in_phase);
  EXPECT_EQ(a.bodies.id, b.bodies.id);
  EXPECT_EQ(a.bodies.position, b.bodies.position);
  EXPECT_EQ(a.bodies.velocity, b.bodies.velocity);
  EXPECT_EQ(a.bodies.angular_velocity, b.bodies.angular_velocity);
  EXPECT_EQ(a.bodies.acceleration, b.bodies.acceleration);
}

TEST(Stages, stay_where_timers_book_them_while_a_state_is_kept) {
  const Comm comm = testing_world();
  const Case scene = parse_case(fall, "fall.toml");
  Simulation simulation(comm, Scene(std::make_shared<Case>(scene)));
  StageUses& stages = simulation.world().stages;
  for (const char* name : {"a", "b", "c", "d", "e", "f"}) stages[name].seconds = name[0];
  const auto places = [&] {
    std::map<std::string, const StageUse*> found;
    for (const auto& [stage, use] : stages) found[stage] = &use;
    return found;
  };
  const auto before = places();
  const StageUses uses = stages;
  simulation.save();
  EXPECT_EQ(before, places());
  for (const auto& [stage, use] : uses) EXPECT_EQ(use.seconds, stages[stage].seconds) << stage;
}

TEST(World, brings_each_scalar_back_into_its_own_place) {
  World saved, loaded;
  double next = 1;
  World::for_each_scalar(saved, [&]<class T>(const std::string&, T& value) {
    value = static_cast<T>(std::is_same_v<T, bool> ? 1 : next++);
  });
  Scalars scalars;
  save_scalars(saved, scalars);
  std::size_t count = 0;
  World::for_each_scalar(saved, [&](const std::string&, auto) { ++count; });
  EXPECT_EQ(scalars.size(), count) << "two have one name";
  load_scalars(loaded, scalars);
  EXPECT_EQ(loaded.kick.interval, saved.kick.interval);
  EXPECT_EQ(loaded.kick.closed, saved.kick.closed);
  EXPECT_EQ(loaded.kick.remembered_load, saved.kick.remembered_load);
  EXPECT_EQ(loaded.kick.steps_left, saved.kick.steps_left);
  EXPECT_EQ(loaded.kick.potential, saved.kick.potential);
  EXPECT_EQ(loaded.ledger.dissipated, saved.ledger.dissipated);
  EXPECT_EQ(loaded.ledger.cohesion_work, saved.ledger.cohesion_work);
  EXPECT_EQ(loaded.ledger.corrections, saved.ledger.corrections);
  EXPECT_EQ(loaded.ledger.own_work, saved.ledger.own_work);
}

}  // namespace
}  // namespace spall
