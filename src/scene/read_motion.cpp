// Parts of a motion add up; each is a key or a table of its own.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/read_motion.hpp"

#include <algorithm>

#include "spall/error.hpp"

namespace spall {
namespace {

using namespace dimension;

void read_rotation(Section& in, PrescribedMotion& motion) {
  in.take("point", "on the axis, at the start; left out: volume.center", motion.point, any(length));
  in.need("axis", "through it; it goes along with the other parts", motion.axis, any(number));
  in.need("rate", "about it", motion.rate, any(spin));
  in.check("axis", !motion.axis.isZero(0), "is zero");
  motion.axis.normalize();
}

void read_oscillation(Section& in, PrescribedMotion& motion) {
  in.need("amplitude", "of amplitude sin(2 pi t/period + phase), less that at t = 0",
          motion.amplitude, any(length));
  in.need("period", "", motion.period, positive(time));
  in.take("phase", "", motion.phase, any(dimension::angle));
}

void read_table(Section& in, PrescribedMotion& motion) {
  std::vector<double> times;
  std::vector<Vec3> displacements, velocities;
  in.need("times", "ascending; at rest before the first and after the last", times,
          not_negative(time));
  in.take("displacements", "one a time, straight in between; less that at t = 0", displacements,
          any(length));
  in.take("velocities", "in place of displacements; one a time, linear in between", velocities,
          any(speed));
  const bool by_velocities = in.has("velocities");
  const std::string_view given = by_velocities ? "velocities" : "displacements";
  in.check("velocities", !by_velocities || !in.has("displacements"),
           "is given beside displacements: give one of them");
  in.check("displacements", by_velocities || in.has("displacements"),
           "is missing; or give velocities");
  const std::size_t rows = by_velocities ? velocities.size() : displacements.size();
  in.check(
      given, rows == times.size() && rows >= 2,
      fmt::format("has {} rows for {} times; one each is wanted, two or more", rows, times.size()));
  in.check("times", std::ranges::adjacent_find(times, std::greater_equal{}) == times.end(),
           "do not ascend");
  if (by_velocities)
    motion.set_velocities(std::move(times), std::move(velocities));
  else
    motion.set_displacements(std::move(times), std::move(displacements));
}

void read_motion(Section& in, PrescribedMotion& motion) {
  const auto parts = {"velocity", "rotation", "oscillation", "table"};
  in.take("velocity", "constant", motion.velocity, any(speed));
  in.table("rotation", "about an axis", [&](Section& s) { read_rotation(s, motion); });
  in.table("oscillation", "", [&](Section& s) { read_oscillation(s, motion); });
  in.table("table", "against time", [&](Section& s) { read_table(s, motion); });
  in.check("", std::ranges::any_of(parts, [&](const char* part) { return in.has(part); }),
           "tells no motion: give velocity, rotation, oscillation or table");
}

}  // namespace

void read_motion_of_group(Section& in, Group& group) {
  PrescribedMotion motion;
  motion.point = group.volume.center;
  in.take("fixed", "never moves, whatever acts on it", group.fixed);
  if (in.table("motion", "prescribed, whatever acts on it: parts that add up, t since the start",
               [&](Section& s) { read_motion(s, motion); }))
    group.motion = motion;
  in.check("motion", !group.motion || !group.fixed, "is given beside fixed: a fixed group stays");
  for (const char* key : {"velocity", "spin"}) {
    in.check(key,
             !group.fixed || !in.has(key) || (group.velocity.isZero(0) && group.spin.isZero(0)),
             "is that of a fixed group, which never moves: prescribe it by motion instead");
    in.check(key, !group.motion || !in.has(key), "is given beside motion, which tells it");
  }
  in.check("total_mass", !group.held() || !in.has("total_mass"),
           "is that of a group which moves as prescribed or not at all: it has no mass");
}

void gather_motions(Case& scene) {
  const auto moves = [](const Group& group) { return group.motion.has_value(); };
  const auto moving = std::ranges::find_if(scene.groups, moves);
  if (moving == scene.groups.end()) return;
  for (const Phase& phase : scene.phases) {
    require(phase.engine->moves_groups, "{}: phases.{}.method = \"{}\" knows no motion of groups",
            moving->place, phase.name, phase.engine->name);
    require(!phase.impactor,
            "{}: phases.{}.impactor is aimed at bodies where they are: no group may move as "
            "prescribed meanwhile",
            moving->place, phase.name);
  }
  for (const Group& group : scene.groups) scene.motions.push_back(group.motion);
}

}  // namespace spall
