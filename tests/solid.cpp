// Solids with a stress a body: constants, rotation, conservation, order, ranks, yield, refusals.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <optional>
#include <random>

#include "copper_pieces.hpp"
#include "output/diagnostics.hpp"
#include "scene/packing.hpp"
#include "scene/scene.hpp"
#include "solid/contacts.hpp"
#include "solid/flow_stress.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// Of grains of five spacings.
std::vector<Sphere> polycrystal(double radius) {
  std::vector<Sphere> spheres;
  place_grains(LatticeKind::fcc, {.shape = Shape::sphere, .radius = radius},
               {.radius = d / 2, .grain = 5 * d}, 1, [&](const Vec3& site) {
                 spheres.push_back({.radius = d / 2,
                                    .mass = copper.density * d * d * d / std::sqrt(2.0),
                                    .position = site});
               });
  return spheres;
}

// --- elastic ---

TEST(SolidStep, has_the_moduli_of_the_material_along_every_direction) {
  Eigen::Matrix3d strains[3] = {Vec3(1, 0, 0).asDiagonal(), Vec3(1, 1, 1).asDiagonal(), {}};
  strains[2] << 0, 1, 0, 1, 0, 0, 0, 0, 0;
  const auto has_its_moduli = [&](const Solid& solid, std::vector<Sphere> spheres,
                                  const Eigen::Matrix3d& strain) {
    const double h = 1e-8, size = 1e-5;
    for (Sphere& s : spheres) {
      s.mass *= solid.density / copper.density;
      s.velocity = size / h * (strain * s.position);
    }
    Lab world = world_of(testing_world(), spheres, solid_law(solid, false, "solid"));
    solid_steps(world, h, 1);
    const double trace = size * strain.trace();
    const Eigen::Matrix3d expected =
        (solid.bulk_modulus() - 2.0 / 3 * solid.shear_modulus()) * trace * as_is +
        2 * solid.shear_modulus() * size * strain;
    EXPECT_LE((stress_of_the_middle(world) - expected).norm(), 1e-3 * expected.norm());
  };
  for (const Solid& solid : {copper, *material_of_library("aluminium_6061_t6").solid,
                             *material_of_library("steel_4340").solid})
    for (const auto& whole : {ball(as_is, 4.2 * d), ball(turned, 4.2 * d), polycrystal(4.2 * d)})
      for (const Eigen::Matrix3d& strain : strains) has_its_moduli(solid, whole, strain);
}

TEST(SolidStep, waves_run_at_the_material_s_speeds_along_every_direction) {
  const double pressed = elastic.sound_speed(),
               sheared = std::sqrt(copper.shear_modulus() / copper.density);
  const struct {
    std::optional<Eigen::Matrix3d> orientation;  // none: of many grains
    Vec3 direction, motion;
    double speed;
  } waves[] = {{as_is, {1, 0, 0}, {1, 0, 0}, pressed},  {as_is, {1, 1, 0}, {1, 1, 0}, pressed},
               {as_is, {1, 1, 1}, {1, 1, 1}, pressed},  {turned, {1, 0, 0}, {1, 0, 0}, pressed},
               {as_is, {1, 0, 0}, {0, 1, 0}, sheared},  {as_is, {1, 1, 0}, {1, -1, 0}, sheared},
               {turned, {0, 1, 0}, {0, 0, 1}, sheared}, {{}, {1, 0, 0}, {1, 0, 0}, pressed},
               {{}, {0, 1, 0}, {0, 0, 1}, sheared}};
  for (const auto& wave : waves) {
    // A standing wave: its crest, in the middle of a ball, falls through zero after a quarter of a
    // period; a pressure wave from the ball's surface is not heard of before.
    const double length = 22 * d, amplitude = 1e-5 * d;
    const double radius = 0.27 * length * pressed / wave.speed + 3 * d;
    const Vec3 q = 2 * pi / length * wave.direction.normalized(), along = wave.motion.normalized();
    auto spheres = wave.orientation ? ball(*wave.orientation, radius) : polycrystal(radius);
    const double speed = amplitude * 2 * pi / length * wave.speed;
    // It starts flat, with velocities: the stress of the start is none.
    for (Sphere& s : spheres) s.velocity = speed * std::cos(q.dot(s.position)) * along;
    Lab world = world_of(testing_world(), spheres, elastic);
    const auto velocity = [&] {
      const auto v = of_the_middle(world, [&](const Bodies& bodies, Index b) {
        return std::vector<double>{bodies.velocity[b].dot(along)};
      });
      return v[0];
    };
    const double h = 0.1 * d / pressed;
    double before = velocity(), now = before, time = 0;
    while (now > 0 && time < length / wave.speed) {
      solid_steps(world, h, 1);
      before = now;
      now = velocity();
      time += h;
    }
    const double quarter = time - h * now / (now - before);
    // A gradient of neighbours sees less of a short wave: 22 spacings run 1.4 % slower. Borders of
    // grains are softer than crystals: what single bodies do beside the mean has no stiffness.
    const double most = wave.orientation ? 0.02 : 0.15;
    EXPECT_NEAR(length / (4 * quarter), wave.speed, most * wave.speed)
        << wave.direction.transpose() << " " << wave.motion.transpose();
  }
}

