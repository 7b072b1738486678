// Bodies that may go by longer steps act once a stride of several parts.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>
#include <span>
#include <utility>

#include "copper_pieces.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// s: how long sound takes across a spacing.
const double crossing = d / ductile.sound_speed();

/// A ball hits a plate, coarser than itself by `coarser`, at `speed` (m/s). It comes from `far` (m)
/// farther away than where both see each other.
std::vector<Sphere> shot(double speed, double coarser, double far) {
  auto plate = crystal(
      coarser * d, copper.density, turn({0.4, 0.2, -0.7}), 9 * d,
      [](const Vec3& x) { return std::abs(x.z()) < 2.5 * d && std::hypot(x.x(), x.y()) < 9 * d; });
  const double mass = copper.density * volume_of_lattice(d);
  for (Sphere s : ball(d, copper.density, turned, 2.2 * d)) {
    s.position.z() += 5.2 * d + far;
    s.velocity.z() = -speed;
    s.mass = mass;
    plate.push_back(s);
  }
  return plate;
}
Lab world_of_shot(const Comm& comm, double speed, const SolidLaw& law,
                  double courant = usual_courant, double coarser = 1.5, double far = 0) {
  Lab world = world_of(comm, shot(speed, coarser, far), law);
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.group[b] = 2 * world.bodies.radius[b] > 1.1 * d ? 0 : 1;
  world.solid.courant = courant;
  return world;
}

/// Of all ranks.
double acts(const Lab& world) {
  return world.comm.sum(static_cast<double>(world.solid.acts));
}
double acting_share(const Lab& world) {
  const double all = world.comm.sum(static_cast<double>(world.bodies.owned));
  return acts(world) / (all * world.solid.parts);
}

/// Of the shot that has warmed the plate; `wide` (m): how far from the origin its bodies were.
void expect_kept_in_shot(const Lab& world, const Sums& before, double wide) {
  const Sums after = sums_of(world);
  const double p = before.momentum.norm();
  EXPECT_LE((after.momentum - before.momentum).norm(), 1e-12 * p);
  EXPECT_LE((after.angular - before.angular).norm(), 1e-12 * p * wide);
  EXPECT_GT(after.heat, 0.2 * before.kinetic);
  EXPECT_NEAR(after.kinetic + after.internal, before.kinetic, 0.01 * before.kinetic);
}

TEST(Strides, few_bodies_act_in_most_parts_where_a_shot_is_fast) {
  Lab world = world_of_shot(testing_world(), 4000, ductile);
  solid_steps(world, 3 * crossing, 1);
  EXPECT_LT(acting_share(world), 0.6);
  Lab slow = world_of_shot(testing_world(), 1, ductile, usual_courant, 1);
  solid_steps(slow, 3 * crossing, 1);
  EXPECT_EQ(acting_share(slow), 1);
}

TEST(Strides, keep_momenta_and_energy) {
  const double speed = 4000;
  Lab world = world_of_shot(testing_world(), speed, ductile);
  const Sums before = sums_of(world);
  for (int k = 0; k < 4; ++k) solid_steps(world, crossing, 2);
  EXPECT_LT(acting_share(world), 0.7);
  expect_kept_in_shot(world, before, 9 * d);
}

TEST(Strides, energy_error_is_of_second_order) {
  std::vector<double> errors;
  for (const double courant : {0.2, 0.1, 0.05}) {
    Lab world = world_of_shot(testing_world(), 1500, elastic, courant);
    const double before = sums_of(world).kinetic;
    solid_steps(world, 4 * crossing, 1);
    EXPECT_LT(acting_share(world), 0.9);
    const Sums after = sums_of(world);
    const double elastic_energy = world.solid.energy(world);  // of contacts, too
    errors.push_back(std::abs(after.kinetic + after.heat + elastic_energy - before) / before);
  }
  EXPECT_LT(errors[0], 0.01);
  for (int k = 0; k < 2; ++k) EXPECT_GT(std::log2(errors[k] / errors[k + 1]), 1.5) << k;
}

