// Volumes and how they are packed: one line a key.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/read_group.hpp"

#include <filesystem>

#include "scene/materials.hpp"
#include "scene/packing.hpp"
#include "scene/read_motion.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using namespace dimension;  // length, mass, time, speed ...: the units of the keys

constexpr Choice<Shape> shapes[] = {
    {"sphere", Shape::sphere},       {"box", Shape::box},
    {"ellipsoid", Shape::ellipsoid}, {"hollow_sphere", Shape::hollow_sphere},
    {"cylinder", Shape::cylinder},   {"mesh", Shape::mesh}};

void read_volume(Section& in, Volume& volume) {
  in.take("shape", "", volume.shape, shapes);
  in.take("center", "of volume", volume.center, any(length));
  const Shape shape = volume.shape;
  const bool box = shape == Shape::box || shape == Shape::ellipsoid;
  const bool mesh = shape == Shape::mesh;
  if (in.reads(mesh)) {
    in.need("file",
            "of mesh: Wavefront OBJ, closed; beside the case; its center of volume is center",
            volume.file);
    in.take("unit", "of mesh: what 1 in its file is", volume.unit, positive(length));
  }
  if (in.reads(!box && !mesh)) in.radius("of sphere, hollow_sphere, cylinder", volume.radius);
  if (in.reads(box))
    in.need("size", "full widths of box, ellipsoid", volume.extents, positive(length));
  if (in.reads(shape == Shape::hollow_sphere)) {
    in.need("inner_radius", "of hollow_sphere", volume.inner_radius, positive(length));
    in.check("inner_radius", volume.inner_radius < volume.radius, "is not smaller than radius");
  }
  if (in.reads(shape == Shape::cylinder)) {
    double height = 0;
    in.need("height", "of cylinder, along its z", height, positive(length));
    volume.extents = {2 * volume.radius, 2 * volume.radius, height};
  }
  if (in.reads(box || mesh || shape == Shape::cylinder)) {
    Vec3 turn = Vec3::Zero();
    in.take("rotation",
            "of box, ellipsoid, cylinder, mesh: rotation vector about center; lattices and bodies "
            "of file in it turn along",
            turn, any(dimension::angle));
    volume.axes = turn_by(turn).toRotationMatrix();
  }
}

void read_packing(Section& in, Packing& packing) {
  const auto types = all_packings();
  std::vector<std::string_view> names;
  for (const PackingType* type : types) names.push_back(type->name);
  std::size_t chosen = 0;
  in.need("kind", "single: one sphere, the volume itself", chosen, names);
  packing.type = types[chosen];
  if (in.reads(packing.type->sized && !in.has("sizes")))
    in.radius("of the spheres; of graded: of the largest", packing.radius);
  // Lattices have their keys in common, which the reference of all keys lists once.
  for (auto type = types.begin(); type != types.end(); ++type)
    if (std::find_if(types.begin(), type,
                     [&](const PackingType* earlier) { return earlier->read == (*type)->read; }) ==
            type &&
        in.reads((*type)->read == packing.type->read))
      (*type)->read(in, packing);
  if (in.reads(packing.type->turns))
    in.take("rotation", "of lattices, file, and a single body with a shape: rotation vector",
            packing.rotation, any(dimension::angle));
  std::string shape;
  in.take("shape", "of the bodies, one of [shapes]; radius is that of the sphere around it", shape);
  in.take("shapes", "in place of shape: several, of which each body draws one",
          packing.shape_names);
  in.check("shape", !in.has("shape") || !in.has("shapes"), "is given beside shapes: give one");
  if (in.has("shape")) packing.shape_names = {shape};
  in.check("rotation",
           packing.type != &single_packing || !packing.shape_names.empty() || !in.has("rotation"),
           "is that of a sphere, which looks the same from all sides; or give it a shape");
}

/// As LAMMPS's `velocity create`: without a drift, and of exactly the rms that is asked for.
void read_thermal_velocity(Section& in, Group& group) {
  ThermalVelocity thermal;
  std::int64_t seed = 1;
  if (!in.table("thermal_velocity", "random, Maxwell's, beside velocity: the group has no drift",
                [&](Section& s) {
                  s.need("rms", "of each component", thermal.rms, positive(speed));
                  s.take("seed", "another draws others", seed, 0);
                }))
    return;
  in.check("thermal_velocity", !group.held(), "is of no use: the group is fixed or moved");
  thermal.seed = static_cast<std::uint64_t>(seed);
  group.thermal = thermal;
}

}  // namespace

void read_group(Section& in, Group& group, const std::vector<Material>& materials,
                const std::string& folder) {
  std::string material;
  in.need("name", "", group.name);
  in.check("name", !group.name.empty(), "is empty");
  in.need("material", "one of [materials]", material);
  const bool has_volume =
      in.table("volume", "what is filled", [&](Section& s) { read_volume(s, group.volume); });
  in.check("volume", has_volume, "is missing, such as {shape = \"sphere\", radius = \"95 m\"}");
  in.table("packing", "how it is filled; left out: single",
           [&](Section& s) { read_packing(s, group.packing); });
  in.take("velocity", "of the volume's center", group.velocity, any(speed));
  in.take("spin", "rigid rotation about the volume's center", group.spin, any(spin));
  in.take("total_mass", "the density is scaled to give it", group.total_mass, positive(mass));
  read_motion_of_group(in, group);
  read_thermal_velocity(in, group);
  group.material = find_material(in, material, materials);
  const bool single = group.packing.type == &single_packing;
  in.check("volume", !single || group.volume.shape == Shape::sphere,
           "is not a sphere: a single packing is one sphere");
  if (single) group.packing.radius = group.volume.radius;
  for (std::string* file : {&group.volume.file, &group.packing.file})
    if (!file->empty()) *file = (std::filesystem::path(folder) / *file).lexically_normal().string();
  group.place = in.place();
}

void load_meshes(Case& scene, const InputFiles& files) {
  for (Group& group : scene.groups) {
    Volume& volume = group.volume;
    if (volume.shape != Shape::mesh || volume.mesh) continue;
    try {
      volume.mesh = std::make_shared<const SurfaceMesh>(
          SurfaceMesh::from_obj(files.text(volume.file), volume.file, volume.unit));
    } catch (const Error& error) {
      throw Error(fmt::format("{}: volume.file: {}", group.place, error.what()));
    }
  }
}

}  // namespace spall