TEST(SolidStep, stress_turns_with_the_body) {
  auto spheres = ball(as_is, 4.2 * d);
  const double h = 1e-9;
  const Vec3 spin = 0.005 / h * Vec3(0.2, -0.5, 0.8).normalized();
  for (Sphere& s : spheres) s.velocity = spin.cross(s.position);
  Lab world = world_of(testing_world(), spheres, elastic);
  for (Index b = 0; b < world.bodies.owned; ++b) {
    world.bodies.direct_stress[b] = {2e9, -3e9, 1e9};
    world.bodies.shear_stress[b] = {0, 4e9, 0};
  }
  Eigen::Matrix3d stress;
  stress << 2e9, 0, 4e9, 0, -3e9, 0, 4e9, 0, 1e9;
  solid_steps(world, h, 1);
  const Eigen::Matrix3d R = turn(h * spin);
  Eigen::Matrix3d after = stress_of_the_middle(world);
  after -= after.trace() / 3 * as_is;  // chords are longer than arcs: it has grown a little
  EXPECT_LE((after - R * stress * R.transpose()).norm(), 5e-4 * stress.norm());
  EXPECT_GE((after - stress).norm(), 0.004 * stress.norm());
}

TEST(SolidStep, a_spinning_block_keeps_energy_and_angular_momentum) {
  auto spheres =
      crystal(as_is, 3 * d, [](const Vec3& x) { return x.cwiseAbs().maxCoeff() < 2.3 * d; });
  const double rate = 0.01 * elastic.sound_speed() / (2.3 * d);
  for (Sphere& s : spheres) s.velocity = rate * Vec3::UnitZ().cross(s.position);
  Lab world = world_of(testing_world(), spheres, elastic);
  const Sums before = sums_of(world);
  solid_steps(world, 0.1 * d / elastic.sound_speed(), 2000);  // half a radian and more
  const Sums after = sums_of(world);
  EXPECT_LE((after.angular - before.angular).norm(), 1e-11 * before.angular.norm());
  EXPECT_NEAR(after.kinetic + after.internal, before.kinetic, 1e-3 * before.kinetic);
  EXPECT_NEAR(after.kinetic, before.kinetic, 0.01 * before.kinetic);
}

TEST(SolidStep, momenta_and_energy_are_kept_where_pieces_meet_and_yield) {
  const double speed = 300;
  Lab world = world_of_two(testing_world(), speed, ductile);
  const Sums before = sums_of(world);
  solid_steps(world, 0.1 * d / ductile.sound_speed(), 150);
  expect_kept(world, before, speed);
}

