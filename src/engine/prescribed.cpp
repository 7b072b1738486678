// Places follow from the time and from where bodies were at the start.
// SPDX-License-Identifier: BSD-3-Clause
#include "engine/prescribed.hpp"

#include <algorithm>
#include <array>

#include "spall/error.hpp"

namespace spall {
namespace {

/// Calls `f(row, group, motion)` for every owned body of a group that moves as prescribed.
template <class F>
void for_each_moving(const World& world, F&& f) {
  const auto groups = static_cast<std::int32_t>(world.motions.size());
  if (groups == 0) return;
  const Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) {
    const std::int32_t group = bodies.group[b];
    if (group < groups && world.motions[group]) f(b, group, *world.motions[group]);
  }
}

std::vector<RigidDisplacement> displacements(const World& world, double from, double to) {
  std::vector<RigidDisplacement> moved;
  for (const auto& motion : world.motions)
    moved.push_back(motion ? motion->displacement(from, to) : RigidDisplacement{});
  return moved;
}

}  // namespace

std::vector<Index> set_prescribed_velocities(World& world, double from, double h) {
  std::vector<Index> rows;
  const std::vector<RigidDisplacement> moved = displacements(world, from, from + h);
  Bodies& bodies = world.bodies;
  for_each_moving(world, [&](Index b, std::int32_t group, const PrescribedMotion& motion) {
    bodies.velocity[b] = moved[group].of(bodies.anchor[b]) / h;
    if (bodies.has(Field::angular_velocity)) bodies.angular_velocity[b] = motion.spin();
    rows.push_back(b);
  });
  return rows;
}

std::vector<double> prescribed_accelerations(const World& world, double from, double to) {
  std::vector<double> largest(world.motions.size(), 0.0);
  for_each_moving(world, [&](Index b, std::int32_t group, const PrescribedMotion& motion) {
    largest[group] =
        std::max(largest[group], motion.largest_acceleration(world.bodies.anchor[b], from, to));
  });
  if (!largest.empty()) world.comm.max(largest);
  return largest;
}

double largest_meeting_speed(const World& world, double lasts) {
  const Bodies& bodies = world.bodies;
  std::vector<char> moves(bodies.owned, 0);
  for_each_moving(world, [&](Index b, std::int32_t, const PrescribedMotion&) { moves[b] = 1; });
  RowBox others;
  double turning = 0;  // of one of them
  for (Index b = 0; b < bodies.owned; ++b) {
    if (moves[b]) continue;
    others.add(bodies.velocity[b]);
    turning = std::max(turning, turning_speed(world.shapes, bodies, b));
  }
  if (!world.shapes.empty()) turning = world.comm.max(turning);
  if (world.walls().size() > 0) others.add(Vec3(Vec3::Zero()));
  others = others.united(world.comm);
  if (others.low[0] > others.high[0]) return 0;  // there are none
  const Vec3 low = vector_of(others.low), high = vector_of(others.high);
  double largest = others.diagonal() + 2 * turning;
  for_each_moving(world, [&](Index b, std::int32_t, const PrescribedMotion& motion) {
    const VelocityRange range = motion.velocities(bodies.anchor[b], world.time, world.time + lasts);
    const Vec3 apart = (range.high - low).cwiseMax(high - range.low);
    largest = std::max(
        largest, apart.norm() + range.turning + turning + turning_speed(world.shapes, bodies, b));
  });
  return world.comm.max(largest);
}

std::vector<PrescribedPlace> advance_prescribed(World& world, double t, RowBox& velocities) {
  const double before = world.time;
  world.time += t;
  std::vector<PrescribedPlace> places;
  if (world.motions.empty()) return places;
  const auto meanwhile = displacements(world, before, world.time);
  const auto so_far = displacements(world, 0, world.time);
  const Bodies& bodies = world.bodies;
  for_each_moving(world, [&](Index b, std::int32_t group, const PrescribedMotion&) {
    const Vec3& anchor = bodies.anchor[b];
    const Vec3 place = anchor + so_far[group].of(anchor);
    places.push_back({b, world.period.nearest(place, bodies.position[b])});
    if (t != 0) velocities.add(Vec3(meanwhile[group].of(anchor) / t));
  });
  return places;
}

void move_prescribed(World& world, double t) {
  RowBox velocities;
  for (const auto& [row, position] : advance_prescribed(world, t, velocities))
    world.bodies.position[row] = position;
}

void book_held(World& world, Index b, const Vec3& x, const Vec3& impulse, const Vec3& turn) {
  const Bodies& bodies = world.bodies;
  Reactions::at(world.reactions.of_groups, bodies.group[b]).add(x, impulse, turn);
  double work = impulse.dot(bodies.velocity[b]);
  if (bodies.has(Field::angular_velocity)) work += turn.dot(bodies.angular_velocity[b]);
  world.ledger.prescribed_work -= work;
}

void check_held(const World& world, const std::string& place) {
  constexpr double allowed = 1e-6;  // of the radius: far above round-off, far below a motion
  const Bodies& bodies = world.bodies;
  std::vector<char> moves(bodies.owned, 0);
  std::array<double, 2> wrong{-1, -1};  // ids
  const auto so_far = displacements(world, 0, world.time);
  for_each_moving(world, [&](Index b, std::int32_t group, const PrescribedMotion&) {
    moves[b] = 1;
    const Vec3 there = bodies.anchor[b] + so_far[group].of(bodies.anchor[b]);
    const Vec3 off = world.period.nearest(there, bodies.position[b]) - bodies.position[b];
    if (!(off.norm() <= allowed * bodies.radius[b])) wrong[0] = static_cast<double>(bodies.id[b]);
  });
  for (Index b = 0; b < bodies.owned; ++b) {
    const bool still = bodies.velocity[b].isZero(0) && (!bodies.has(Field::angular_velocity) ||
                                                        bodies.angular_velocity[b].isZero(0));
    if (is_held(bodies, b) && !moves[b] && !still) wrong[1] = static_cast<double>(bodies.id[b]);
  }
  world.comm.max(wrong);
  require(wrong[0] < 0,
          "{}: body {:.0f} is not where the motion of its group has it at {:g} s: motions may not "
          "change",
          place, wrong[0], world.time);
  require(
      wrong[1] < 0,
      "{}: body {:.0f} is fixed and has a velocity or a spin: what moves without end is a group "
      "with a motion",
      place, wrong[1]);
}

}  // namespace spall
