// Walls that are whole, drilled, cratered, spalled: each has the verdict and the measure it was
// given.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/shields.hpp"

#include <cmath>
#include <functional>
#include <numbers>

#include "analysis/shield_wall.hpp"
#include "run/simulation.hpp"
#include "scene/scene.hpp"
#include "testing.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3, thickness = 6e-3;  // m: spacing, wall

const std::string solids = R"(
[materials.al]
library = "aluminium_6061_t6"
)";
const std::string bonded = solids + R"(
[pair_potential]
materials = ["al"]
)";

struct Asked {
  std::string size = R"(["28 mm", "24 mm", "6 mm"])";
  std::string volume = "";  // of the wall, in place of a box of that size
  std::string packing = R"({kind = "fcc", diameter = "1 mm", orientation = "random"})";
  std::string method = "solid";
  std::string way = "[0, 0, 1]";        // of the ball, m/s
  std::string from = "[0, 0, -10e-3]";  // where the ball is, m
  std::string more = "";                // of [[shields]]
  std::string of_wall = "";             // keys of its group
  std::string before = "";              // a phase
};

Case read(const Asked& asked) {
  return parse_case((asked.method == "potential" ? bonded : solids) + R"(
[[groups]]
name = "rear wall"
material = "al"
volume = )" +
                        (asked.volume.empty() ? R"({shape = "box", size = )" + asked.size + "}"
                                              : asked.volume) +
                        "\npacking = " + asked.packing + "\n" + asked.of_wall + R"(
[[groups]]
name = "ball"
material = "al"
volume = {shape = "sphere", diameter = "4 mm", center = )" +
                        asked.from + R"(}
packing = {kind = "fcc", diameter = "1 mm"}
velocity = )" + asked.way +
                        "\n" + asked.before + R"([[phases]]
name = "hit"
method = ")" + asked.method +
                        R"("
step = "1 ns"
duration = "1 us"
[[shields]]
wall = "rear wall"
)" + asked.more,
                    "x.toml");
}

/// A body of the wall, as the wall sees it at the start: across, and from its middle to its rear.
struct Place {
  double x, y, depth;
  double radius() const { return std::hypot(x, y); }
};

enum class Fate { stays, fails, is_gone };

struct Scenery {
  Case scene;
  World world;
  std::unique_ptr<Engine> engine;
  ShieldWall wall;

  Scenery(const Comm& comm, const Asked& asked)
      : scene(read(asked)),
        world(make_world(comm, scene)),
        engine(scene.phases[0].engine->make(scene.phases[0].settings)),
        wall(lay_wall(comm, scene, scene.shields[0])) {
    world.bodies = make_bodies(scene, comm);
  }

  /// What `f(place, position, velocity)` says of each body of the wall, which it may move.
  void let(const std::function<Fate(const Place&, Vec3&, Vec3&)>& f) {
    Bodies& bodies = world.bodies;
    for (Index b = 0; b < bodies.owned; ++b) {
      if (bodies.group[b] != wall.group) continue;
      const WallFrame& frame = wall.start;
      const Vec3 x = bodies.position[b] - frame.center;
      const Place place{x.dot(frame.across[0]), x.dot(frame.across[1]), x.dot(frame.normal)};
      const Fate fate = f(place, bodies.position[b], bodies.velocity[b]);
      if (fate == Fate::fails) bodies.damage[b] = 1;
      if (fate == Fate::is_gone) bodies.position[b] -= frame.normal;
    }
  }
  void drill(double x, double y, double diameter, Fate fate = Fate::fails) {
    let([&](const Place& p, Vec3&, Vec3&) {
      return std::hypot(p.x - x, p.y - y) < (diameter + d) / 2 ? fate : Fate::stays;
    });
  }
  WallVerdict judge() const { return judge_wall(world.comm, engine->links(world), wall); }
  Coming coming() const { return look_at_what_comes(world.comm, engine->links(world), wall); }
};

const std::vector<Asked> turned = {
    {},
    {.way = "[0, 0, -1]", .from = "[0, 0, 10e-3]"},
    {.size = R"(["6 mm", "28 mm", "24 mm"])", .way = "[2, 1, 0]", .from = "[-10e-3, 0, 0]"},
    {.size = R"(["24 mm", "6 mm", "28 mm"])", .way = "[0, -3, 0]", .from = "[0, 10e-3, 0]"},
    {.size = R"(["28 mm", "24 mm", "6 mm"], rotation = ["10 deg", "40 deg", "-5 deg"])"},
    {.method = "potential"}};

TEST(Shields, a_whole_wall_has_held_with_nearly_all_of_its_thickness) {
  for (const Asked& asked : turned) {
    const Scenery shot(testing_world(), asked);
    EXPECT_GT(shot.scene.shields[0].rear.dot(shot.scene.groups[1].velocity), 0);
    const WallVerdict v = shot.judge();
    EXPECT_EQ(v.outcome, Outcome::held);
    EXPECT_GT(v.margin, 0.85);  // six layers, counted on circles of seven bodies
    EXPECT_LE(v.margin, 1);
    EXPECT_DOUBLE_EQ(v.margin, v.thinnest / thickness);
    EXPECT_EQ(v.openings, 0);
    EXPECT_EQ(v.hole, 0);
    EXPECT_EQ(v.spall_mass, 0);
  }
}