TEST(SolidStep, shapes_are_sums_over_the_neighbours_that_a_body_sees) {
  Lab world = world_of_two(testing_world(), 1000, ductile);
  for (Index b = 0; b < world.bodies.owned; ++b)
    if (world.bodies.id[b] % 5 == 0) world.bodies.damage[b] = 1;
  solid_steps(world, 0.1 * d / ductile.sound_speed(), 60);
  double most = 0;
  const Elastoplastic& engine = world.solid;
  for (Index i = 0; i < world.bodies.owned; ++i) {
    Mat3 K = Mat3::Zero(), M = Mat3::Zero();
    double S = 0, sum_of_S = 0;
    const MotionRow& at = engine.rows[i];
    for (Index j = 0; j < world.bodies.size(); ++j) {
      const MotionRow& its = engine.rows[j];
      const Vec3 x = vector_of(its.place - at.place), v = vector_of(its.motion - at.motion);
      const double share = x.norm() / engine.reach[i];
      const bool failed = std::isinf(at.motion[3]), its_failed = std::isinf(its.motion[3]);
      if (i == j || share >= 1 || world.bodies.group[i] != world.bodies.group[j]) continue;
      if (its_failed && !failed) continue;
      const double weight = neighbour_weight(share) * its.place[3];
      K += weight * x * x.transpose();
      M += weight * v * x.transpose();
      if (failed || its_failed) continue;
      S += weight * x.squaredNorm() * (its.motion[3] - at.motion[3]);
      sum_of_S += weight * x.squaredNorm() * std::abs(its.motion[3] - at.motion[3]);
    }
    const auto& sums = engine.shapes[i].at;
    const Mat3 found_K{{sums[0][0], sums[1][1], sums[1][0]},
                       {sums[1][1], sums[0][1], sums[0][3]},
                       {sums[1][0], sums[0][3], sums[0][2]}};
    const Mat3 found_M{{sums[1][2], sums[1][3], sums[2][0]},
                       {sums[2][1], sums[2][2], sums[2][3]},
                       {sums[3][0], sums[3][1], sums[3][2]}};
    EXPECT_LE((found_K - K).norm(), 1e-13 * K.norm());
    EXPECT_LE((found_M - M).norm(), 1e-12 * M.norm());
    EXPECT_NEAR(sums[3][3], S, 1e-12 * sum_of_S);
    most = std::max(most, std::abs(S));
  }
  EXPECT_GT(world.comm.max(most), 0);  // they have met
}

/// Each two bodies once, in the first lane: the kernels' own lists may have other lanes than tests.
PiecePairs all_pairs(Index count) {
  PiecePairs pairs;
  for (Index i = 0; i < count; ++i) {
    const std::vector<Index> itself(pair_lanes, doubles_a_row * i);
    pairs.bodies.push_back(i);
    pairs.rows.insert(pairs.rows.end(), itself.begin(), itself.end());
    pairs.inner_slots.push_back(count - i - 1);
    for (Index j = i + 1; j < count; ++j) {
      pairs.inner_partners.insert(pairs.inner_partners.end(), itself.begin(), itself.end());
      pairs.inner_partners.end()[-static_cast<std::ptrdiff_t>(pair_lanes)] = doubles_a_row * j;
    }
  }
  pairs.windows = {{static_cast<std::size_t>(count), static_cast<std::size_t>(count)}};
  return pairs;
}

TEST(SolidStep, viscosity_only_warms_whatever_velocities_and_gradients_are) {
  auto spheres = two_balls(1);
  for (Sphere& s : spheres) s.position.x() -= 0.7 * d * (s.velocity.x() < 0 ? 1 : -1);
  Lab world = of_two(alone(), spheres, elastic);
  Elastoplastic& engine = world.solid;
  solid_steps(world, 1e-6 * d / elastic.sound_speed(), 1);
  ASSERT_FALSE(engine.contacts.pieces.empty());
  const PiecePairs pairs = all_pairs(world.bodies.owned);
  std::mt19937_64 random(5);
  std::normal_distribution<double> normal;
  double most = 0, least = 0;
  const auto look = [&](Index b) {
    most = std::max(most, engine.impulses[b][3]);
    least = std::min(least, engine.impulses[b][3]);
  };
  for (const bool contacts : {false, true}) {
    most = least = 0;
    for (int draw = 0; draw < 1000; ++draw) {
      for (ResponseRow& row : engine.responses) {
        for (int k = 0; k < 9; ++k) row.at[k / 4][k % 4] = 0;  // without stress
        for (int k = 9; k < 15; ++k) row.at[k / 4][k % 4] = normal(random) / d;
        for (int k = 0; k < 3; ++k) row.half_kick(k) = normal(random);
        row.act(0.5, 0.5);
      }
      std::ranges::fill(engine.impulses, PushRow{});
      if (contacts) {
        push_by_contacts(world, engine.laws, engine.contacts, 1, engine.rows.data(),
                         engine.responses.data(), engine.impulses.data());
        for (Index b = 0; b < world.bodies.owned; ++b) look(b);
      } else {
        sweep_forces(
            pairs, engine.reach.data(), engine.rows.data(), engine.responses.data(),
            engine.impulses.data(), [](Index) {}, look);
      }
    }
    EXPECT_GT(most, 0) << contacts;
    EXPECT_GE(least, 0) << contacts;
  }
}