/// Owned bodies' neighbours in their piece that the inner list lacks, and all of them.
std::pair<int, int> lacking_neighbours(const Lab& world) {
  const Elastoplastic& engine = world.solid;
  const PiecePairs& pairs = engine.pairs;
  const Bodies& bodies = world.bodies;
  if (pairs.slots.empty()) return {0, 0};
  const std::size_t lanes = pairs.rows.size() / pairs.slots.size();  // of the instructions in use
  std::set<std::pair<Index, Index>> listed;
  const Index* partners = pairs.inner_partners.data();
  for (std::size_t g = 0; g < pairs.slots.size(); ++g)
    for (Index s = 0; s < pairs.inner_slots[g]; ++s, partners += lanes)
      for (std::size_t l = 0; l < lanes; ++l)
        listed.insert(
            std::minmax(pairs.rows[g * lanes + l] / doubles_a_row, partners[l] / doubles_a_row));
  int lacking = 0, all = 0;
  for (Index i = 0; i < bodies.owned; ++i)
    for (Index j = i + 1; j < bodies.size(); ++j) {
      const auto group = static_cast<std::size_t>(bodies.group[i]);
      if (!engine.rests.empty() && engine.rests[group]) continue;
      const Vec3 x = vector_of(engine.rows[j].place - engine.rows[i].place);
      if (bodies.group[i] != bodies.group[j] || x.norm() >= engine.reach[i]) continue;
      ++all;
      lacking += !listed.contains({i, j});
    }
  return {lacking, all};
}

TEST(Strides, inner_lists_lack_no_neighbour) {
  Lab shot = world_of_shot(testing_world(), 4000, ductile);
  // What meets in the second scene is of one piece, so nothing warns of it but its pairs. It comes
  // from beyond their reach, by the whole of the speed that lists reckon with.
  auto halves = two_balls(2000);
  for (Sphere& s : halves) s.position.x() -= 0.6 * d * (s.velocity.x() > 0 ? 1 : -1);
  Lab one_piece = world_of(testing_world(), halves, ductile);
  // In the third one something else is faster, so that what has moved is looked at before the next
  // search.
  halves.push_back({.radius = d / 2,
                    .mass = halves[0].mass,
                    .position = 40 * d * Vec3::UnitY(),
                    .velocity = 16000 * Vec3::UnitY()});
  Lab with_another = world_of(testing_world(), halves, ductile);
  for (Lab* scene : {&shot, &one_piece, &with_another}) {
    Lab& world = *scene;
    world.solid.courant = usual_courant;
    double kept = 0, listed = 0;
    for (int k = 0; k < 100; ++k) {
      solid_steps(world, 0.04 * crossing, 1);
      const auto [lacking, all] = lacking_neighbours(world);
      EXPECT_EQ(lacking, 0) << k << ", of " << all;
      kept += static_cast<double>(world.solid.pairs.inner_partners.size());
      listed += static_cast<double>(world.solid.pairs.partners.size());
    }
    EXPECT_LT(world.comm.sum(kept), 0.8 * world.comm.sum(listed));
  }
}

/// A crystal under pressure that fills a periodic space, at rest. A layer of it is lighter, so
/// that its sound is four times as fast.
Lab pressed_crystal(double courant) {
  const double closer = 0.97;
  const int cells = 6;
  const double a = closer * std::sqrt(2.0) * d, edge = cells * a;
  SolidLaw light = elastic;
  light.density /= 16;
  std::vector<Sphere> spheres;
  for (int i = 0; i < 2 * cells; ++i)
    for (int j = 0; j < 2 * cells; ++j)
      for (int k = 0; k < 2 * cells; ++k)
        if ((i + j + k) % 2 == 0)
          spheres.push_back({.radius = d / 2, .mass = 1, .position = a / 2 * Vec3(i, j, k)});
  Lab world = world_of(testing_world(), spheres, elastic);
  world.solid.laws.push_back(light);
  world.materials.push_back({.name = "light"});
  world.solid.courant = courant;
  world.period.size = Vec3::Constant(edge);
  Bodies& bodies = world.bodies;
  const double x = 1 / (closer * closer * closer), cell = volume_of_lattice(d);
  for (Index b = 0; b < bodies.owned; ++b) {
    bodies.material[b] = bodies.position[b].z() < 1.2 * a ? 1 : 0;
    bodies.mass[b] = cell * world.solid.laws[bodies.material[b]].density;
    bodies.compression[b] = x;
    bodies.pressure[b] = elastic.cold.at(x).pressure;
    bodies.internal_energy[b] = cell * elastic.cold.at(x).energy;
  }
  return world;
}

TEST(Strides, warm_nothing_that_is_at_rest_under_pressure) {
  std::vector<double> errors;
  for (const double courant : {0.2, 0.1}) {
    Lab world = pressed_crystal(courant);
    const double before = sums_of(world).internal;
    solid_steps(world, 16 * crossing, 1);
    EXPECT_LT(acting_share(world), 0.6);
    const Sums after = sums_of(world);
    errors.push_back(std::abs(after.kinetic + after.internal - before) / before);
    EXPECT_LT(after.heat, 0.03 * before);
  }
  EXPECT_LT(errors[0], 0.04);
  EXPECT_GT(std::log2(errors[0] / errors[1]), 1.5);
}