TEST(Shields, a_drilled_hole_is_as_wide_as_it_was_drilled) {
  for (Asked asked : turned)
    for (const double diameter : {3.0 * d, 6.4 * d}) {
      Scenery shot(testing_world(), asked);
      // Bonds of pair potentials are made by places: there what was drilled out is gone.
      shot.drill(2 * d, -d, diameter, asked.method == "solid" ? Fate::fails : Fate::is_gone);
      const WallVerdict v = shot.judge();
      EXPECT_EQ(v.outcome, Outcome::perforated);
      EXPECT_EQ(v.openings, 1);
      // Bodies stand back from the drill by less than half a spacing.
      EXPECT_GT(v.hole, diameter - d / 4);
      EXPECT_LT(v.hole, diameter + 0.6 * d);
      EXPECT_DOUBLE_EQ(v.margin, -v.hole / thickness);
      EXPECT_FALSE(v.opening_at_edge);
      EXPECT_LT(v.thinnest, 0.1 * thickness);
    }
}

TEST(Shields, holes_are_counted_and_the_largest_is_told) {
  Scenery shot(testing_world(), {});
  shot.drill(-6 * d, 0, 3 * d);
  shot.drill(5 * d, 3 * d, 5 * d);
  const WallVerdict v = shot.judge();
  EXPECT_EQ(v.openings, 2);
  EXPECT_NEAR(v.hole, 5 * d, 0.6 * d);
}

TEST(Shields, what_is_narrower_than_a_body_is_no_opening) {
  Scenery shot(testing_world(), {});
  shot.drill(0, 0, 0.4 * d);
  const WallVerdict v = shot.judge();
  EXPECT_EQ(v.outcome, Outcome::held);
  EXPECT_EQ(v.openings, 0);
  EXPECT_LT(v.margin, 0.9);
}

TEST(Shields, a_crater_leaves_what_is_below_it) {
  for (const Asked& asked : turned)
    for (const double left : {1.0 / 3, 2.0 / 3}) {
      Scenery shot(testing_world(), asked);
      shot.let([&](const Place& p, Vec3&, Vec3&) {
        const bool in_crater = p.radius() < 5 * d && p.depth < (0.5 - left) * thickness;
        return in_crater ? (asked.method == "solid" ? Fate::fails : Fate::is_gone) : Fate::stays;
      });
      const WallVerdict v = shot.judge();
      EXPECT_EQ(v.outcome, Outcome::held);
      // Half a spacing: thickness is counted in layers.
      EXPECT_NEAR(v.margin, left, 0.5 * d / thickness);
    }
}

/// A disc of the rear, of this diameter and two spacings thick, a way behind it.
void throw_flake(Scenery& shot, double diameter, double way, double speed) {
  const Vec3 normal = shot.wall.start.normal;
  shot.let([&](const Place& p, Vec3& position, Vec3& velocity) {
    if (p.radius() < diameter / 2 && p.depth > thickness / 2 - 2 * d) {
      position += way * normal;
      velocity += speed * normal;
    }
    return Fate::stays;
  });
}

TEST(Shields, what_has_left_a_wall_has_left_it_whatever_stopped_it_behind) {
  Scenery thrown(testing_world(), {}), stopped(testing_world(), {});
  throw_flake(thrown, 6 * d, 3 * d, 100);
  throw_flake(stopped, 6 * d, 3 * d, -1);
  const WallVerdict flies = thrown.judge(), rests = stopped.judge();
  ASSERT_EQ(rests.outcome, Outcome::held);
  WallVerdict most, verdict = rests;
  keep_spall(most, verdict);
  EXPECT_EQ(verdict.outcome, Outcome::held);
  verdict = flies;
  keep_spall(most, verdict);
  verdict = rests;
  keep_spall(most, verdict);
  EXPECT_EQ(verdict.outcome, Outcome::detached_spall);
  EXPECT_EQ(verdict.margin, flies.margin);
  EXPECT_EQ(verdict.spall_mass, flies.spall_mass);
  EXPECT_EQ(verdict.thinnest, rests.thinnest);
  WallVerdict less = flies;  // a look that saw less, and one of a hole
  less.spall_mass /= 2;
  keep_spall(most, less);
  EXPECT_EQ(most.spall_mass, flies.spall_mass);
  WallVerdict open = rests;
  open.outcome = Outcome::perforated;
  keep_spall(most, open);
  EXPECT_EQ(open.outcome, Outcome::perforated);

  // A run that goes on knows it, too.
  Shields walls(thrown.world.comm, thrown.scene), resumed(thrown.world.comm, thrown.scene);
  walls.read_out(thrown.world, *thrown.engine, 1);
  Scalars scalars;
  walls.save(scalars);
  resumed.load(scalars);
  ResultTable of_one, of_other;
  const auto said = walls.conclude(stopped.world, *stopped.engine, 2, of_one);
  EXPECT_EQ(resumed.conclude(stopped.world, *stopped.engine, 2, of_other), said);
  EXPECT_NE(said.at(0).find("detached spall"), std::string::npos);
  EXPECT_EQ(of_one.toml(), of_other.toml());
}