TEST(SolidStep, energy_error_is_of_second_order) {
  std::vector<double> errors;
  for (int halvings = 0; halvings < 3; ++halvings) {
    Lab world = world_of(alone(), stirred_ball(), elastic);
    const double whole = 4 * d / elastic.sound_speed();
    const int steps = 40 << halvings;
    const double before = sums_of(world).kinetic;
    solid_steps(world, whole / steps, steps);
    const Sums after = sums_of(world);
    errors.push_back(std::abs(after.kinetic + after.internal - before) / before);
  }
  EXPECT_LT(errors[0], 0.01);
  for (int k = 0; k < 2; ++k) EXPECT_NEAR(std::log2(errors[k] / errors[k + 1]), 2, 0.5);
}

TEST(SolidStep, motion_is_the_same_on_any_number_of_ranks_and_after_a_restart) {
  Lab one = world_of_two(alone(), 300, ductile), many = world_of_two(testing_world(), 300, ductile);
  const double h = 0.1 * d / ductile.sound_speed();
  for (int part = 0; part < 2; ++part) {
    solid_steps(one, h, 40);
    solid_steps(many, h, 40);
    many.solid.restart_pairs(many, {});
  }
  const auto p = spheres_of(one), q = spheres_of(many);
  for (std::size_t k = 0; k < p.size(); ++k)
    EXPECT_LE((p[k].position - q[k].position).norm(), 1e-9 * d) << k;
}

TEST(SolidStep, pieces_push_each_other_and_never_pull) {
  auto spheres = ball(as_is, 1.9 * d);
  const std::size_t half = spheres.size();
  for (std::size_t k = 0; k < half; ++k) {
    Sphere other = spheres[k];
    other.position += Vec3(3.9 * d, 0, 0);
    other.velocity = {20, 0, 0};
    spheres.push_back(other);
  }
  Lab world = world_of(testing_world(), spheres, elastic);
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.group[b] = world.bodies.id[b] >= static_cast<BodyId>(half);
  solid_steps(world, 1e-8, 50);
  for (std::size_t k = 0; const Sphere& s : spheres_of(world))
    EXPECT_NEAR(s.velocity.x(), k++ < half ? 0 : 20, 1e-9);
}

TEST(SolidStep, walls_receive_the_momentum_that_a_piece_loses) {
  auto spheres = ball(turned, 3.2 * d);
  for (Sphere& s : spheres) s.velocity = {30, 0, -200};
  Lab world = world_of(testing_world(), spheres, ductile);
  world.planes = {{.point = {0, 0, -4 * d}}};
  const Sums before = sums_of(world);
  solid_steps(world, 0.3 * longest_step(ductile, d, 400), 1000);
  const Vec3 gained = sums_of(world).momentum - before.momentum;
  EXPECT_GT(gained.z(), -0.2 * before.momentum.z());
  EXPECT_LE((gained - diagnose(world).given_momentum).norm(), 1e-12 * before.momentum.norm());
}