TEST(Strides, slow_bodies_are_strained_by_all_that_moves_within_them) {
  // Bodies that are held to a motion; a cap is lighter, so that its sound is faster.
  auto spheres = ball(d, elastic.density, turned, 4.2 * d);
  for (Sphere& s : spheres) s.mass = infinity;
  Lab world = world_of(testing_world(), spheres, elastic);
  SolidLaw light = elastic;
  light.density /= 16;
  world.solid.laws.push_back(light);
  world.materials.push_back({.name = "light"});
  world.solid.courant = usual_courant;
  Bodies& bodies = world.bodies;
  const double strain = -0.02, lasts = 8 * crossing;
  for (Index b = 0; b < bodies.owned; ++b) {
    bodies.material[b] = bodies.position[b].z() > 2 * d ? 1 : 0;
    bodies.velocity[b] = strain / lasts * bodies.position[b];
  }
  solid_steps(world, lasts, 1);
  EXPECT_LT(acting_share(world), 0.8);
  const double dense = std::pow(1 + strain, -3);
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.position[b].norm() > 2 * d) continue;
    EXPECT_NEAR(bodies.compression[b], dense, 1e-3 * (dense - 1)) << bodies.material[b];
  }
}

TEST(Strides, what_nothing_has_reached_is_at_rest_to_the_last_bit) {
  Lab world = world_of_shot(testing_world(), 4000, ductile);
  std::vector<Vec3> places;
  solid_steps(world, 0.05 * crossing, 4);
  Index still = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) {
    if (world.bodies.group[b] != 0 || world.bodies.position[b].z() > -d) continue;
    still += world.bodies.velocity[b].isZero(0) && world.bodies.pressure[b] == 0;
  }
  EXPECT_GT(world.comm.sum(static_cast<double>(still)), 0);
}

TEST(Strides, motion_is_the_same_on_any_number_of_ranks) {
  Lab one = world_of_shot(alone(), 4000, ductile),
      many = world_of_shot(testing_world(), 4000, ductile);
  for (int step = 0; step < 2; ++step) {
    solid_steps(one, crossing, 1);
    solid_steps(many, crossing, 1);
  }
  EXPECT_EQ(one.solid.parts, many.solid.parts);
  EXPECT_EQ(acts(one), acts(many));
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-9 * d) << k;
}

TEST(Strides, a_period_changes_nothing_for_what_does_not_reach_across_it) {
  Lab free = world_of_shot(testing_world(), 4000, ductile),
      wrapped = world_of_shot(testing_world(), 4000, ductile);
  const double edge = 60 * d;
  wrapped.period.size = Vec3::Constant(edge);
  // The border cuts the plate.
  wrapped.period.low = Vec3(0.3 * d, -edge / 2, -edge / 2);
  for (Lab* world : {&free, &wrapped}) solid_steps(*world, 2 * crossing, 1);
  EXPECT_EQ(acts(free), acts(wrapped));
  const auto p = spheres_of(free), q = spheres_of(wrapped);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - wrapped.period.nearest(q[k].position, p[k].position)).norm(),
              1e-9 * d)
        << k;
}

/// The shot from far away; where it does not rest the plate is warm, by too little to matter.
Lab world_from_far(double courant, bool rests) {
  Lab world = world_of_shot(testing_world(), 4000, ductile, courant, 1.5, 5 * d);
  for (Index b = 0; b < world.bodies.owned && !rests; ++b)
    if (world.bodies.group[b] == 0) world.bodies.heat[b] = 1e-290;
  return world;
}
double bodies_of(const Lab& world, int group) {
  return world.comm.sum(static_cast<double>(std::ranges::count(
      world.bodies.group.begin(), world.bodies.group.begin() + world.bodies.owned, group)));
}

TEST(Rest, a_plate_does_not_act_before_anything_is_near_and_then_as_if_it_had) {
  Lab rests = world_from_far(0, true), acting = world_from_far(0, false);
  const double h = 0.04 * crossing;
  solid_steps(rests, h, 10);
  solid_steps(acting, h, 10);
  EXPECT_EQ(acts(rests), 10 * bodies_of(rests, 1));
  EXPECT_EQ(acting_share(acting), 1);
  solid_steps(rests, h, 200);
  solid_steps(acting, h, 200);
  EXPECT_GT(acts(rests), 210.0 * bodies_of(rests, 1));  // the plate acts by now
  const auto p = spheres_of(rests), q = spheres_of(acting);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-9 * d) << k;
}

