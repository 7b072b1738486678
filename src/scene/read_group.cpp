// Volumes and how they are packed: one line a key.
// SPDX-License-Identifier: BSD-3-Clause
#include "read_group.hpp"

#include <algorithm>
#include <filesystem>

#include "spall/base/require.hpp"

namespace spall {
namespace {

using namespace dimension;  // length, mass, time, speed ...: the units of the keys

constexpr Choice<Shape> shapes[] = {
    {"sphere", Shape::sphere},       {"box", Shape::box},
    {"ellipsoid", Shape::ellipsoid}, {"hollow_sphere", Shape::hollow_sphere},
    {"cylinder", Shape::cylinder},   {"mesh", Shape::mesh}};
constexpr Choice<PackingKind> packings[] = {{"single", PackingKind::single},
                                            {"random", PackingKind::random},
                                            {"simple_cubic", PackingKind::simple_cubic},
                                            {"fcc", PackingKind::fcc},
                                            {"hcp", PackingKind::hcp},
                                            {"graded", PackingKind::graded},
                                            {"file", PackingKind::file}};
constexpr Choice<bool> orientations[] = {{"rotation", false}, {"random", true}};

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
    in.need("height", "of cylinder, along z", height, positive(length));
    volume.extents = {2 * volume.radius, 2 * volume.radius, height};
  }
}

void read_grading(Section& in, Packing& packing) {
  Grading& grading = packing.grading;
  in.take("site", "of graded: where spheres are smallest", grading.site, any(length));
  in.need("smallest", "of graded: largest radius at the site", grading.smallest, positive(length));
  in.need("growth", "of graded: largest radius over distance from the site", grading.growth,
          positive(number));
  in.take("exponent", "of graded: N(>r) ~ r^-exponent over a factor of 4 below the largest",
          grading.exponent, any(number));
  in.take("fill", "of graded: part of the volume, 0.5 is near the most", grading.fill,
          Quantity{number, 0, 1, false});
  in.check("smallest", grading.smallest <= packing.radius, "is more than radius");
}

void read_packing(Section& in, Packing& packing) {
  in.need("kind", "single: one sphere, the volume itself", packing.kind, packings);
  const bool single = packing.kind == PackingKind::single;
  const bool random = packing.kind == PackingKind::random;
  const bool graded = packing.kind == PackingKind::graded, file = packing.kind == PackingKind::file;
  const bool lattice = !single && !random && !graded && !file;
  if (in.reads(!single && !file))
    in.radius("of the spheres; of graded: of the largest", packing.radius);
  if (in.reads(graded)) read_grading(in, packing);
  if (in.reads(file))
    in.need("file",
            "of file: a restart file, beside the case; bodies at rest, centre of mass at center",
            packing.file);
  if (in.reads(random)) {
    std::int64_t count = 0;
    in.need("count", "of random: spheres wholly inside the volume", count, 1);
    packing.count = count;
  }
  if (in.reads(lattice)) {
    in.take("spacing", "of lattices, between neighbours; 2 radius", packing.spacing,
            positive(length));
    const double diameter = 2 * packing.radius, spacing = packing.spacing.value_or(diameter);
    in.check("spacing", spacing >= diameter * (1 - 1e-9),
             fmt::format("= {} m is less than the spheres' diameter, {} m", spacing, diameter));
  }
  if (in.reads(lattice))
    in.take("orientation", "of lattices: random is drawn by seed, another for each group",
            packing.random_orientation, orientations);
  if (in.reads(lattice || file))
    in.take("rotation", "of lattices, file: rotation vector", packing.rotation, any(number));
}

}  // namespace

void read_group(Section& in, Group& group, const std::vector<Material>& materials,
                const std::string& folder) {
  std::string material;
  in.need("name", "", group.name);
  in.need("material", "one of [materials]", material);
  const bool has_volume =
      in.table("volume", "what is filled", [&](Section& s) { read_volume(s, group.volume); });
  in.check("volume", has_volume, "is missing, such as {shape = \"sphere\", radius = \"95 m\"}");
  in.table("packing", "how it is filled; left out: single",
           [&](Section& s) { read_packing(s, group.packing); });
  in.take("velocity", "of the volume's center", group.velocity, any(speed));
  in.take("spin", "rigid rotation about the volume's center", group.spin, any(spin));
  in.take("fixed", "never moves", group.fixed);
  in.take("total_mass", "the density is scaled to give it", group.total_mass, positive(mass));
  const auto found = std::ranges::find(materials, material, &Material::name);
  in.check("material", found != materials.end() || !in.has("material"),
           fmt::format("= \"{}\" is not in [materials]", material));
  group.material = static_cast<int>(found - materials.begin());
  const bool single = group.packing.kind == PackingKind::single;
  in.check("volume", !single || group.volume.shape == Shape::sphere,
           "is not a sphere: a single packing is one sphere");
  if (single) group.packing.radius = group.volume.radius;
  for (std::string* file : {&group.volume.file, &group.packing.file})
    if (!file->empty()) *file = (std::filesystem::path(folder) / *file).lexically_normal().string();
  group.place = in.place();
}

void load_meshes(Case& scene) {
  for (Group& group : scene.groups) {
    Volume& volume = group.volume;
    if (volume.shape != Shape::mesh) continue;
    try {
      volume.mesh =
          std::make_shared<const SurfaceMesh>(SurfaceMesh::read_obj(volume.file, volume.unit));
    } catch (const Error& error) {
      throw Error(fmt::format("{}: volume.file: {}", group.place, error.what()));
    }
  }
}

}  // namespace spall