TEST(Shields, a_flake_that_flies_off_the_rear_is_detached_spall) {
  for (const Asked& asked : turned) {
    Scenery shot(testing_world(), asked);
    throw_flake(shot, 6 * d, 3 * d, 100);
    const WallVerdict v = shot.judge();
    EXPECT_EQ(v.outcome, Outcome::detached_spall);
    EXPECT_EQ(v.openings, 0);
    EXPECT_NEAR(v.spall_speed, 100, 1e-9);
    // Lattices have as many bodies as the volume holds, give or take some on its surface.
    const double volume = pi / 4 * 36 * d * d * 2 * d;
    EXPECT_NEAR(v.spall_mass, volume * 2703, 0.2 * volume * 2703);
    EXPECT_NEAR(v.margin, -std::cbrt(6 * volume / pi) / thickness, 0.07);
    EXPECT_LE(v.spall_largest, v.spall_mass);
    EXPECT_NEAR(v.thinnest, thickness - 2 * d, 0.5 * d);
  }
}

TEST(Shields, what_comes_back_or_stays_or_is_a_grain_is_no_spall) {
  const struct {
    double diameter, way, speed;
  } flakes[] = {{6 * d, 3 * d, -100}, {6 * d, 3 * d, 0}, {1.1 * d, 3 * d, 100}};
  for (const auto& flake : flakes) {
    Scenery shot(testing_world(), {});
    throw_flake(shot, flake.diameter, flake.way, flake.speed);
    const WallVerdict v = shot.judge();
    EXPECT_EQ(v.outcome, Outcome::held);
    EXPECT_EQ(v.spall_pieces > 0, flake.diameter < 2 * d);
  }
}

TEST(Shields, what_is_blown_off_the_edges_is_no_spall_and_what_flies_aside_is) {
  for (const Asked& asked : turned) {
    Scenery shot(testing_world(), asked);
    const Vec3 normal = shot.wall.start.normal, aside = shot.wall.start.across[0];
    const double far = 0.93 * shot.wall.half_width[0];
    const auto blow = [&](double from, double to, const Vec3& velocity) {
      shot.let([&](const Place& p, Vec3& position, Vec3& moves) {
        if (p.x < from || p.x > to || std::abs(p.y) > 2 * d || p.depth < thickness / 2 - d)
          return Fate::stays;
        position += 5e-5 * velocity;
        moves += velocity;
        return Fate::fails;
      });
    };
    // Off the rim, straight on and even towards the middle.
    blow(far, infinity, 100 * normal - 20 * aside);
    EXPECT_EQ(shot.judge().spall_pieces, 0);
    EXPECT_EQ(shot.judge().outcome, Outcome::held);
    EXPECT_NE(
        sentence_of(shot.wall, shot.judge(), {}).find("its rim, which is not judged, has lost"),
        std::string::npos);
    // From the middle, so far aside that it is beyond the edge by now.
    blow(-2 * d, 2 * d, 200 * normal + 500 * aside);
    const WallVerdict v = shot.judge();
    EXPECT_GT(v.spall_pieces, 0);
    EXPECT_EQ(v.outcome, Outcome::detached_spall);
  }
}

TEST(Shields, what_came_through_is_no_spall) {
  Scenery shot(testing_world(), {});
  Bodies& bodies = shot.world.bodies;
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] != shot.wall.group) {
      bodies.position[b] += 20e-3 * shot.wall.start.normal;
      bodies.velocity[b] = 100 * shot.wall.start.normal;
    }
  const WallVerdict v = shot.judge();
  EXPECT_EQ(v.outcome, Outcome::held);
  EXPECT_EQ(v.spall_pieces, 0);
  EXPECT_EQ(v.spall_mass, 0);
}

TEST(Shields, what_failed_on_the_rear_and_rides_on_it_is_no_spall) {
  Scenery shot(testing_world(), {});
  shot.let([&](const Place& p, Vec3&, Vec3& velocity) {
    if (p.depth < thickness / 2 - 1.3 * d) return Fate::stays;
    velocity += 0.1 * shot.wall.start.normal;
    return Fate::fails;
  });
  const WallVerdict v = shot.judge();
  EXPECT_EQ(v.outcome, Outcome::held);
  EXPECT_NEAR(v.margin, 1 - 1.3 * d / thickness, 0.5 * d / thickness);
}

TEST(Shields, a_wall_that_drifts_is_followed) {
  const WallVerdict rest = Scenery(testing_world(), {}).judge();
  Scenery shot(testing_world(), {.way = "[0, 0, 1000]", .of_wall = "velocity = [0, 30, 100]"});
  const Vec3 way = 1e-4 * Vec3(0, 30, 100) + Vec3(2.2 * d, -1.7 * d, 9 * d);
  shot.let([&](const Place&, Vec3& position, Vec3&) {
    position += way;
    return Fate::stays;
  });
  const WallVerdict v = shot.judge();
  EXPECT_EQ(v.outcome, Outcome::held);
  EXPECT_NEAR(v.margin, rest.margin, 0.02);  // other pixels
}