TEST(SolidStep, pieces_meet_alike_whatever_the_axes_are_called) {
  // x, y, z become y, z, x: sums have another order, and nothing else changes.
  const auto positions = [](int shift) {
    auto spheres = ball(turned, 1.9 * d);
    const std::size_t half = spheres.size();
    for (std::size_t k = 0; k < half; ++k) {
      Sphere other = spheres[k];
      other.position += d * Vec3(4.0, 0.9, 0.4);
      other.velocity = {-300, -60, 90};
      spheres.push_back(other);
    }
    const auto renamed = [](const Vec3& v, int by) {
      return Vec3(v[(3 - by) % 3], v[(4 - by) % 3], v[(5 - by) % 3]);
    };
    for (Sphere& s : spheres) {
      s.position = renamed(s.position, shift);
      s.velocity = renamed(s.velocity, shift);
    }
    Lab world = world_of(alone(), spheres, elastic);
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.group[b] = world.bodies.id[b] >= static_cast<BodyId>(half);
    const double h = 0.1 * d / elastic.sound_speed();
    solid_steps(world, h, 60);
    std::vector<Vec3> found;
    for (const Sphere& s : spheres_of(world)) found.push_back(renamed(s.position, 3 - shift));
    EXPECT_GT(spheres_of(world)[half / 2].velocity.norm(), 1);  // it was hit
    return found;
  };
  const auto as_they_are = positions(0);
  for (int shift : {1, 2}) {
    const auto others = positions(shift);
    for (std::size_t k = 0; k < others.size(); ++k)
      EXPECT_LE((others[k] - as_they_are[k]).norm(), 1e-9 * d) << shift << " " << k;
  }
}

TEST(SolidStep, two_materials_with_two_spacings_keep_momenta_and_energy) {
  // A small ball of copper in a lattice half as wide flies against one of another metal.
  Solid light = copper;
  light.density = 2703;
  light.sound_speed = 5350;
  light.youngs_modulus = 68.9e9;
  light.poisson_ratio = 0.33;
  auto spheres = ball(turned, 3.2 * d);
  const std::size_t target = spheres.size();
  const double speed = 400, scale = 0.5;
  for (Sphere& s : spheres) s.mass *= light.density / copper.density;
  for (Sphere s : ball(as_is, 3.2 * d)) {
    s.radius *= scale;
    s.mass *= scale * scale * scale;
    s.position = scale * s.position + Vec3(0.2 * d, 0, 5.6 * d);
    s.velocity = {0, 0, -speed};
    spheres.push_back(s);
  }
  Lab world = world_of(testing_world(), spheres, ductile);
  world.solid.laws = {ductile, solid_law(light, true, "light")};
  world.materials = {{.name = "copper"}, {.name = "light"}};
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const bool flies = world.bodies.id[b] >= static_cast<BodyId>(target);
    world.bodies.group[b] = flies;
    world.bodies.material[b] = flies ? 0 : 1;
  }
  const Sums before = sums_of(world);
  const double momentum = 2 * before.kinetic / speed;
  solid_steps(world, 0.05 * d / elastic.sound_speed(), 500);
  const Sums after = sums_of(world);
  EXPECT_LE((after.momentum - before.momentum).norm(), 1e-12 * momentum);
  EXPECT_LE((after.angular - before.angular).norm(), 1e-12 * momentum * 5 * d);
  EXPECT_LT(after.kinetic, 0.8 * before.kinetic);  // they did meet
  const double contacts = world.solid.energy(world) - (after.internal - after.heat);
  EXPECT_NEAR(after.kinetic + after.internal + contacts, before.kinetic, 1e-2 * before.kinetic);
}

// --- plastic ---

TEST(SolidStep, flows_at_the_stress_of_johnson_and_cook) {
  auto spheres = ball(turned, 4.2 * d);
  const double h = 1e-8, size = 1e-2;
  for (Sphere& s : spheres)
    s.velocity = size / h * Vec3(s.position.x(), -s.position.y() / 2, -s.position.z() / 2);
  Lab world = world_of(testing_world(), spheres, ductile);
  solid_steps(world, h, 1);
  const Eigen::Matrix3d stress = stress_of_the_middle(world);
  const Eigen::Matrix3d deviator = stress - stress.trace() / 3 * as_is;
  const double mises = std::sqrt(1.5) * deviator.norm();
  const double strain = of_the_middle(world, [](const Bodies& bodies, Index b) {
    return std::vector<double>{bodies.plastic_strain[b]};
  })[0];
  const double whole = 2.0 / 3 * (std::log1p(size) - std::log1p(-size / 2));
  EXPECT_NEAR(strain, whole - mises / (3 * copper.shear_modulus()), 2e-3 * whole);
  const double flow = flow_stress_of(ductile, 0).at(strain, size / h).stress;
  EXPECT_NEAR(mises, flow, 0.01 * flow);
  EXPECT_NEAR(deviator(0, 0), 2.0 / 3 * mises, 0.01 * mises);
}

