// Reads what is to be measured of debris.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/debris.hpp"

#include <algorithm>
#include <cmath>

#include "scene/consistency.hpp"
#include "scene/shape.hpp"
#include "scene/shields.hpp"
#include "spall/error.hpp"

namespace spall {

void read_debris(Section& in, DebrisSettings& debris) {
  in.need("projectile", "one of groups, with a velocity", debris.projectile_name);
  std::string plate;
  std::vector<std::string> plates;
  in.take("plate", "one of groups: a box, or a cylinder", plate);
  in.take("plates", "instead: several, each measured as if it were alone", plates);
  in.check("plate", in.has("plate") != in.has("plates"), "or plates is wanted, one of them");
  if (in.has("plate")) debris.plates.push_back({.name = plate, .group = -1, .section = ""});
  for (const std::string& name : plates)
    debris.plates.push_back({.name = name, .group = -1, .section = section_end(name)});
  in.check("plates", !in.has("plates") || !plates.empty(), "names no plate");
  in.take("every", "simulated; 0: at the end only", debris.every, not_negative(dimension::time));
  in.take("wall", "behind the plate: what a wall would receive there", debris.wall,
          positive(dimension::length));
  debris.place = in.place();
}

namespace {

/// A plate at rest, at whose rear face debris begin, and which the projectile's line meets.
void check_plate(const Case& scene, int group, const std::string& told) {
  const Group &plate = scene.groups[group], &ball = scene.groups[scene.debris->projectile];
  const Volume& volume = plate.volume;
  require(volume.shape == Shape::box || volume.shape == Shape::cylinder,
          "{} is neither a box nor a cylinder", told);
  const int thin = axis_through(volume);
  require(thin >= 0, "{} is no plate: it must be thinner along one axis than along the others",
          told);
  require(!plate.held(), "{} is {}: nothing can break it", told,
          plate.fixed ? "fixed" : "moved as prescribed");
  require(plate.velocity.isZero(0) && plate.spin.isZero(0),
          "{} moves: debris are measured behind a plate that rests; give the projectile the "
          "velocity of both",
          told);
  const Vec3 normal = volume.axes.col(thin);
  const std::string projectile =
      fmt::format("{}.projectile = \"{}\"", scene.debris->place, ball.name);
  require(!ball.held(), "{} has no mass of its own: it is {}", projectile,
          ball.fixed ? "fixed" : "moved as prescribed");
  const double speed = speed_across(ball.velocity, normal);
  require(speed != 0, "{} has no velocity towards the plate, along {}", projectile,
          words_of_direction(normal));
  const double ahead = normal.dot(volume.center - ball.volume.center);
  require(ahead / speed > 0, "{} flies away from \"{}\"", projectile, plate.name);
  const double lasts = duration_of(scene.phases);
  const double gap = std::abs(ahead) - half_widths(volume)[thin] -
                     half_widths_in_world(ball.volume).dot(normal.cwiseAbs());
  const double flight = gap / std::abs(speed);
  require(flight < lasts, "{} needs {:.3g} s to \"{}\", and phases end after {:.3g} s", projectile,
          flight, plate.name, lasts);
  require(miss_of_line(volume, ball.volume.center, ball.velocity) < 0,
          "{} flies past \"{}\": its line does not meet it", projectile, plate.name);
  if (!scene.debris->wall) return;
  const Vec3 behind = speed < 0 ? Vec3(-normal) : normal;
  for (const Group& other : scene.groups) {
    const double depth = behind.dot(other.volume.center - volume.center) +
                         half_widths_in_world(other.volume).dot(normal.cwiseAbs());
    require(&other == &plate || &other == &ball || depth <= half_widths(volume)[thin],
            "{}.wall = {:g} m is what a wall would receive behind \"{}\", where debris fly freely, "
            "and groups.{} may stop them",
            scene.debris->place, *scene.debris->wall, plate.name, other.name);
  }
}

}  // namespace

void find_debris_groups(Case& scene) {
  if (!scene.debris) return;
  DebrisSettings& debris = *scene.debris;
  const auto find = [&](const std::string& key, const std::string& name) {
    const auto found = std::ranges::find(scene.groups, name, &Group::name);
    require(found != scene.groups.end(), "{}.{} = \"{}\" is not one of [[groups]]", debris.place,
            key, name);
    return static_cast<int>(found - scene.groups.begin());
  };
  for (const Phase& phase : scene.phases)
    require(!phase.remove_drift,
            "{}.remove_drift would move groups.{} from where [debris] looks at it", phase.place,
            debris.plates.front().name);
  require(!scene.period.any(), "{}: debris are not measured in a [periodic] box", debris.place);
  require(scene.walls().size() == 0,
          "{}: debris are measured where they fly freely, and a wall of [[planes]], [[boxes]] or "
          "[[cylinders]] may stop them",
          debris.place);
  debris.projectile = find("projectile", debris.projectile_name);
  for (DebrisPlate& plate : debris.plates) {
    const std::string key = plate.section.empty() ? "plate" : "plates";
    plate.group = find(key, plate.name);
    require(plate.group != debris.projectile, "{}.{} = \"{}\" is the projectile", debris.place, key,
            plate.name);
    for (const DebrisPlate& other : debris.plates)
      require(&other == &plate || other.section != plate.section,
              "{}.plates: \"{}\" and \"{}\" would have the same sections of the results",
              debris.place, other.name, plate.name);
    check_plate(scene, plate.group, fmt::format("{}.{} = \"{}\"", debris.place, key, plate.name));
  }
}

}  // namespace spall
