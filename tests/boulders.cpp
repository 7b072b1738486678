// Clumps that stand, tip, rock and rattle, beside the statics and impacts of rigid blocks.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "clump_worlds.hpp"
#include "engine/free_turn.hpp"
#include "output/diagnostics.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double g = 9.8;  // m/s^2

/// A shape whose spheres lie where they were listed (m) as long as its body is not moved.
struct Block {
  BodyShape shape;
  double radius;  ///< m, of the sphere around it
  Vec3 centre;    ///< m, of mass
};

Block make_block(const std::vector<ShapeSphere>& spheres) {
  const BodyShape shape = make_shape("block", spheres);
  const double radius = spheres[0].radius / shape.spheres[0].radius;
  return {shape, radius, spheres[0].at - radius * (shape.as_listed * shape.spheres[0].at)};
}

/// The block turned about the origin, then shifted.
ShapedBody place(const Block& block, const Quaternion& turn, const Vec3& shift, double mass = 1) {
  return {.radius = block.radius,
          .mass = mass,
          .position = turn * block.centre + shift,
          .orientation = turn * block.shape.as_listed};
}

/// By each rank for itself, unless told otherwise: a solve to round-off of a few bodies is all
/// messages on several ranks.
Lab stand_on_floor(const Block& block, const std::vector<ShapedBody>& clumps, double friction,
                   const Comm& comm = alone()) {
  Lab world = make_world(comm, with_sphere({block.shape}), clumps, {.friction = friction});
  world.planes = {floor_plane};
  world.uniform_gravity = {0, 0, -g};
  return world;
}

/// m/s: of the fastest body, or of the fastest point of one that turns. Collective.
double fastest(const Lab& world) {
  double speed = 0;
  for (const Sphere& s : spheres_of(world))
    speed = std::max(speed, s.velocity.norm() + s.radius * s.spin.norm());
  return speed;
}

/// m: how far a body has come from where it was. Collective.
double farthest(const Lab& world, const std::vector<Sphere>& from) {
  double way = 0;
  const auto now = spheres_of(world);
  for (std::size_t k = 0; k < now.size(); ++k)
    way = std::max(way, (now[k].position - from[k].position).norm());
  return way;
}

// Stacks -----------------------------------------------------------------------------------------

constexpr int boxes = 10;
constexpr double box_half = 1;  // m: the spheres at a box's corners have their centres there
constexpr double corner = 1;    // m, their radius

Block make_box() {
  std::vector<ShapeSphere> spheres;
  for (int k = 0; k < 8; ++k)
    spheres.push_back({box_half * Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1), corner});
  return make_block(spheres);
}

/// Each box is shifted along x against the one below, and lies in the dips that this leaves. The
/// heavier ones are at the top where `heavier` is positive.
std::vector<ShapedBody> stack(const Block& box, double shift, double heavier = 0) {
  const double rise = 2 * box_half + std::sqrt(4 * corner * corner - shift * shift);
  std::vector<ShapedBody> clumps;
  for (int k = 0; k < boxes; ++k)
    clumps.push_back(place(box, Quaternion::Identity(),
                           Vec3(k * shift, 0, box_half + corner + k * rise), 1 + k * heavier));
  return clumps;
}

/// N s, upwards, of all contacts of the last step that a body carries by its upper side, by its id;
/// -1: the floor. Collective.
std::map<BodyId, double> carried_by_level(const Lab& world) {
  const ContactMemory memory = remember(world.bodies, world.rigid.neighbours.pairs, true);
  std::vector<double> rows;
  for (std::size_t m = 0; m < memory.size(); ++m) {
    const bool on_floor = memory.j[m] < 0;  // the impulse acts on the floor, else on the upper box
    rows.push_back(on_floor ? -1 : double(memory.i[m]));
    rows.push_back(on_floor ? -memory.impulse[m].z() : memory.impulse[m].z());
  }
  const auto all = world.comm.all_gather(rows);
  std::map<BodyId, double> sums;
  for (std::size_t k = 0; k < all.size(); k += 2) sums[BodyId(all[k])] += all[k + 1];
  return sums;
}