/// A ball that grows by this strain in a step: the middle after one and two steps.
struct Torn {
  Eigen::Matrix3d stress[2];
  double damage[2] = {};
};
Torn torn_by(double strain) {
  auto spheres = ball(as_is, 4.2 * d);
  const double h = 1e-8;
  for (Sphere& s : spheres) s.velocity = strain / h * s.position;
  Lab world = world_of(testing_world(), spheres, ductile);
  Torn torn;
  for (int step = 0; step < 2; ++step) {
    solid_steps(world, h, 1);
    torn.stress[step] = stress_of_the_middle(world);
    torn.damage[step] = of_the_middle(world, [](const Bodies& bodies, Index b) {
      return std::vector<double>{bodies.damage[b]};
    })[0];
  }
  return torn;
}

TEST(SolidStep, voids_take_what_tension_is_beyond_the_strength) {
  const Torn torn = torn_by(0.006);
  const double matter = 1 - copper.spall_strength / copper.bulk_modulus();
  const double voids = 1 - std::pow(1.006, -3) / matter;
  EXPECT_NEAR(torn.damage[0], voids / 0.25, 0.1 * voids / 0.25);
  // The tension of a step is that of the damage before it.
  const double tension = torn.stress[0].trace() / 3;
  EXPECT_LE(tension, 1.001 * copper.spall_strength);
  EXPECT_GE(tension, 0.999 * (1 - torn.damage[0]) * copper.spall_strength);
}

TEST(SolidStep, what_is_torn_and_hot_bears_no_tension_and_stays_hot) {
  // Matter stretched a tenfold, where the cold curve has no slope left.
  for (double energy = 1e5; energy < 3e7; energy *= 1.2) {  // J/kg
    Lab world = held_ball(d, ductile, 1);
    for (Index b = 0; b < world.bodies.owned; ++b)
      world.bodies.heat[b] = world.bodies.internal_energy[b] =
          energy * ductile.density * d * d * d / std::sqrt(2.0);
    for (int step = 0; step < 40; ++step) {
      deform(world, 0.05 * as_is, 1, 1);
      const auto middle = of_the_middle(world, [](const Bodies& bodies, Index b) {
        return std::vector<double>{bodies.pressure[b], bodies.heat[b], bodies.internal_energy[b]};
      });
      EXPECT_GE(middle[0], -1e-6 * copper.bulk_modulus()) << energy << " " << step;
      EXPECT_GE(middle[1], 0) << energy << " " << step;
      EXPECT_LE(middle[1], middle[2] * (1 + 1e-6)) << energy << " " << step;
    }
  }
}

TEST(SolidStep, what_is_torn_bears_no_tension_and_no_shear) {
  const Torn torn = torn_by(0.12);
  EXPECT_EQ(torn.damage[0], 1);
  EXPECT_LE(torn.stress[1].norm(), 1e-6 * copper.bulk_modulus());
}

