// Solids from files or tables; the laws between their spheres.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/materials.hpp"

#include <algorithm>
#include <filesystem>
#include <map>
#include <sstream>
#include <string>
#include <utility>

#include "engine/between.hpp"
#include "keys/toml_text.hpp"
#include "scene/material_library.hpp"
#include "scene/packing.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using namespace dimension;

void read_solid(Section& in, Solid& solid) {
  std::string title;
  in.take("title", "what it is", title);
  in.need("density", "of the solid; of one with pores, of its matter", solid.density,
          positive(density));
  in.take("sound_speed", "c0 of the shock speed c0 + s up", solid.sound_speed, positive(speed));
  in.take("hugoniot_slope", "s of it", solid.hugoniot_slope, positive(number));
  in.take("gruneisen", "Gruneisen's parameter", solid.gruneisen, positive(number));
  in.take("youngs_modulus", "of small strains", solid.youngs_modulus, positive(pressure));
  in.take("poisson_ratio", "", solid.poisson_ratio, Quantity{number, -1, 0.5, false});
  in.take("yield_strength",
          "where johnson_cook_a, steinberg_y0 and lundborg_cohesion are not given",
          solid.yield_strength, positive(pressure));
  in.take("tensile_strength", "at which pair potentials break; method solid takes spall_strength",
          solid.tensile_strength, positive(pressure));
  in.take("spall_strength", "at which a shock tears it", solid.spall_strength, positive(pressure));
  in.take("fracture_energy",
          "K_Ic^2 (1 - nu^2)/E of its toughness K_Ic: what parts an area of a metal",
          solid.fracture_energy, positive(spring_constant));
  in.take("specific_heat", "of heat: what softens and melts it, and what snapshots tell",
          solid.specific_heat, positive(specific_heat));
  in.take("melting_point", "at which Johnson and Cook's metal has no strength", solid.melting_point,
          positive(dimension::temperature));
  in.take("melt_energy", "from room temperature to liquid", solid.melt_energy,
          positive(specific_energy));
  in.take("sublimation_energy", "its enthalpy: debris with more heat is vapour",
          solid.sublimation_energy, positive(specific_energy));
  // The latent heat alone, which handbooks list, is less than what warms a solid to melting.
  const double warms = solid.specific_heat * (solid.melting_point - room_temperature);  // J/kg
  in.check("melt_energy", solid.melt_energy == 0 || solid.melt_energy >= warms,
           fmt::format("is less than the {:.3g} J/kg that warm it to its melting point; it counts "
                       "from room temperature to liquid, not the latent heat alone",
                       warms));
  in.check("sublimation_energy",
           solid.sublimation_energy == 0 || solid.melt_energy < solid.sublimation_energy,
           fmt::format("must be more than melt_energy = {:g} J/kg", solid.melt_energy));
  JohnsonCook& jc = solid.johnson_cook;
  in.take("johnson_cook_a", "A of its flow stress (A + B eps^n)(1 + C ln rate)(1 - T*^m)", jc.a,
          positive(pressure));
  in.take("johnson_cook_b", "", jc.b, not_negative(pressure));
  in.take("johnson_cook_n", "", jc.n, positive(number));
  in.take("johnson_cook_c", "", jc.c, not_negative(number));
  in.take("johnson_cook_m", "", jc.m, positive(number));
  for (std::size_t k = 0; k < jc.d.size(); ++k)
    in.take(fmt::format("johnson_cook_d{}", k + 1),
            k == 0 ? "D1 of the strain at which it fails, (D1 + D2 exp(D3 triaxiality)) "
                     "(1 + D4 ln rate)(1 + D5 T*)"
                   : "",
            jc.d[k], any(number));
  SteinbergGuinan& steinberg = solid.steinberg;
  in.take(
      "steinberg_y0",
      "Y0 of its flow stress Y0 (1 + beta eps)^n g and shear modulus G0 g, g = 1 + A P/eta^(1/3) "
      "- B (T - 298 K)",
      steinberg.y0, positive(pressure));
  in.take("steinberg_ymax", "the most of Y0 (1 + beta eps)^n", steinberg.ymax, positive(pressure));
  in.take("steinberg_beta", "", steinberg.beta, not_negative(number));
  in.take("steinberg_n", "", steinberg.n, not_negative(number));
  in.take("steinberg_a", "A of g", steinberg.a, not_negative(per_pressure));
  in.take("steinberg_b", "B of it", steinberg.b, not_negative(per_temperature));
  in.take("weibull_k",
          "k of the flaws of a brittle solid, k eps^m a volume at a tensile strain eps",
          solid.weibull.k, positive(number_density));
  in.take("weibull_m", "m of them", solid.weibull.m, positive(number));
  RockStrength& rock = solid.rock;
  in.take("lundborg_cohesion",
          "Y0 of the shear stress that intact rock bears at a pressure p, Y0 + mu p/(1 + mu p/(Ym "
          "- Y0)), as the root of J2",
          rock.cohesion, positive(pressure));
  in.take("lundborg_friction", "mu of it", rock.friction, positive(number));
  in.take("lundborg_limit", "Ym of it", rock.limit, positive(pressure));
  in.take("failed_friction",
          "of what has failed: the shear stress that it bears, of the pressure; without it, none",
          rock.failed_friction, positive(number));
  Pores& pores = solid.pores;
  in.take("distension",
          "alpha0 of a solid with pores: its volume over that of its matter; its other constants "
          "but for the elastic ones are those of the matter",
          pores.distension, Quantity{number, 1, infinity});
  in.take("elastic_pressure", "Pe, from which on pores are crushed", pores.elastic,
          positive(pressure));
  in.take("compaction_pressure", "Ps, at which no pores are left", pores.compacted,
          positive(pressure));
}

}  // namespace