TEST(Stack, comes_to_rest_and_each_level_carries_the_weight_above_it) {
  const Block box = make_box();
  auto clumps = stack(box, 0, 0.3);
  for (int k = 0; k < boxes; ++k) clumps[k].position.z() += 1e-3 * (k + 1);  // they land first
  Lab world = stand_on_floor(box, clumps, 0.5, testing_world());
  const double h = 5e-3;
  advance(world, h, 40);
  const auto landed = spheres_of(world);
  advance(world, h, 10);
  // The solver's 1e-10 of what gravity gives in a step, or less.
  EXPECT_LE(fastest(world), 1e-9 * g * h);
  EXPECT_LE(farthest(world, landed), 1e-9);
  const auto carried = carried_by_level(world);
  ASSERT_EQ(std::ssize(carried), boxes);
  double above = 0;
  for (int k = boxes - 1; k >= 0; --k) {
    above += clumps[k].mass;
    EXPECT_NEAR(carried.at(k - 1) / (above * g * h), 1, 1e-9) << k;
  }
}

// The centre of the k upper boxes lies (k + 1)/2 shifts beyond the centre of the box below them,
// and the points where they stand on it half a shift beyond its spheres' centres, +-box_half. So a
// level tips beyond a shift of 2 box_half/k; nine boxes on the first and ten on the floor alike.
TEST(Stack, that_leans_stands_within_its_limit_and_tips_beyond) {
  if (testing_world().size > 1) return;  // one rank does it
  const Block box = make_box();
  const double limit = 2 * box_half / (boxes - 1), h = 5e-3;
  const int steps = 100;
  const auto speed = [&](double part) {  // over that of free fall
    Lab world = stand_on_floor(box, stack(box, part * limit), 0.5);
    advance(world, h, steps);
    return fastest(world) / (g * steps * h);
  };
  for (const double part : {0.5, 0.99}) EXPECT_LE(speed(part), 1e-8) << part;
  // What tips it is the moment beyond the limit, and in half a second little else.
  const double near = speed(1.01), far = speed(1.02);
  EXPECT_GT(near, 1e-4);
  EXPECT_NEAR(1.01 - 0.01 * near / (far - near), 1, 1e-3);
}

TEST(Stack, that_leans_too_far_falls_down) {
  if (testing_world().size > 1) return;  // one rank does it
  const Block box = make_box();
  const double limit = 2 * box_half / (boxes - 1), h = 1e-2;
  const auto high = [&](double part) {  // m, the upper box at the start and 8 s later
    const auto clumps = stack(box, part * limit);
    Lab world = stand_on_floor(box, clumps, 0.5);
    advance(world, h, 800, {.tolerance = 1e-4});
    return std::pair(clumps.back().position.z(), spheres_of(world).back().position.z());
  };
  const auto [stood, stands] = high(0.9);
  EXPECT_NEAR(stands, stood, 1e-3 * stood);
  const auto [leaned, lies] = high(1.4);
  EXPECT_LT(lies, 0.5 * leaned);
}

// Arches -----------------------------------------------------------------------------------------

/// A semicircular arch of equal voussoirs about the y axis, on the floor with both ends. At each of
/// its joints two pairs of spheres meet, in points at `middle` -+ `thickness`/2 from the axis.
struct Arch {
  int voussoirs = 16;
  double middle = 10;    ///< m
  double thickness = 1;  ///< m, between the points: the spheres reach beyond by their radius
  double radius = 0.75;  ///< m, of the spheres

  double angle() const { return pi / voussoirs; }
};

/// The voussoir at the top, if there were one: it lies across the z axis.
Block make_voussoir(const Arch& arch) {
  std::vector<ShapeSphere> spheres;
  for (const double side : {-1.0, 1.0})
    for (const double out : {-1.0, 1.0})
      for (const double y : {-0.5, 0.5}) {
        const double rho = arch.middle + out * arch.thickness / 2, half = arch.angle() / 2;
        const Vec3 point(side * rho * std::sin(half), y, rho * std::cos(half));
        const Vec3 outward(side * std::cos(half), 0, -std::sin(half));
        spheres.push_back({point - arch.radius * outward, arch.radius});
      }
  return make_block(spheres);
}

std::vector<ShapedBody> build(const Arch& arch, const Block& voussoir) {
  std::vector<ShapedBody> clumps;
  for (int k = 0; k < arch.voussoirs; ++k) {
    const double turn = (k + 0.5) * arch.angle() - pi / 2;
    clumps.push_back(
        place(voussoir, turned_by(Vec3(0, turn, 0), Quaternion::Identity()), Vec3::Zero()));
  }
  return clumps;
}