void expect_to_slide(double softening) {
  Solid rubbing = copper;
  rubbing.rock.failed_friction = 0.3;
  rubbing.johnson_cook.m = softening;
  const SolidLaw law = solid_law(rubbing, true, "copper");
  Lab world = held_ball(d, law, 1);
  const double h = 1e-9;
  Eigen::Matrix3d shearing = Eigen::Matrix3d::Zero();
  shearing(0, 1) = 1;
  // Pressed, and pressed more, then less and less until nothing presses.
  for (double by : {0.0003, 0.0003, -0.0003, -0.0002, -0.0003}) {
    deform(world, -by / (20 * h) * as_is, h, 20);
    deform(world, 0.02 / (100 * h) * shearing, h, 100);
    const Eigen::Matrix3d stress = stress_of_the_middle(world);
    const double pressure = -stress.trace() / 3;
    const double mises = std::sqrt(1.5) * (stress + pressure * as_is).norm();
    const double rubs = std::sqrt(3.0) * 0.3 * std::max(0.0, pressure);
    // No more than what is whole bears: A, less what its heat takes.
    const double least = std::min(rubs, 0.95 * copper.johnson_cook.a);
    EXPECT_GE(mises, 0.999 * least - 1e-6 * copper.shear_modulus());
    EXPECT_LE(mises, std::min(1.001 * rubs, copper.johnson_cook.a) + 1e-6 * copper.shear_modulus());
    // What slid is heat, but for what shear and pressure still hold.
    if (pressure <= 0) continue;
    const double volume = d * d * d / std::sqrt(2.0);
    const double heat = of_the_middle_body(world, &Bodies::heat) / volume;
    const double held = of_the_middle_body(world, &Bodies::internal_energy) / volume - heat;
    const double cold = pressure - copper.gruneisen * heat;
    const double stored =
        mises * mises / (6 * copper.shear_modulus()) + cold * cold / (2 * copper.bulk_modulus());
    EXPECT_NEAR(held, stored, 0.01 * stored);
  }
}

TEST(SolidStep, what_is_torn_slides_where_it_is_pressed) {
  expect_to_slide(1.09);
  expect_to_slide(0.6);  // as of Armco iron, whose softening is steep at first
}

TEST(SolidStep, momenta_and_energy_are_kept_where_broken_pieces_rub) {
  const double speed = 300;
  Solid rubbing = copper;
  rubbing.rock.failed_friction = 0.5;
  const SolidLaw law = solid_law(rubbing, true, "copper");
  Lab world = world_of_two(testing_world(), speed, law);
  for (double& damage : world.bodies.damage) damage = 1;
  const Sums before = sums_of(world);
  solid_steps(world, 0.1 * d / law.sound_speed(), 150);
  expect_kept(world, before, speed);
}

// --- how cases ask for it ---

const char* const groups = R"([materials.cu.solid]
density = 8930
sound_speed = 3940
hugoniot_slope = 1.489
gruneisen = 2.02
youngs_modulus = "124 GPa"
poisson_ratio = 0.34
yield_strength = "90 MPa"
[materials.rock]
density = 2000
[[groups]]
name = "plate"
material = "cu"
volume = {shape = "box", size = ["5 mm", "5 mm", "2 mm"]}
packing = {kind = "fcc", diameter = "0.5 mm"}
[[phases]]
name = "only"
method = "solid"
step = "1 ns"
duration = "2 ns"
)";

std::string complaint(const std::string& more, const std::string& from = "",
                      const std::string& to = "") {
  std::string text = groups + more;
  if (!from.empty()) text.replace(text.find(from), from.size(), to);
  return complaint_of([&] { parse_case(text, "x.toml"); });
}

