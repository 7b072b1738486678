// Reads what is to be measured of debris.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/debris.hpp"

#include <algorithm>

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
    const Volume& volume = scene.groups[plate.group].volume;
    require(volume.shape == Shape::box || volume.shape == Shape::cylinder,
            "{}.{} = \"{}\" is neither a box nor a cylinder", debris.place, key, plate.name);
    const Vec3 normal = volume.axes.col(thin_axis(volume));
    require(speed_across(scene.groups[debris.projectile].velocity, normal) != 0,
            "{}.projectile = \"{}\" has no velocity towards the plate, along {}", debris.place,
            debris.projectile_name, words_of_direction(normal));
  }
}

}  // namespace spall