/// m: how much room a line of thrust has at the joint where it has least, at best; negative where
/// no line of thrust stays in the arch. Of right halves with a thrust H at the height y of the
/// crown, in weights of a voussoir: about the inner end of no joint may what lies above turn
/// inwards, about the outer end not outwards, both linear in H and H y (J. Heyman, The stone
/// skeleton, Int. J. Solids Struct. 2 (1966) 249).
double room_for_thrust(const Arch& arch, double centre) {
  const auto room = [&](double H) {
    double least = -1e300, most = 1e300;  // of H y
    double weight = 0, moment = 0;        // of what lies above the joint, about the z axis
    for (int joint = 0; joint <= arch.voussoirs / 2; ++joint) {
      const double at = joint * arch.angle();
      const auto bound = [&](double rho) {
        return H * rho * std::cos(at) + weight * rho * std::sin(at) - moment;
      };
      least = std::max(least, bound(arch.middle - arch.thickness / 2));
      most = std::min(most, bound(arch.middle + arch.thickness / 2));
      weight += 1;
      moment += centre * std::sin(at + arch.angle() / 2);
    }
    return (most - least) / H;
  };
  double low = 0.1, high = arch.voussoirs;  // a concave function over H has one maximum in between
  for (int k = 0; k < 200; ++k) {
    const double a = low + (high - low) / 3, b = high - (high - low) / 3;
    if (room(a) < room(b))
      low = a;
    else
      high = b;
  }
  return room(low);
}

/// Thickness over middle radius at which the arch just stands; `centre_of` tells the distance of
/// a voussoir's centre of mass from the axis.
template <class F>
double least_thickness(Arch arch, F&& centre_of) {
  double falls = 0.05, stands = 0.2;
  while (stands - falls > 1e-6) {
    const double ratio = (stands + falls) / 2;
    arch.thickness = ratio * arch.middle;
    (room_for_thrust(arch, centre_of(arch)) < 0 ? falls : stands) = ratio;
  }
  return stands;
}

// M. Milankovitch, Theorie der Druckkurven, Z. Math. Phys. 55 (1907) 1, of weights where they are.
TEST(Arch, least_thickness_of_a_fine_one_is_milankovitchs) {
  const auto centre_of_wedge = [](const Arch& arch) {
    const double out = arch.middle + arch.thickness / 2, in = arch.middle - arch.thickness / 2;
    return 2.0 / 3 * (std::pow(out, 3) - std::pow(in, 3)) / (out * out - in * in) *
           std::sin(arch.angle() / 2) / (arch.angle() / 2);
  };
  const auto least = [&](int n) { return least_thickness({.voussoirs = n}, centre_of_wedge); };
  EXPECT_NEAR(least(2000), 0.1075, 5e-5);
  EXPECT_NEAR(least(16), least(2000), 3e-4) << "few joints, of which some are nearly the worst";
}

// The spheres' radius is no part of the thickness: as long as the joints are closed, faces meet in
// points at the two radii alone. It tells how a joint opens: spheres roll on each other, and the
// hinge of a joint that has opened by an angle has moved by radius x angle/2 away from its middle.
TEST(Arch, stands_above_its_least_thickness_and_falls_below) {
  if (testing_world().size > 1) return;  // one rank does it
  const double h = 5e-3;
  const int steps = 8;
  for (const double radius : {0.7, 0.9}) {
    const double least = least_thickness(
        {.radius = radius}, [](const Arch& arch) { return make_voussoir(arch).centre.z(); });
    EXPECT_NEAR(least, 0.1075, 1e-3) << "voussoirs are nearly wedges";
    const auto speed = [&](double part) {  // over that of free fall
      const Arch arch{.thickness = part * least * Arch{}.middle, .radius = radius};
      const Block voussoir = make_voussoir(arch);
      Lab world = stand_on_floor(voussoir, build(arch, voussoir), 1);
      advance(world, h, steps);
      return fastest(world) / (g * steps * h);
    };
    for (const double part : {1.01, 1.1}) EXPECT_LE(speed(part), 1e-8) << part;
    // What moves it is what lacks of the limit, and so soon little else.
    const double near = speed(0.99), far = speed(0.98);
    EXPECT_GT(near, 1e-3);
    EXPECT_NEAR(0.99 + 0.01 * near / (far - near), 1, 2e-3);
  }
}