TEST(SolidCase, refuses_what_it_does_not_model) {
  EXPECT_EQ(complaint(""), "");
  EXPECT_EQ(complaint("", "material = \"cu\"", "material = \"rock\""),
            "x.toml:11:1: groups.plate.material = \"rock\": x.toml:16:1: phases.only.method = "
            "\"solid\" needs a solid of [materials]: one with a library, a file or a table "
            "[materials.rock.solid]");
  EXPECT_NE(complaint("", "gruneisen = 2.02\n", "").find("needs gruneisen"), std::string::npos);
  EXPECT_NE(complaint("", "poisson_ratio = 0.34\n", "").find("needs poisson_ratio"),
            std::string::npos);
  EXPECT_NE(complaint("", "poisson_ratio = 0.34", "poisson_ratio = -1").find("-1"),
            std::string::npos);
  EXPECT_NE(complaint("", "yield_strength = \"90 MPa\"\n", "")
                .find("needs johnson_cook_a, steinberg_y0, yield_strength or"),
            std::string::npos);
  EXPECT_EQ(complaint("[solid]\nelastic = true\n", "yield_strength = \"90 MPa\"\n", ""), "");
  EXPECT_EQ(
      complaint("", "diameter = \"0.5 mm\"", "diameter = \"0.5 mm\", spacing = \"0.7 mm\""),
      "x.toml:11:1: groups.plate: x.toml:16:1: phases.only.method = \"solid\" needs spheres that "
      "touch: packing.spacing = 0.0007 m is more than their diameter, 0.0005 m; leave it out");
  EXPECT_EQ(
      complaint("", "[[phases]]", "total_mass = 1\n[[phases]]"),
      "x.toml:11:1: groups.plate.total_mass: in x.toml:17:1: phases.only.method = \"solid\" the "
      "density is that of the material cu; change materials.cu.solid.density");
  EXPECT_NE(complaint("", "{kind = \"fcc\", diameter = \"0.5 mm\"}",
                      "{kind = \"simple_cubic\", diameter = \"0.5 mm\"}")
                .find("packing.kind = \"fcc\" or \"hcp\""),
            std::string::npos);
  EXPECT_NE(complaint("[solid]\nfriction = 0.3\n").find("solid.friction"), std::string::npos);
  const auto beside = [](const char* diameter) {
    return complaint(fmt::format(
        "[[groups]]\nname = \"dust\"\nmaterial = \"cu\"\nvolume = {{radius = \"0.5 mm\", center "
        "= [0, 0, \"5 mm\"]}}\npacking = {{kind = \"fcc\", diameter = \"{}\"}}\n",
        diameter));
  };
  EXPECT_EQ(beside("0.08 mm"), "");
  EXPECT_EQ(beside("0.07 mm"),
            "x.toml:21:1: groups.dust: its bodies, of 7e-05 m, would fly through the gaps between "
            "those of groups.plate, of 0.0005 m, and nothing would be said: more than 0.155 of "
            "these is wanted");
  EXPECT_EQ(complaint("[solid]\ncourant = 2\n"),
            "x.toml:22:11: solid.courant = 2: 0 to 0.2 is wanted");
}

TEST(SolidCase, is_not_what_bonds_have_broken_in_nor_are_they_what_it_has) {
  const std::string by_pairs =
      "[[phases]]\nname = \"pairs\"\nmethod = \"potential\"\nstep = \"1 ns\"\nduration = \"2 "
      "ns\"\n";
  const std::string law = "[pair_potential]\nmaterial = \"cu\"\n";
  std::string text = groups;
  text.insert(text.find("[materials.rock]"), "spall_strength = \"1.2 GPa\"\n");
  const std::string after = text + by_pairs + law;
  std::string before = text + law;
  before.insert(before.find("[[phases]]"), by_pairs);
  for (const auto& [order, former, later] :
       {std::tuple(after, "only", "pairs"), std::tuple(before, "pairs", "only")}) {
    const std::string told = complaint_of([&] { parse_case(order, "x.toml"); });
    EXPECT_NE(told.find(fmt::format("phases.{}.method", later)), std::string::npos) << told;
    EXPECT_NE(told.find(fmt::format("stresses of phases.{}: what was broken", former)),
              std::string::npos)
        << told;
  }
}

TEST(SolidCase, tells_a_step_that_would_do) {
  Lab world = world_of(alone(), ball(as_is, 2 * d), ductile);
  const std::string message = complaint_of([&] {
    world.solid.check_steps(world, {1e-6, 1e-3, "x.toml: phases.only"});
  });
  EXPECT_NE(message.find("step = 1e-06 s is too long for copper"), std::string::npos) << message;
  world.solid.courant = usual_courant;
  world.solid.check_steps(world, {1e-6, 1e-3, "x.toml: phases.only"});  // it is parted
}

TEST(SolidContact, fine_bodies_that_cover_a_coarse_one_push_as_one_that_is_as_wide) {
  const ContactPush coarse(elastic, elastic, d, d), fine(elastic, elastic, 0.75 * d, 0.5 * d);
  for (const double pressed : {0.99, 0.9}) {
    // Four bodies of half the diameter have the face of one.
    EXPECT_NEAR(4 * fine.force(pressed * 0.75 * d), coarse.force(pressed * d),
                1e-12 * coarse.force(pressed * d));
    const double h = 1e-6 * d, r = pressed * 0.75 * d;
    EXPECT_NEAR((fine.energy(r - h) - fine.energy(r + h)) / (2 * h), fine.force(r),
                1e-6 * fine.force(r));
  }
}

}  // namespace
}  // namespace spall