TEST(Shields, a_wall_that_turns_is_seen_along_its_own_normal) {
  for (const Asked& asked : {Asked{}, turned[2]}) {
    Scenery shot(testing_world(), asked);
    const double margin = shot.judge().margin;
    const WallFrame& frame = shot.wall.start;
    const Eigen::Matrix3d turn(Eigen::AngleAxisd(0.6, frame.across[1]));
    shot.let([&](const Place&, Vec3& position, Vec3&) {
      position = frame.center + turn * (position - frame.center) + 7e-3 * frame.across[0];
      return Fate::stays;
    });
    const WallVerdict v = shot.judge();
    EXPECT_EQ(v.outcome, Outcome::held);
    EXPECT_NEAR(v.margin, margin, 0.02);  // other pixels
  }
}

TEST(Shields, half_a_wall_is_open_as_far_as_its_edge) {
  Scenery shot(testing_world(), {});
  shot.let([&](const Place& p, Vec3&, Vec3&) { return p.x > 2 * d ? Fate::fails : Fate::stays; });
  const WallVerdict v = shot.judge();
  EXPECT_EQ(v.outcome, Outcome::perforated);
  EXPECT_TRUE(v.opening_at_edge);
}

TEST(Shields, what_has_not_arrived_is_told) {
  Scenery shot(testing_world(), {});
  EXPECT_NEAR(shot.judge().still_coming, 1, 1e-12);
  EXPECT_NE(sentence_of(shot.wall, shot.judge(), {}).find("not final: 1e+02 %"), std::string::npos);
  Bodies& bodies = shot.world.bodies;
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] == 1 && bodies.position[b].x() > 0) bodies.velocity[b] *= 0.5;
  const double slowed = shot.judge().still_coming;
  EXPECT_GT(slowed, 0.5);
  EXPECT_LT(slowed, 0.75);
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] == 1) bodies.velocity[b].x() = 2000;  // beside the wall
  EXPECT_EQ(shot.judge().still_coming, 0);
}

TEST(Shields, what_has_not_arrived_from_behind_is_told_too) {
  const std::string behind = R"(
[[groups]]
name = "behind"
material = "al"
volume = {shape = "sphere", diameter = "4 mm", center = [0, 0, 10e-3]}
packing = {kind = "fcc", diameter = "1 mm"}
velocity = [0, 0, -3]
)";
  Scenery shot(testing_world(), {.more = "rear = [0, 0, 1]", .of_wall = behind});
  EXPECT_NEAR(shot.judge().still_coming, 1, 1e-12);
  Bodies& bodies = shot.world.bodies;
  const auto group = std::ranges::find(shot.scene.groups, "behind", &Group::name);
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] == group - shot.scene.groups.begin()) bodies.velocity[b].z() = 1;  // away
  EXPECT_NEAR(shot.judge().still_coming, 0.1, 1e-12);  // of 3^2 and 1^2 the latter
}