TEST(Arch, that_is_too_thin_falls_down) {
  if (testing_world().size > 1) return;  // one rank does it
  const double h = 1e-2;
  const auto crown = [&](double ratio) {  // m, of the highest voussoir at the end
    const Arch arch{.thickness = ratio * Arch{}.middle};
    const Block voussoir = make_voussoir(arch);
    Lab world = stand_on_floor(voussoir, build(arch, voussoir), 1);
    advance(world, h, 300, {.tolerance = 1e-4});
    double highest = 0;
    for (const Sphere& s : spheres_of(world)) highest = std::max(highest, s.position.z());
    return highest;
  };
  EXPECT_GT(crown(0.125), 0.98 * Arch{}.middle);
  EXPECT_LT(crown(0.09), 0.5 * Arch{}.middle);
}

// Rocking ----------------------------------------------------------------------------------------

/// rad, about y: how far the body leans towards x.
double lean_of(const Lab& world, const Block& block) {
  const Quaternion turn = world.bodies.orientation[0] * block.shape.as_listed.conjugate();
  return std::asin((turn * Vec3::UnitZ()).x());
}

/// J over J: what a block with feet at +-1 m, which leans by `tilt` and is let go, has left of its
/// energy behind the change of feet, above that of standing.
double energy_left(const Block& block, double tilt, double h) {
  const Quaternion turn = turned_by(Vec3(0, tilt, 0), Quaternion::Identity());
  const Vec3 foot(1, 0, 1);
  Lab world = stand_on_floor(block, {place(block, turn, foot - turn * foot)}, 1);
  double before = 0;
  while (true) {
    const double height = world.bodies.position[0].z();
    advance(world, h, 1);
    // Velocities belong to the middle of the step.
    const double middle = (height + world.bodies.position[0].z()) / 2 - block.centre.z();
    const double energy = diagnose(world).kinetic + g * middle;
    const double lean = lean_of(world, block);
    if (lean > tilt / 8) before = energy;
    if (lean < -tilt / 8) return energy / before;
    if (world.time > 10 || std::abs(lean) > 1) return 0;
  }
}

// G. W. Housner, The behavior of inverted pendulum structures during earthquakes, Bull. Seismol.
// Soc. Am. 53 (1963) 403: the angular momentum about the new edge is kept, so r = 1 - m R^2 (1 -
// cos 2 alpha)/I0, and the energy is r^2 of that before. Feet are round here, but in the upright
// block that changes feet both stand on their lowest points.
TEST(Block, that_rocks_keeps_at_each_change_of_feet_what_housner_says) {
  if (testing_world().size > 1) return;  // one rank does it
  std::vector<ShapeSphere> spheres;
  double about_foot = 0;  // m^2, I0 over the mass, of spheres that touch and do not overlap
  for (int k = 0; k < 16; ++k) {
    spheres.push_back({Vec3(k & 1 ? 1 : -1, k & 2 ? 1 : -1, 1 + 2 * (k / 4)), 1});
    about_foot += (2.0 / 5 + (spheres[k].at - Vec3(1, spheres[k].at.y(), 0)).squaredNorm()) / 16;
  }
  const Block block = make_block(spheres);
  const double tall = 4, alpha = std::atan(1 / tall), R2 = 1 + tall * tall;
  const double r = 1 - R2 * (1 - std::cos(2 * alpha)) / about_foot;
  EXPECT_NEAR(r, 1 - 1.5 * std::pow(std::sin(alpha), 2), 5e-3) << "of a solid block";
  // Where in a step the feet change is chance: the mean over releases has an order.
  std::vector<double> errors;
  for (const double h : {4e-3, 2e-3, 1e-3}) {
    double sum = 0;
    const int releases = 8;
    for (int k = 0; k < releases; ++k) {
      const double kept = std::sqrt(energy_left(block, (0.5 + 0.01 * k) * alpha, h));
      EXPECT_LE(kept, r * (1 + 1e-3)) << h;
      EXPECT_GE(kept, r * (1 - 5 * h)) << h;
      sum += 1 - kept / r;
    }
    errors.push_back(sum / releases);
  }
  EXPECT_NEAR(std::log2(errors[0] / errors[1]), 1, 0.25);
  EXPECT_NEAR(std::log2(errors[1] / errors[2]), 1, 0.25);
  EXPECT_NEAR(2 * errors[2] - errors[1], 0, 1e-3) << "without a step";
}