void read_material(Section& in, Material& material) {
  std::string file, library;
  in.take("library", "a solid that Spall knows: `spall materials` lists them", library);
  in.take("file", "TOML file with the keys of solid, beside the case", file);
  Solid solid;
  if (in.table("solid", "constants of a solid; they come before those of library or file",
               [&](Section& s) { read_solid(s, solid); }))
    material.solid = solid;
  if (in.reads(!material.solid)) {
    in.need("density", "of one sphere; of a solid's lattice it follows from the solid's",
            material.density, positive(density));
    in.take("youngs_modulus", "of penalty contact: hertz", material.youngs_modulus,
            positive(pressure));
    in.take("poisson_ratio", "of penalty contact: hertz", material.poisson_ratio,
            Quantity{number, 0, 0.5});
  }
  if (material.solid) {
    material.density = solid.bulk_density();
    material.youngs_modulus = solid.youngs_modulus;
    material.poisson_ratio = solid.poisson_ratio;
  }
}

int find_material(const Section& in, const std::string& name,
                  const std::vector<Material>& materials) {
  const auto found = std::ranges::find(materials, name, &Material::name);
  in.check("material", found != materials.end() || !in.has("material"),
           fmt::format("= \"{}\" is not in [materials]", name));
  return found == materials.end() ? same_material : static_cast<int>(found - materials.begin());
}

namespace {

toml::table parse_constants(const std::string& text, const std::string& path) {
  try {
    return parse_toml(text, path);
  } catch (const toml::parse_error& error) {
    throw Error(fmt::format("{}:{}:{}: {}", path, error.source().begin.line,
                            error.source().begin.column, error.description()));
  }
}

/// NAME.solid={...}, as an option --set takes it.
std::string solid_override(const std::string& material, const toml::table& constants) {
  std::ostringstream line;
  line << material << ".solid={";
  const char* separator = "";
  for (auto&& [key, value] : constants) {
    line << separator << toml_string(key.str()) << " = ";
    value.visit([&](const auto& v) { line << v; });
    separator = ", ";
  }
  return line.str() + "}";
}

}  // namespace