/// A ball at 9 m/s along z, which starts at this x (m).
std::string flies_past(const std::string& x, const std::string& diameter) {
  return R"(
[[groups]]
name = "other"
material = "al"
packing = {kind = "fcc", diameter = "1 mm"}
velocity = [0, 0, 9]
volume = {shape = "sphere", diameter = ")" +
         diameter + "\", center = [" + x + ", 0, -10e-3]}\n";
}

TEST(Shields, what_flies_past_does_not_count_as_what_flies_at_it) {
  EXPECT_NEAR(
      Scenery(testing_world(), {.of_wall = flies_past("60e-3", "8 mm")}).judge().still_coming, 1,
      1e-12);
}

/// kg
double mass_of(const Scenery& shot, const char* name) {
  const auto group = std::ranges::find(shot.scene.groups, name, &Group::name);
  double mass = 0;
  for (Index b = 0; b < shot.world.bodies.owned; ++b)
    if (shot.world.bodies.group[b] == group - shot.scene.groups.begin())
      mass += shot.world.bodies.mass[b];
  return shot.world.comm.sum(mass);
}

TEST(Shields, the_largest_piece_that_meets_the_wall_and_the_largest_that_flies_past_are_told) {
  // Its half width is 14 mm, of which 2 are not judged; its face is 7 mm from where the ball is.
  Scenery shot(testing_world(), {});
  const double mass = mass_of(shot, "ball");
  const auto close = [](double a, double b) { return std::abs(a - b) <= 1e-9 * std::abs(b); };
  const auto turn = [&](double across, double along) {
    Bodies& bodies = shot.world.bodies;
    for (Index b = 0; b < bodies.owned; ++b)
      if (bodies.group[b] != shot.wall.group) bodies.velocity[b] = Vec3(across, 0, along);
    return shot.coming();
  };
  const Coming straight = turn(0, 1), aside = turn(6.8, 4), rim = turn(7.2, 4), back = turn(0, -1);
  EXPECT_TRUE(close(straight.meets, mass / 2)) << straight.meets;
  EXPECT_EQ(straight.passes, 0);
  const double volume = mass / shot.scene.materials[0].density;
  EXPECT_TRUE(close(straight.diameter, std::cbrt(6 * volume / std::numbers::pi)));
  EXPECT_TRUE(close(aside.meets, 8 * mass)) << aside.meets;  // at 11.9 mm
  EXPECT_EQ(aside.passes, 0);
  EXPECT_EQ(rim.meets, 0);
  EXPECT_TRUE(close(rim.passes, 8 * mass)) << rim.passes;  // at 12.6 mm
  EXPECT_EQ(back.meets, 0);
  EXPECT_EQ(back.passes, 0);

  WallVerdict held;
  EXPECT_NE(sentence_of(shot.wall, held, {1, 2}).find("too narrow"), std::string::npos);
  for (const Coming& fine : {Coming{2, 1}, Coming{0, 1}})
    EXPECT_EQ(sentence_of(shot.wall, held, fine).find("too narrow"), std::string::npos);
  held.outcome = Outcome::perforated;
  EXPECT_EQ(sentence_of(shot.wall, held, {1, 2}).find("too narrow"), std::string::npos);
}

TEST(Shields, a_wall_that_held_is_said_to_be_coarse_beside_the_largest_piece) {
  const Scenery shot(testing_world(), {});
  const auto is_told = [&](Outcome outcome, double diameter, double times = 1) {
    WallVerdict verdict;
    verdict.outcome = outcome;
    const Coming piece{.meets = 1, .diameter = diameter, .density = times * shot.wall.density};
    return sentence_of(shot.wall, verdict, piece).find("coarse") != std::string::npos;
  };
  const double seven = 7 * shot.wall.spacing;
  EXPECT_TRUE(is_told(Outcome::held, 0.99 * seven));
  EXPECT_FALSE(is_told(Outcome::held, 1.01 * seven));
  EXPECT_FALSE(is_told(Outcome::perforated, 0.99 * seven));
  EXPECT_FALSE(is_told(Outcome::held, thickness / 10));  // which it bears at any speed
  EXPECT_TRUE(is_told(Outcome::held, thickness / 10, 4));
  EXPECT_FALSE(sentence_of(shot.wall, {}, {.meets = 1}).find("coarse") != std::string::npos);
}

TEST(Shields, a_wall_that_held_while_its_margin_fell_is_said_to_fail_still) {
  const WallVerdict held{.outcome = Outcome::held}, open{.outcome = Outcome::perforated};
  EXPECT_TRUE(is_still_failing(held, {0.9, 0.6, 0.42}));
  EXPECT_FALSE(is_still_failing(held, {0.9, 0.43, 0.42}));
  EXPECT_FALSE(is_still_failing(held, {0.42, 0.6}));  // it springs back
  EXPECT_FALSE(is_still_failing(held, {0.42}));
  EXPECT_FALSE(is_still_failing(open, {0.9, -0.6}));
}

TEST(Shields, of_two_looks_the_piece_with_more_energy_is_kept) {
  Coming most{.meets = 2, .passes = 1, .diameter = 3};
  most.add({.meets = 1, .passes = 4, .diameter = 5});
  EXPECT_EQ(most.meets, 2);
  EXPECT_EQ(most.passes, 4);
  EXPECT_EQ(most.diameter, 3);
  most.add({.meets = 3, .passes = 0, .diameter = 1});
  EXPECT_EQ(most.diameter, 1);
}

// A ball that is stretched is told as an ellipsoid of the same mass, whichever way it lies. A body
// is a cube, so a stretch is told a little too short.
TEST(Shields, the_form_and_the_motion_of_the_largest_piece_are_told) {
  Scenery shot(testing_world(), {});
  const Coming ball = shot.coming();
  EXPECT_NEAR((ball.size - ball.diameter * Vec3::Ones()).norm(), 0, 1e-6 * ball.diameter);
  EXPECT_NEAR((ball.velocity - Vec3(0, 0, 1)).norm(), 0, 1e-9);
  const Vec3 stretch(0.8, 1.3, 1), center(0, 0, -10e-3);
  const Eigen::Matrix3d way =
      (Eigen::AngleAxisd(0.7, Vec3::UnitX()) * Eigen::AngleAxisd(0.4, Vec3::UnitZ()))
          .toRotationMatrix();
  Bodies& bodies = shot.world.bodies;
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] != shot.wall.group) {
      Vec3& x = bodies.position[b];
      x = center + way * stretch.cwiseProduct(x - center);
      bodies.velocity[b] = Vec3(0.1, 0, 2);
    }
  const Coming piece = shot.coming();
  const Vec3 widest_first(1.3, 1, 0.8);
  const Vec3 expected = ball.diameter / std::cbrt(widest_first.prod()) * widest_first;
  EXPECT_NEAR((piece.size - expected).norm(), 0, 0.05 * ball.diameter);
  EXPECT_NEAR(piece.size.prod(), std::pow(ball.diameter, 3), 1e-9 * std::pow(ball.diameter, 3));
  EXPECT_NEAR((piece.velocity - Vec3(0.1, 0, 2)).norm(), 0, 1e-9);
  const double angle = piece.rotation.norm();
  const Eigen::Matrix3d found = Eigen::AngleAxisd(angle, piece.rotation / angle).toRotationMatrix();
  EXPECT_NEAR(std::abs(found.col(0).dot(way.col(1))), 1, 1e-6);
  EXPECT_NEAR(std::abs(found.col(1).dot(way.col(2))), 1, 1e-6);
  EXPECT_NEAR(std::abs(found.col(2).dot(way.col(0))), 1, 1e-6);
  // Bodies that part from it are pieces of their own, whichever rank weighs them.
  BodyId last = 0;
  for (Index b = 0; b < bodies.owned; ++b) last = std::max(last, bodies.id[b]);
  last = static_cast<BodyId>(shot.world.comm.max(static_cast<double>(last)));
  for (int parted = 0; parted < 4; ++parted)
    for (Index b = 0; b < bodies.owned; ++b)
      if (bodies.id[b] == last - parted)
        bodies.position[b] += Vec3(4e-3 * (parted - 1.5), 0, -8e-3);
  const double left = std::pow(shot.coming().diameter / ball.diameter, 3);
  const double count = mass_of(shot, "ball") / bodies.mass[0];
  EXPECT_NEAR(left, 1 - 4 / count, 1e-9);
}

