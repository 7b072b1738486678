// Solids from files or tables; the laws between their spheres.
// SPDX-License-Identifier: BSD-3-Clause
#include "materials.hpp"

#include <algorithm>
#include <filesystem>
#include <sstream>

#include "spall/base/require.hpp"
#include "spall/scene/packing.hpp"

namespace spall {
namespace {

using namespace dimension;

void read_solid(Section& in, Solid& solid) {
  std::string title;
  in.take("title", "what it is", title);
  in.need("density", "of the solid", solid.density, positive(density));
  in.take("sound_speed", "c0 of the shock speed c0 + s up", solid.sound_speed, positive(speed));
  in.take("hugoniot_slope", "s of it", solid.hugoniot_slope, positive(number));
  in.take("gruneisen", "Gruneisen's parameter", solid.gruneisen, positive(number));
  in.take("youngs_modulus", "", solid.youngs_modulus, positive(pressure));
  in.take("poisson_ratio", "", solid.poisson_ratio, Quantity{number, -1, 0.5});
  in.take("yield_strength", "", solid.yield_strength, positive(pressure));
  in.take("tensile_strength", "", solid.tensile_strength, positive(pressure));
  in.take("spall_strength", "at which a shock tears it", solid.spall_strength, positive(pressure));
  in.take("specific_heat", "from which snapshots tell the temperature", solid.specific_heat,
          positive(specific_heat));
  in.take("melting_point", "", solid.melting_point, positive(dimension::temperature));
  in.take("melt_energy", "from room temperature to liquid", solid.melt_energy,
          positive(specific_energy));
  in.take("sublimation_energy", "from solid to vapour", solid.sublimation_energy,
          positive(specific_energy));
}

/// The lattice that all groups of a material share.
Lattice lattice_of_material(const Case& scene, const DerivedLaw& law, const Solid*& solid) {
  const auto found = std::ranges::find(scene.materials, law.material, &Material::name);
  require(
      found != scene.materials.end() && found->solid,
      "{} = \"{}\" is not a solid of [materials]: one with a file or a table [materials.{}.solid]",
      law.place, law.material, law.material);
  solid = &*found->solid;
  const Group* first = nullptr;
  for (const Group& group : scene.groups) {
    const Lattice lattice = lattice_of(group.packing);
    if (&scene.materials[group.material] != &*found || lattice.neighbours == 0) continue;
    if (!first) first = &group;
    const Lattice other = lattice_of(first->packing);
    require(lattice.neighbours == other.neighbours && lattice.distance == other.distance,
            "{}: the lattice is not that of groups.{}, which is of the same material; a law that "
            "follows from the material needs one lattice",
            group.place, first->name);
  }
  require(first, "{} = \"{}\": no group of it is a lattice, from which the law follows", law.place,
          law.material);
  return lattice_of(first->packing);
}

}  // namespace

void read_material(Section& in, Material& material) {
  std::string file;
  in.take("file", "TOML file with the keys of solid, beside the case", file);
  Solid solid;
  if (in.table("solid", "constants of a solid; left out: from file",
               [&](Section& s) { read_solid(s, solid); }))
    material.solid = solid;
  if (in.reads(!material.solid))
    in.need("density", "of one sphere; of a solid's lattice it follows from the solid's",
            material.density, positive(density));
  if (material.solid) material.density = solid.density;
}

void read_derived_law(Section& in, std::string_view meaning, std::optional<DerivedLaw>& law) {
  std::string material;
  in.take("material", meaning, material);
  if (in.has("material")) law = {material, in.place("material")};
}

void insert_material_files(toml::table& root, const std::string& file,
                           std::vector<std::string>& overrides) {
  toml::table* materials = root["materials"].as_table();
  if (!materials) return;
  for (auto&& [name, node] : *materials) {
    toml::table* material = node.as_table();
    if (!material || material->contains("solid")) continue;
    const auto wanted = (*material)["file"].value<std::string>();
    if (!wanted) continue;
    const std::string path = (std::filesystem::path(file).parent_path() / *wanted).string();
    require(std::filesystem::is_regular_file(path),
            "{}:{}: materials.{}.file: there is no file '{}'", file,
            (*material)["file"].node()->source().begin.line, name.str(), path);
    try {
      material->insert_or_assign("solid", toml::parse_file(path));
    } catch (const toml::parse_error& error) {
      throw Error(fmt::format("{}:{}:{}: {}", path, error.source().begin.line,
                              error.source().begin.column, error.description()));
    }
    std::ostringstream line;
    line << "materials." << name.str() << ".solid={";
    bool first = true;
    for (auto&& [key, value] : *(*material)["solid"].as_table()) {
      line << (first ? "" : ", ") << key.str() << " = ";
      value.visit([&](const auto& v) { line << v; });
      first = false;
    }
    overrides.push_back(line.str() + "}");
  }
}

void draw_orientations(Case& scene) {
  std::uint64_t stream = scene.seed * 0x9E3779B97F4A7C15u;
  for (Group& group : scene.groups) {
    if (group.packing.random_orientation) group.packing.rotation = random_rotation(stream);
    ++stream;
  }
}

void derive_laws(Case& scene) {
  const Solid* solid = nullptr;
  if (scene.potential_of) {
    const Lattice lattice = lattice_of_material(scene, *scene.potential_of, solid);
    PairPotential& p = *scene.potential;
    PairPotential derived =
        morse_law(*solid, lattice, scene.potential_of->match, scene.potential_of->place);
    derived.damping = p.damping;
    if (p.breaking_strain > 0) {
      derived.breaking_strain = p.breaking_strain;
      derived.cutoff = (1 + 2 * p.breaking_strain) * derived.distance;
    }
    p = derived;
  }
  if (scene.contact_of) {
    const Lattice lattice = lattice_of_material(scene, *scene.contact_of, solid);
    const Cohesion cohesion = cohesion_of(*solid, lattice, scene.contact_of->place);
    // What the case says itself counts.
    ContactLaw& law = scene.contact;
    if (law.cohesion == 0) law.cohesion = cohesion.force;
    if (law.cohesion_range == 0) law.cohesion_range = cohesion.range;
    if (law.friction == 0) law.friction = cohesion.friction;
  }
}

}  // namespace spall
