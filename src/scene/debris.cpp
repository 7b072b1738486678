// Reads what is to be measured of debris.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/debris.hpp"

#include <algorithm>

#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {

void read_debris(Section& in, DebrisSettings& debris) {
  in.need("projectile", "one of groups, with a velocity", debris.projectile_name);
  in.need("plate", "one of groups: a box, or a cylinder", debris.plate_name);
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
            debris.plate_name);
  debris.projectile = find("projectile", debris.projectile_name);
  debris.plate = find("plate", debris.plate_name);
  const Volume& plate = scene.groups[debris.plate].volume;
  require(plate.shape == Shape::box || plate.shape == Shape::cylinder,
          "{}.plate = \"{}\" is neither a box nor a cylinder", debris.place, debris.plate_name);
  const Vec3 normal = plate.axes.col(thin_axis(plate));
  require(speed_across(scene.groups[debris.projectile].velocity, normal) != 0,
          "{}.projectile = \"{}\" has no velocity towards the plate, along {}", debris.place,
          debris.projectile_name, words_of_direction(normal));
}

}  // namespace spall