TEST(Rest, what_wakes_within_a_stride_keeps_momenta_and_energy) {
  Lab world = world_from_far(usual_courant, true);
  const Sums before = sums_of(world);
  solid_steps(world, 2 * crossing, 1);
  EXPECT_EQ(acts(world), world.solid.parts * bodies_of(world, 1));
  for (int k = 0; k < 5; ++k) solid_steps(world, 2 * crossing, 1);
  expect_kept_in_shot(world, before, 14 * d);
}

TEST(Rest, what_is_set_in_motion_between_steps_acts) {
  Lab world = world_from_far(usual_courant, true);
  solid_steps(world, 0.1 * crossing, 1);
  for (Index b = 0; b < world.bodies.owned; ++b)
    if (world.bodies.group[b] == 0 && world.bodies.id[b] % 7 == 0) world.bodies.velocity[b].x() = 1;
  const double before = sums_of(world).momentum.x();
  solid_steps(world, 0.1 * crossing, 1);  // sooner than pairs are found again for the ball's sake
  EXPECT_NEAR(sums_of(world).momentum.x(), before, 1e-12 * sums_of(world).momentum.norm());
  double most = 0, others = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) {
    if (world.bodies.group[b] != 0) continue;
    const double u = std::abs(world.bodies.velocity[b].x());
    double& fastest = world.bodies.id[b] % 7 == 0 ? most : others;
    fastest = std::max(fastest, u);
  }
  EXPECT_LT(world.comm.max(most), 1);
  EXPECT_GT(world.comm.max(others), 0);
}

TEST(Rest, what_is_heated_between_steps_acts) {
  for (const double courant : {0.0, usual_courant}) {
    Lab world = world_from_far(courant, true);
    solid_steps(world, 0.04 * crossing, 1);
    for (Index b = 0; b < world.bodies.owned; ++b)
      if (world.bodies.group[b] == 0 && world.bodies.id[b] % 7 == 0)
        world.bodies.internal_energy[b] = 1;
    solid_steps(world, 0.04 * crossing, 2);
    double pressed = 0, moving = 0;
    for (Index b = 0; b < world.bodies.owned; ++b) {
      if (world.bodies.group[b] != 0) continue;
      pressed = std::max(pressed, world.bodies.pressure[b]);
      moving = std::max(moving, world.bodies.velocity[b].norm());
    }
    EXPECT_GT(world.comm.max(pressed), 0) << courant;
    EXPECT_GT(world.comm.max(moving), 0) << courant;
  }
}

TEST(Rest, a_force_that_comes_later_acts_as_from_the_start) {
  for (const double courant : {0.0, usual_courant}) {
    const double h = 0.1 * crossing, a = 1e7;
    const auto block = ball(turned, 3 * d);
    Lab later = world_of(testing_world(), block, ductile),
        at_once = world_of(testing_world(), block, ductile);
    later.solid.courant = at_once.solid.courant = courant;
    const auto pull = [&](const Bodies& bodies, std::span<Vec3> force) {
      for (std::size_t b = 0; b < force.size(); ++b)
        if (bodies.position[b].x() > 0) force[b].x() += a * bodies.mass[b];
    };
    solid_steps(later, h, 1);
    EXPECT_EQ(acts(later), 0);
    for (Lab* world : {&later, &at_once}) {
      world->own_forces.emplace_back(pull);
      solid_steps(*world, h, 3);
    }
    const auto p = spheres_of(later), q = spheres_of(at_once);
    for (std::size_t k = 0; k < p.size(); ++k)
      EXPECT_LE((p[k].position - q[k].position).norm(), 1e-12 * d) << k;
    EXPECT_GT(sums_of(later).momentum.x(), 0);
  }
}

TEST(Strides, a_field_and_a_force_of_one_s_own_act_for_the_whole_time) {
  const double g = 1e7, lasts = 1.5 * crossing;
  for (const bool own : {true, false}) {
    Lab world = world_of_shot(testing_world(), 4000, ductile);
    double mass = 0;
    for (Index b = 0; b < world.bodies.owned; ++b) mass += world.bodies.mass[b];
    mass = world.comm.sum(mass);
    if (own)
      world.own_forces.emplace_back([&](const Bodies& bodies, std::span<Vec3> force) {
        for (std::size_t b = 0; b < force.size(); ++b) force[b].x() += g * bodies.mass[b];
      });
    else
      world.uniform_gravity = {g, 0, 0};
    const double before = sums_of(world).momentum.x();
    solid_steps(world, lasts / 3, 3);
    EXPECT_LT(acting_share(world), 0.8);
    EXPECT_NEAR(sums_of(world).momentum.x() - before, mass * g * lasts, 1e-10 * mass * g * lasts)
        << own;
  }
}

}  // namespace
}  // namespace spall