TEST(Shields, what_is_not_far_behind_its_bumper_and_what_flies_at_another_wall_is_no_piece_yet) {
  const auto coming = [](const std::string& more) {
    return Scenery(testing_world(), {.from = "[0, 0, -30e-3]", .of_wall = more}).coming();
  };
  const std::string bumper = R"(
[[groups]]
name = "bumper"
material = "al"
volume = {shape = "box", size = ["28 mm", "28 mm", "1 mm"], center = [0, 0, "-Z mm"]}
packing = {kind = "fcc", diameter = "1 mm", orientation = "random"}
)";
  const auto at = [&](const char* z) {
    return std::string(bumper).replace(bumper.find('Z'), 1, z);
  };
  const double alone = coming("").meets;
  EXPECT_GT(alone, 0);
  EXPECT_EQ(coming(at("20")).meets, 0);                   // before the ball
  EXPECT_EQ(coming(at("40")).meets, alone);               // behind it
  const auto behind = [&](const char* z, double depth) {  // m from the wall's middle
    Scenery shot(testing_world(), {.from = "[0, 0, -30e-3]", .of_wall = at(z)});
    Bodies& bodies = shot.world.bodies;
    for (Index b = 0; b < bodies.owned; ++b)
      if (shot.scene.groups[bodies.group[b]].name == "ball")
        bodies.position[b].z() += 30e-3 - depth;
    return shot.coming().meets;
  };
  // Of 16.5 mm from the bumper's rear to the wall a quarter is left after 4.125 mm.
  EXPECT_EQ(behind("20", 7.2e-3), 0);
  EXPECT_EQ(behind("20", 7.0e-3), alone);
  // Twice the ball's width behind this one only half a millimetre is left.
  EXPECT_EQ(behind("12", 3.6e-3), 0);
  EXPECT_EQ(behind("12", 3.4e-3), alone);
  const Coming two = coming(flies_past("80e-3", "4 mm"));
  EXPECT_EQ(two.meets, alone);
  EXPECT_EQ(two.passes, 0);
}

TEST(Shields, a_wall_has_not_held_yet_while_the_ball_is_in_it) {
  Scenery shot(testing_world(), {});
  EXPECT_NEAR(shot.judge().still_coming, 1, 1e-12);
  Bodies& bodies = shot.world.bodies;
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.group[b] != shot.wall.group) {
      bodies.position[b].z() = 0.3 * thickness;
      bodies.velocity[b].z() = 0.2;
    }
  EXPECT_NEAR(shot.judge().still_coming, 0.04, 1e-12);
}

TEST(Shields, verdicts_are_the_same_on_any_number_of_ranks) {
  const auto hit = [](const Comm& comm) {
    Scenery shot(comm, turned[2]);
    shot.drill(-4 * d, 0, 4 * d);
    throw_flake(shot, 5 * d, 3 * d, 70);
    return std::pair(shot.judge(), shot.coming());
  };
  const auto [many, met] = hit(testing_world());
  const auto [one, met_alone] = hit(alone());
  EXPECT_EQ(many.outcome, one.outcome);
  EXPECT_EQ(many.openings, one.openings);
  EXPECT_EQ(many.hole, one.hole);
  EXPECT_EQ(many.margin, one.margin);
  EXPECT_NEAR(many.thinnest, one.thinnest, 1e-12 * thickness);
  EXPECT_EQ(many.spall_pieces, one.spall_pieces);
  EXPECT_NEAR(many.spall_mass, one.spall_mass, 1e-12 * one.spall_mass);
  EXPECT_NEAR(many.spall_speed, one.spall_speed, 1e-9);
  EXPECT_NEAR(many.still_coming, one.still_coming, 1e-12);
  EXPECT_GT(met.meets, 0);
  EXPECT_NEAR(met.meets, met_alone.meets, 1e-12 * met.meets);
  EXPECT_NEAR(met.diameter, met_alone.diameter, 1e-12 * met.diameter);
}

