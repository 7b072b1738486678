// Only shapes that are used are worked out; where all of them are spheres nothing changes.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/read_shapes.hpp"

#include <algorithm>

#include "scene/packing.hpp"
#include "spall/error.hpp"

namespace spall {

using namespace dimension;

void read_shape(Section& in, ListedShape& shape) {
  in.tables("spheres", "that the shape is made of; packings scale them", [&](Section& s) {
    ShapeSphere& sphere = shape.spheres.emplace_back();
    s.need("at", "its centre", sphere.at, any(length));
    s.radius("", sphere.radius);
  });
  const bool listed = !shape.spheres.empty();
  Vec3 axes = Vec3::Ones();
  std::int64_t count = 0;
  if (in.reads(!listed)) {
    in.need("axes", "in place of spheres: of the ellipsoid that is filled with them", axes,
            positive(length));
    in.need("count", "of axes: spheres in it", count, 1);
    constexpr std::int64_t most = 100;
    in.check("count", count <= most, fmt::format("is more than {}", most));
  }
  shape.place = in.place();
  if (!listed && count > 0) shape.spheres = fill_ellipsoid(axes, static_cast<int>(count));
}

namespace {

void check_group(const Case& scene, const Group& group) {
  require(group.packing.file.empty(), "{}: packing.shape: bodies of a file have their own",
          group.place);
  require(!scene.materials[group.material].solid,
          "{}: packing.shape: materials.{} is a solid, whose bodies are spheres", group.place,
          scene.materials[group.material].name);
  for (const Phase& phase : scene.phases)
    require(phase.engine->has_shapes,
            "{}: packing.shape: phases.{}.method = \"{}\" knows spheres alone; \"nonsmooth\" knows "
            "shapes",
            group.place, phase.name, phase.engine->name);
}

}  // namespace

void gather_shapes(Case& scene) {
  BodyShapes shapes(1);
  shapes[0].name = "sphere";
  for (Group& group : scene.groups) {
    Packing& packing = group.packing;
    if (packing.shape_name.empty()) continue;
    const auto listed =
        std::ranges::find(scene.listed_shapes, packing.shape_name, &ListedShape::name);
    require(listed != scene.listed_shapes.end(), "{}: packing.shape: \"{}\" is not in [shapes]",
            group.place, packing.shape_name);
    if (listed->spheres.size() == 1) continue;
    check_group(scene, group);
    const auto known = std::find_if(shapes.begin() + 1, shapes.end(), [&](const BodyShape& shape) {
      return shape.name == packing.shape_name;
    });
    packing.shape = static_cast<std::int32_t>(known - shapes.begin());
    if (known != shapes.end()) continue;
    try {
      shapes.push_back(make_shape(listed->name, listed->spheres));
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", listed->place, error.what()));
    }
  }
  if (shapes.size() > 1) scene.shapes = std::move(shapes);
}

}  // namespace spall
