// [[planes]], [[boxes]], [[cylinders]] and [periodic]: what is around the bodies.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/read_walls.hpp"

#include "scene/materials.hpp"

namespace spall {
namespace {

int read_material_of_wall(Section& in, const Case& scene) {
  std::string name;
  in.take("material", "one of [materials]; left out: that of the body which meets it", name);
  return find_material(in, name, scene.materials);
}

}  // namespace

void read_walls(Section& in, Case& scene) {
  in.tables("planes", "[[planes]]: half-spaces that never move", [&](Section& s) {
    Plane& plane = scene.planes.emplace_back();
    s.take("point", "on the surface", plane.point, any(dimension::length));
    s.take("normal", "to the free side", plane.normal, any(dimension::number));
    s.check("normal", !plane.normal.isZero(0), "is zero");
    plane.normal.normalize();
    plane.material = read_material_of_wall(s, scene);
  });
  in.tables("boxes", "[[boxes]]: bodies are inside, between six planes", [&](Section& s) {
    Vec3 center = Vec3::Zero(), size = Vec3::Zero();
    s.take("center", "", center, any(dimension::length));
    s.need("size", "full widths", size, positive(dimension::length));
    const int material = read_material_of_wall(s, scene);
    for (int k = 0; k < 3; ++k)
      for (double side : {-1.0, 1.0})
        scene.planes.push_back(
            {center + side / 2 * size[k] * Vec3::Unit(k), -side * Vec3::Unit(k), material});
  });
  in.tables("cylinders", "[[cylinders]]: endless, bodies are inside", [&](Section& s) {
    Cylinder& cylinder = scene.cylinders.emplace_back();
    s.take("point", "on the axis", cylinder.point, any(dimension::length));
    s.take("axis", "", cylinder.axis, any(dimension::number));
    s.radius("", cylinder.radius);
    s.check("axis", !cylinder.axis.isZero(0), "is zero");
    cylinder.axis.normalize();
    cylinder.material = read_material_of_wall(s, scene);
  });
  in.table("periodic", "space repeats itself", [&](Section& s) {
    s.take("low", "corner of the box that repeats", scene.period.low, any(dimension::length));
    s.need("size", "of the box; 0: does not repeat in this direction", scene.period.size,
           not_negative(dimension::length));
  });
}

}  // namespace spall