TEST(Shields, margins_survive_a_restart_and_are_told_with_the_verdict) {
  const Scenery shot(testing_world(), {});
  Shields walls(shot.world.comm, shot.scene), resumed(shot.world.comm, shot.scene);
  walls.watch(shot.world, *shot.engine);
  walls.read_out(shot.world, *shot.engine, 1);
  walls.read_out(shot.world, *shot.engine, 2);
  Scalars scalars;
  walls.save(scalars);
  resumed.load(scalars);
  ResultTable one, two;
  const auto said = walls.conclude(shot.world, *shot.engine, 2, one);
  EXPECT_EQ(said, resumed.conclude(shot.world, *shot.engine, 2, two));
  EXPECT_EQ(said.at(0).substr(0, 26), "rear wall: held, margin 0.");
  EXPECT_EQ(one.toml(), two.toml());
  EXPECT_EQ(one.toml().find("largest_met_size = [nan"), std::string::npos);
  for (const char* key : {"diameter", "density"})  // as of files that know neither
    scalars.erase(std::string("shield_rear_wall.largest_met_") + key);
  Shields former(shot.world.comm, shot.scene);
  former.load(scalars);
  ResultTable of_former;
  former.conclude(shot.world, *shot.engine, 2, of_former);
  EXPECT_NE(of_former.toml().find("largest_met_diameter = nan"), std::string::npos);
  EXPECT_EQ(one.toml().find("[shield_rear_wall]\nwall = \"rear wall\"\nverdict = \"held\""), 0u);
  EXPECT_NE(one.toml().find("times = [1.0, 2.0]"), std::string::npos);
}

/// A ball of four bodies across on a wall two thick, with the verdict in the end. All of it is
/// turned about x by this angle, degrees.
WallVerdict shoot(double speed, double turn = 0) {
  const double c = std::cos(turn * pi / 180), s = std::sin(turn * pi / 180);
  const auto along = [&](double z, const std::string& unit) {
    return fmt::format(R"([0, "{:.17g} {}", "{:.17g} {}"])", -s * z, unit, c * z, unit);
  };
  const std::string rotation = fmt::format(R"(rotation = ["{} deg", 0, 0])", turn);
  const auto scene =
      std::make_shared<Case>(parse_case(solids + R"(
[[groups]]
name = "wall"
material = "al"
volume = {shape = "cylinder", diameter = "20 mm", height = "2 mm", )" +
                                            rotation + R"(}
packing = {kind = "fcc", diameter = "1 mm", orientation = "random"}
[[groups]]
name = "ball"
material = "al"
volume = {shape = "sphere", diameter = "4 mm"}
packing = {kind = "fcc", diameter = "1 mm", )" +
                                            rotation + R"(}
[[phases]]
name = "hit"
method = "solid"
step = "8 ns"
duration = "6 us"
[[shields]]
wall = "wall"
)",
                                        "x.toml",
                                        {"groups.ball.volume.center=" + along(3.3, "mm"),
                                         "groups.ball.velocity=" + along(-speed, "m/s")}));
  const Comm comm = testing_world();
  const ShieldWall wall = lay_wall(comm, *scene, scene->shields[0]);
  Simulation run(comm, Scene(scene));
  run.run_until(1);
  return judge_wall(comm, run.engine().links(run.world()), wall);
}

TEST(Shields, a_thin_wall_holds_a_slow_ball_and_is_perforated_by_a_fast_one) {
  const WallVerdict slow = shoot(200), fast = shoot(3000);
  EXPECT_EQ(slow.outcome, Outcome::held);
  EXPECT_GT(slow.margin, 0.7);
  EXPECT_EQ(fast.outcome, Outcome::perforated);
  EXPECT_GT(fast.hole, 4 * d);
  EXPECT_LT(fast.hole, 12 * d);
  EXPECT_LT(fast.still_coming, 1e-3);
}

TEST(Shields, a_scene_that_is_turned_as_a_whole_ends_the_same) {
  const WallVerdict upright = shoot(400), tilted = shoot(400, 33);
  EXPECT_EQ(upright.outcome, tilted.outcome);
  EXPECT_NEAR(upright.thinnest, tilted.thinnest, 1e-6 * d);
  EXPECT_NEAR(upright.hole, tilted.hole, 1e-6 * d);
  EXPECT_NEAR(upright.still_coming, tilted.still_coming, 1e-6);
}

TEST(Shields, a_lattice_that_leaves_much_of_its_volume_out_is_told) {
  const auto told = [](const std::string& packing) {
    const Case scene = read({.packing = R"({kind = "fcc", diameter = "1 mm")" + packing + "}"});
    return describe_phases(scene, measure_groups(scene)).find("groups.rear wall: its lattice has ");
  };
  EXPECT_NE(told(""), std::string::npos);  // whole spheres, in layers along the faces
  EXPECT_EQ(told(R"(, orientation = "random")"), std::string::npos);
}

