// Only shapes that are used are worked out; where all of them are spheres nothing changes.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/read_shapes.hpp"

#include <algorithm>
#include <filesystem>

#include "keys/toml_text.hpp"
#include "scene/packing.hpp"
#include "scene/sphere_fill.hpp"
#include "spall/error.hpp"

namespace spall {

using namespace dimension;

namespace {
constexpr std::int64_t most_spheres_filled = 100;
}

void insert_filled_shapes(toml::table& root, const std::string& file,
                          std::vector<std::string>& kept, const InputFiles& files) {
  toml::table* shapes = root["shapes"].as_table();
  if (!shapes) return;
  for (auto&& [name, node] : *shapes) {
    toml::table* shape = node.as_table();
    if (!shape) continue;
    // What is none, or no such number, is refused where the keys are read. File "" is of a restart
    // file, which holds the spheres.
    const auto named = (*shape)["file"].value<std::string>();
    const auto count = (*shape)["count"].value<std::int64_t>().value_or(0);
    if (!named || named == "" || count < 1 || count > most_spheres_filled) continue;
    toml::array spheres;
    std::string text;
    try {
      require(!shape->contains("spheres"), "spheres are listed too: one is wanted");
      const std::string path = (std::filesystem::path(file).parent_path() / *named).string();
      const SurfaceMesh mesh = SurfaceMesh::from_obj(files.text(path), path, 1);
      for (const ShapeSphere& sphere : fill_mesh(mesh, static_cast<int>(count))) {
        const Vec3& at = sphere.at;
        spheres.push_back(
            toml::table{{"at", toml::array{at.x(), at.y(), at.z()}}, {"radius", sphere.radius}});
        text += fmt::format("{{at = [{}, {}, {}], radius = {}}}, ", at.x(), at.y(), at.z(),
                            sphere.radius);
      }
    } catch (const Error& error) {
      throw Error(fmt::format("{}:{}: shapes.{}.file: {}", file,
                              (*shape)["file"].node()->source().begin.line, name.str(),
                              error.what()));
    }
    const std::string place = "shapes." + toml_string(name.str());
    kept.push_back(fmt::format("{}.spheres=[{}]", place, text));
    kept.push_back(place + ".file=\"\"");
    shape->insert_or_assign("spheres", std::move(spheres));
  }
}

void read_shape(Section& in, ListedShape& shape) {
  in.tables("spheres", "that the shape is made of; packings scale them", [&](Section& s) {
    ShapeSphere& sphere = shape.spheres.emplace_back();
    s.need("at", "its centre", sphere.at, any(length));
    s.radius("", sphere.radius);
  });
  const bool listed = !shape.spheres.empty();
  Vec3 axes = Vec3::Ones();
  std::int64_t count = 0;
  std::string file;
  in.take(
      "file",
      "in place of spheres: Wavefront OBJ, closed, beside the case; is filled with them; of its "
      "size only ratios count",
      file);
  const bool filled = in.has("file");
  if (in.reads(!listed && !filled))
    in.need("axes", "in place of spheres: of the ellipsoid that is filled with them", axes,
            positive(length));
  if (in.reads(!listed || filled)) {
    in.need("count", "of file and axes: spheres in it", count, 1);
    in.check("count", count <= most_spheres_filled,
             fmt::format("is more than {}", most_spheres_filled));
  }
  for (const ShapeSphere& one : shape.spheres)
    for (const ShapeSphere& other : shape.spheres)
      in.check("spheres", &one == &other || (one.at - other.at).norm() + one.radius > other.radius,
               "has a sphere that lies within another: contacts would count it, too");
  shape.place = in.place();
  if (!listed && !filled && count > 0)
    shape.spheres = fill_ellipsoid(axes, static_cast<int>(count));
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
            "{}: packing.shape: phases.{}.method = \"{}\" knows spheres alone; \"nonsmooth\" and "
            "\"penalty\" know shapes",
            group.place, phase.name, phase.engine->name);
}

}  // namespace

void gather_shapes(Case& scene) {
  BodyShapes shapes(1);
  shapes[0].name = "sphere";
  /// The place of a shape, which is worked out where it is not known yet.
  const auto place_of = [&](const Group& group, const std::string& name) {
    const auto listed = std::ranges::find(scene.listed_shapes, name, &ListedShape::name);
    require(listed != scene.listed_shapes.end(), "{}: packing.shape: \"{}\" is not in [shapes]",
            group.place, name);
    if (listed->spheres.size() == 1) return std::int32_t{0};
    check_group(scene, group);
    const auto known = std::ranges::find(shapes.begin() + 1, shapes.end(), name, &BodyShape::name);
    const auto place = static_cast<std::int32_t>(known - shapes.begin());
    if (known != shapes.end()) return place;
    try {
      shapes.push_back(make_shape(listed->name, listed->spheres));
    } catch (const Error& error) {
      throw Error(fmt::format("{}: {}", listed->place, error.what()));
    }
    return place;
  };
  for (Group& group : scene.groups)
    for (const std::string& name : group.packing.shape_names)
      group.packing.shapes.push_back(place_of(group, name));
  if (shapes.size() > 1) scene.shapes = std::move(shapes);
}

}  // namespace spall
