// [[planes]], [[boxes]], [[cylinders]] and [periodic]: what is around the bodies.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/read_walls.hpp"

#include <algorithm>

#include "scene/materials.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

int read_material_of_wall(Section& in, const Case& scene) {
  std::string name;
  in.take("material", "one of [materials]; left out: that of the body which meets it", name);
  return find_material(in, name, scene.materials);
}

/// A wall's name, which begins the names of its columns in the series.
std::string read_name_of_wall(Section& in, const std::string& by_default) {
  std::string name = by_default;
  in.take("name", "begins its columns in the series; left out: kind and number", name);
  const auto may_stand = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' ||
           c == '-';
  };
  in.check("name", !name.empty() && std::ranges::all_of(name, may_stand),
           fmt::format("= \"{}\": letters, digits, _ and - are wanted", name));
  return name;
}

/// Throws Error where two of walls and held groups, which have columns, share a name of them.
void check_names(const Case& scene) {
  const Walls walls = scene.walls();
  std::vector<std::string> names;
  for (std::size_t w = 0; w < walls.size(); ++w) names.push_back(walls.name(w));
  for (const Group& group : scene.groups)
    if (group.held()) names.push_back(column_name(group.name));
  std::ranges::sort(names);
  const auto twice = std::ranges::adjacent_find(names);
  require(twice == names.end(), "{}: walls and held groups have columns of the same name: \"{}\"",
          scene.file, twice == names.end() ? "" : *twice);
}

}  // namespace

std::string column_name(std::string name) {
  std::ranges::replace_if(
      name, [](char c) { return std::string_view(",/\"\n").find(c) != std::string_view::npos; },
      '_');
  return name;
}

void read_walls(Section& in, Case& scene) {
  in.tables("planes", "[[planes]]: half-spaces that never move", [&](Section& s) {
    const std::string name = read_name_of_wall(s, fmt::format("plane_{}", scene.planes.size()));
    Plane& plane = scene.planes.emplace_back();
    plane.name = name;
    s.take("point", "on the surface", plane.point, any(dimension::length));
    s.take("normal", "to the free side", plane.normal, any(dimension::number));
    s.check("normal", !plane.normal.isZero(0), "is zero");
    plane.normal.normalize();
    plane.material = read_material_of_wall(s, scene);
  });
  std::size_t boxes = 0;
  in.tables("boxes", "[[boxes]]: bodies are inside, between six planes", [&](Section& s) {
    const std::string name = read_name_of_wall(s, fmt::format("box_{}", boxes++));
    Vec3 center = Vec3::Zero(), size = Vec3::Zero();
    s.take("center", "", center, any(dimension::length));
    s.need("size", "full widths", size, positive(dimension::length));
    const int material = read_material_of_wall(s, scene);
    for (int k = 0; k < 3; ++k)
      for (double side : {-1.0, 1.0})
        scene.planes.push_back(
            {center + side / 2 * size[k] * Vec3::Unit(k), -side * Vec3::Unit(k), material,
             fmt::format("{}_{}_{}", name, "xyz"[k], side < 0 ? "low" : "high")});
  });
  in.tables("cylinders", "[[cylinders]]: endless, bodies are inside", [&](Section& s) {
    const std::string name =
        read_name_of_wall(s, fmt::format("cylinder_{}", scene.cylinders.size()));
    Cylinder& cylinder = scene.cylinders.emplace_back();
    cylinder.name = name;
    s.take("point", "on the axis", cylinder.point, any(dimension::length));
    s.take("axis", "", cylinder.axis, any(dimension::number));
    s.radius("", cylinder.radius);
    s.check("axis", !cylinder.axis.isZero(0), "is zero");
    cylinder.axis.normalize();
    cylinder.material = read_material_of_wall(s, scene);
  });
  check_names(scene);
  in.table("periodic", "space repeats itself", [&](Section& s) {
    s.take("low", "corner of the box that repeats", scene.period.low, any(dimension::length));
    s.need("size", "of the box; 0: does not repeat in this direction", scene.period.size,
           not_negative(dimension::length));
  });
}

}  // namespace spall