TEST(Shields, what_cannot_be_judged_is_refused) {
  const auto complaint = [](const Asked& asked) { return complaint_of([&] { read(asked); }); };
  const auto starts = [](const std::string& text, const std::string& with) {
    EXPECT_EQ(text.substr(0, with.size()), with);
  };
  const std::string place = "x.toml:22:1: shields.0", wall = place + ".wall = \"rear wall\"";
  EXPECT_EQ(complaint({}), "");
  starts(complaint({.size = R"(["6 mm", "6 mm", "6 mm"])"}), wall + " is no plate");
  starts(complaint({.size = R"(["28 mm", "7 mm", "6 mm"])"}),
         wall + " is 0.007 m wide; 8 spacings");
  starts(complaint({.way = "[1, 0, 0]"}), wall + ": no group flies at it along z");
  starts(complaint({.way = "[0, 0, -1]"}), wall + ": no group flies at it along z");
  starts(complaint({.way = "[0, 0, -1]", .more = "rear = [0, 0, -2]"}), wall + ": no group flies");
  starts(complaint({.from = "[40e-3, 0, -10e-3]"}), wall + ": no group flies at it along z");
  starts(complaint({.from = "[15e-3, 0, -10e-3]"}), wall + ": groups.ball flies at");
  starts(complaint({.from = "[11e-3, 0, -10e-3]"}), wall + ": groups.ball flies at");  // by half
  EXPECT_EQ(complaint({.way = "[-4, 0, 1]", .from = "[40e-3, 0, -10e-3]"}), "");
  // Nor where a disc ends, which is before the corners of the square around it.
  const auto at_disc = [&](const std::string& from) {
    return complaint(
        {.volume = R"({shape = "cylinder", diameter = "30 mm", height = "6 mm"})", .from = from});
  };
  EXPECT_EQ(at_disc("[7e-3, 7e-3, -10e-3]"), "");
  starts(at_disc("[8e-3, 8e-3, -10e-3]"), wall + ": groups.ball flies at its rim");
  starts(complaint({.before = R"([[phases]]
name = "first"
method = "nonsmooth"
step = "1 us"
duration = "1 us"
)"}),
         "x.toml:27:1: shields.0.wall = \"rear wall\": phases.first.method = \"nonsmooth\" cannot");
  const Asked thin{.size = R"(["28 mm", "24 mm", "3 mm"])",
                   .packing = R"({kind = "fcc", diameter = "1 mm"})"};
  starts(complaint_of([&] { Scenery(testing_world(), thin); }), wall + ": its bodies have 0.");
  starts(complaint({.of_wall = "spin = [0, 0, 1]"}), wall + " spins: ");
  starts(complaint(
             {.before = "[[planes]]\nname = \"prop\"\npoint = [0, 0, 1]\nnormal = [0, 0, -1]\n"}),
         "x.toml:26:1: shields.0.wall = \"rear wall\": [[planes]], [[boxes]] or [[cylinders]] may");
  starts(complaint({.more = "rear = [0, 1, 0]"}), place + ".rear does not lead through");
  starts(complaint({.more = "rear = [0, 0, -1]"}), place + ".rear leads against what flies at");
  starts(complaint({.more = "[[phases]]\nname = \"on\"\nmethod = \"solid\"\nstep = \"1 ns\"\n"
                            "duration = \"1 us\"\nremove_drift = true"}),
         "x.toml:24:1: phases.on.remove_drift would move groups.rear wall from where");
  starts(complaint({.more = "rear = [0, 2, 1]"}), place + ".rear does not lead through");
  EXPECT_EQ(complaint({.more = "rear = [0, 1, 2]"}), "");
  const std::string tilted = R"(["28 mm", "24 mm", "6 mm"], rotation = [0, "90 deg", 0])";
  starts(complaint({.size = tilted}), wall + ": no group flies at it along x");
  starts(complaint({.size = tilted,
                    .way = "[1, 0, 0]",
                    .from = "[-10e-3, 0, 0]",
                    .more = "rear = [0, 0, 1]"}),
         place + ".rear does not lead through");
  starts(complaint({.more = "[[shields]]\nwall = \"rear wall\""}),
         "x.toml:24:1: shields.1.wall = \"rear wall\": \"rear wall\" has the section "
         "[shield_rear_wall] of the results already");
  starts(complaint({.more = "[[shields]]\nwall = \"front\""}),
         "x.toml:24:1: shields.1.wall = \"front\" is not one of [[groups]]");
  starts(complaint({.more = "[[shields]]\nwall = \"ball\""}),
         "x.toml:24:1: shields.1.wall = \"ball\" is no plate");
  starts(complaint({.more = "[solid]\nelastic = true"}),
         wall + ": phases.hit.method = \"solid\" cannot break it");
}

}  // namespace
}  // namespace spall