// Rattling ---------------------------------------------------------------------------------------

BodyShapes rattling_shapes() {
  return with_sphere(
      {make_shape("boulder", fill_ellipsoid(Vec3(2, std::sqrt(2.0), 1), 7)), make_box().shape});
}

/// In a closed box without gravity: all that may change the energy are contacts.
TEST(Rattle, without_friction_gives_no_energy_at_any_restitution) {
  const BodyShapes shapes = rattling_shapes();
  const double h = 1e-2;
  for (const double e : {0.0, 0.3, 0.7, 1.0}) {
    std::mt19937_64 random(9);
    std::uniform_real_distribution<double> one(-1, 1);
    const auto vector = [&] {
      const double x = one(random), y = one(random), z = one(random);
      return Vec3(x, y, z);
    };
    std::vector<ShapedBody> clumps;
    for (int k = 0; k < 27; ++k)
      clumps.push_back({.shape = 1 + k % 2,
                        .mass = 1.0 + k % 3,
                        .position = 2.1 * Vec3(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1),
                        .velocity = vector(),
                        .spin = vector(),
                        .orientation = turned_by(3 * vector(), Quaternion::Identity())});
    Lab world = make_world(alone(), shapes, clumps, {.restitution = e});
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0})
        world.planes.push_back(
            {.point = -3.3 * side * Vec3::Unit(axis), .normal = side * Vec3::Unit(axis)});
    Diagnostics before = diagnose(world);
    const double first = before.kinetic;
    double given = 0, trembled = 0;
    std::int64_t contacts = 0;
    for (int k = 0; k < 400; ++k) {
      contacts += nonsmooth_step(world, h, solved_exactly(), 1).contacts;
      const Diagnostics now = diagnose(world);
      given = std::max(given, (before.dissipated - now.dissipated) / first);
      const double unexplained = now.kinetic + now.dissipated - now.corrections - first;
      trembled = std::max(trembled, std::abs(unexplained) / first);
      before = now;
    }
    EXPECT_GT(contacts, 300);
    // The solver leaves 1e-10 open. Free turning trembles by (spin h)^2, at spins of about 1 rad/s.
    EXPECT_LE(given, 1e-9) << e;
    EXPECT_LE(before.gained, 1e-9 * first) << e;
    EXPECT_LE(trembled, h * h) << e;
    EXPECT_LE(before.kinetic, (1 + h * h) * first) << e;
  }
}

/// On a floor height counts, and velocities belong to the middle of a step. What is lifted above
/// the least energy so far is a gain, whatever was lost before.
TEST(Rattle, on_a_floor_without_friction_never_lifts_the_energy) {
  const BodyShapes shapes = rattling_shapes();
  const auto lifted = [&](double e, std::int32_t shape, double h) {
    ShapedBody clump{.shape = shape, .position = {0, 0, 2}, .spin = {0.3, -0.5, 0.2}};
    clump.orientation = turned_by(Vec3(0.4, 0.3, 0), Quaternion::Identity());
    Lab world = make_world(alone(), shapes, {clump}, {.restitution = e});
    world.planes = {floor_plane};
    world.uniform_gravity = {0, 0, -g};
    double first = 0, least = 0, most = 0;
    for (int k = 0; k * h < 3; ++k) {
      const double below = world.bodies.position[0].z();
      advance(world, h, 1);
      const double middle = (below + world.bodies.position[0].z()) / 2;
      const double energy = diagnose(world).kinetic + clump.mass * g * middle;
      if (k == 0) first = least = energy;
      least = std::min(least, energy);
      most = std::max(most, (energy - least) / first);
    }
    return most;
  };
  // Free turning trembles in second order of the step; in 3 s hits make spins of some ones.
  for (const std::int32_t shape : {1, 2})
    for (const double e : {0.0, 0.5, 1.0})
      for (const double h : {4e-3, 2e-3, 1e-3})
        EXPECT_LE(lifted(e, shape, h), h * h) << shape << " " << e << " " << h;
}

}  // namespace
}  // namespace spall