void insert_named_constants(toml::table& root, const std::string& file,
                            std::vector<std::string>& kept, const InputFiles& files) {
  toml::table* materials = root["materials"].as_table();
  if (!materials) return;
  for (auto&& [name, node] : *materials) {
    toml::table* material = node.as_table();
    if (!material || (material->contains("solid") && !(*material)["solid"].is_table())) continue;
    // Both are texts; what is none is refused where the keys are read. Library "" is of a restart
    // file, which holds all constants.
    const auto library = (*material)["library"].value<std::string>();
    const auto named = (*material)["file"].value<std::string>();
    if (library == "" || (!library && !named)) continue;
    const char* key = library ? "library" : "file";
    std::string path, text;
    try {
      require(!library || !named, "a file is named too: one is wanted");
      require(library || !named->empty(), "its name is empty");
      path = library ? *library + ".toml"
                     : (std::filesystem::path(file).parent_path() / *named).string();
      text = library ? std::string(library_material(*library).text) : files.text(path);
    } catch (const Error& error) {
      throw Error(fmt::format("{}:{}: materials.{}.{}: {}", file,
                              (*material)[key].node()->source().begin.line, name.str(), key,
                              error.what()));
    }
    toml::table constants = parse_constants(text, path);
    if (const toml::table* own = (*material)["solid"].as_table())  // what the case says counts
      for (auto&& [constant, value] : *own)
        value.visit([&, &at = constant](const auto& v) { constants.insert_or_assign(at, v); });
    const std::string place = "materials." + toml_string(name.str());
    kept.push_back(solid_override(place, constants));
    kept.push_back(place + ".library=\"\"");
    material->insert_or_assign("solid", std::move(constants));
  }
}

void draw_orientations(Case& scene) {
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    Packing& packing = scene.groups[g].packing;
    if (packing.orientation == Orientation::random)
      packing.rotation = random_rotation(stream_of(scene, g));
  }
}

namespace {

void derive_cohesion(Case& scene, std::span<const MaterialUse> uses) {
  if (scene.contact_of.empty()) return;
  const auto found = std::ranges::find(scene.materials, scene.contact_of, &Material::name);
  require(found != scene.materials.end() && found->solid,
          "{} = \"{}\" is not a solid of [materials]: one with a library, a file or a table "
          "[materials.{}.solid]",
          scene.contact_of_place, scene.contact_of, scene.contact_of);
  const auto material = static_cast<int>(found - scene.materials.begin());
  const Lattice lattice = shared_lattice(scene, uses, material, scene.contact_of_place);
  const Cohesion cohesion = cohesion_of(*found->solid, lattice, scene.contact_of_place);
  // What the case says itself counts.
  ContactLaw law = scene.contact.common();
  if (!scene.tells_cohesion) law.cohesion = cohesion.force;
  if (!scene.tells_range) law.cohesion_range = cohesion.range;
  if (!scene.tells_friction) law.friction = cohesion.friction;
  scene.contact = law;
}

}  // namespace

void derive_contact_law(Case& scene, std::span<const MaterialUse> uses) {
  derive_cohesion(scene, uses);
  scene.contact =
      laws_between(scene.contact.common(), scene.materials, scene.contact_between,
                   [](ContactLaw& law, const Between<ContactLaw>& between) {
                     law.own_cohesion = between.changes_any(&ContactLaw::cohesion);
                     require(law.cohesion == 0 || law.cohesion_range > 0,
                             "{}: its cohesion needs a cohesion_range: the gap up to which it acts",
                             between.pair.place);
                   });
  scene.contact.for_each([&](const ContactLaw& law) {
    require(law.cohesion == 0 || law.cohesion_range > 0,
            "{} gives a cohesion of {:.4g} N, which needs a gap up to which it acts: "
            "contact.cohesion_range = 0 leaves it none; cohesion = 0 asks for none",
            scene.contact_of_place, law.cohesion);
  });
}

std::vector<MaterialUse> material_uses(const Case& scene) {
  std::vector<MaterialUse> uses;
  for (const Group& group : scene.groups)
    uses.push_back(
        {.place = group.place,
         .group = group.name,
         .material = group.material,
         .lattice = lattice_of(group.packing),
         .diameter = 2 * group.packing.radius,
         .lone = group.packing.type == &single_packing,
         .unequal = group.packing.type->unequal && group.packing.type->unequal(group.packing),
         .scaled = group.total_mass.has_value(),
         .fixed = group.held()});
  // There may be many: one use a material, as of a group, and one of those that are fixed.
  std::map<std::pair<std::string, bool>, std::size_t> of_spheres;
  for (const SceneSphere& sphere : scene.spheres) {
    const auto [at, is_new] = of_spheres.try_emplace({sphere.material, sphere.fixed}, uses.size());
    if (is_new)
      uses.push_back({.place = fmt::format("{}: sphere", scene.file),
                      .group = "spheres",
                      .material = find_material(scene.materials, sphere.material, scene.file),
                      .mass = sphere.mass,
                      .fixed = sphere.fixed});
    MaterialUse& use = uses[at->second];
    use.mass = std::min(use.mass, sphere.mass);
  }
  return uses;
}

}  // namespace spall
