// Reads a case: one line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/case.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>

#include "keys/section.hpp"
#include "keys/toml_text.hpp"
#include "scene/consistency.hpp"
#include "scene/debris.hpp"
#include "scene/engines.hpp"
#include "scene/materials.hpp"
#include "scene/read_group.hpp"
#include "scene/read_motion.hpp"
#include "scene/read_shapes.hpp"
#include "scene/read_walls.hpp"
#include "scene/resolved_case.hpp"
#include "scene/shape.hpp"
#include "scene/shields.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using namespace dimension;  // length, mass, time, speed ...: the units of the keys

constexpr Choice<Cut> cuts[] = {{"bisection", Cut::bisection}, {"metis", Cut::metis}};
constexpr Choice<GravityMethod> gravity_methods[] = {{"none", GravityMethod::none},
                                                     {"direct", GravityMethod::direct},
                                                     {"tree", GravityMethod::tree},
                                                     {"auto", GravityMethod::automatic}};
constexpr Choice<CohesionLaw> cohesion_laws[] = {{"force", CohesionLaw::force},
                                                 {"impulse", CohesionLaw::impulse}};
constexpr Choice<Aiming> aims[] = {{"head-on", Aiming::head_on}, {"line", Aiming::line}};
constexpr Choice<PhaseEnd> ends[] = {{"time", PhaseEnd::time}, {"settled", PhaseEnd::settled}};

void read_contact(Section& in, Case& scene) {
  in.take("material", "cohesion, cohesion_range and friction follow from its strengths",
          scene.contact_of);
  if (in.has("material")) scene.contact_of_place = in.place("material");
  scene.tells_cohesion = in.has("cohesion");
  scene.tells_range = in.has("cohesion_range");
  scene.tells_friction = in.has("friction");
  ContactLaw law;
  in.take("friction", "Coulomb's coefficient", law.friction, not_negative(number));
  in.take("restitution", "of normal speeds", law.restitution, fraction);
  in.take("cohesion", "attraction of every pair closer than cohesion_range", law.cohesion,
          not_negative(force));
  in.take("cohesion_range", "gap up to which cohesion acts", law.cohesion_range,
          not_negative(length));
  in.check("cohesion", law.cohesion == 0 || law.cohesion_range > 0 || !scene.contact_of.empty(),
           "needs a cohesion_range: the gap up to which it acts");
  in.take("cohesion_law", "impulse: cohesion is N s a step, as the reference engine reads it",
          law.cohesion_law, cohesion_laws);
  scene.contact = law;
  scene.contact_between =
      read_between<ContactLaw>(in, [](Section& s, Between<ContactLaw>& between) {
        between.take(s, "friction", &ContactLaw::friction, not_negative(number));
        between.take(s, "restitution", &ContactLaw::restitution, fraction);
        between.take(s, "cohesion", &ContactLaw::cohesion, not_negative(force));
        between.take(s, "cohesion_range", &ContactLaw::cohesion_range, positive(length));
      });
}

void read_impactor(Section& in, Impactor& impactor) {
  in.need("mass", "its material is [materials.impactor], or one of its density", impactor.mass,
          positive(mass));
  in.radius("", impactor.radius);
  in.need("speed", "relative to the target's centre of mass", impactor.speed, positive(speed));
  in.take("direction", "of flight", impactor.direction, any(number));
  in.take("distance", "flown before the first contact", impactor.distance, not_negative(length));
  in.take("offset", "of the line of flight from the target's centre of mass", impactor.offset,
          any(length));
  in.take("aim", "head-on: the line is shifted through the centre of the first sphere it meets",
          impactor.aim, aims);
  PointSource coupling;
  if (in.table("coupling", "its flow is handed to the bodies; left out: it hits as a rigid body",
               [&](Section& s) { read_point_source(s, coupling); }))
    impactor.coupling = coupling;
  in.check("direction", !impactor.direction.isZero(0), "is zero");
  impactor.direction.normalize();
  impactor.place = in.place();
}

/// The engine of a phase by the name that `method` gives.
void read_engine(Section& in, Phase& phase) {
  const auto engines = all_engines();
  std::vector<std::string_view> names;
  std::string help;
  for (const EngineType* type : engines) {
    names.push_back(type->name);
    help += fmt::format("{}{}: {}", help.empty() ? "" : "; ", type->name, type->help);
  }
  std::size_t chosen = 0;
  in.take("method", help, chosen, names);
  phase.engine = engines[chosen];
}

void read_phase(Section& in, Phase& phase, const EngineSettings& engines) {
  in.need("name", "of files after_NAME.h5, too", phase.name);
  constexpr std::size_t longest_name = 100;
  in.check("name",
           !phase.name.empty() && phase.name.size() <= longest_name && phase.name[0] != '.' &&
               std::ranges::none_of(phase.name, [](char c) { return c == '/' || std::iscntrl(c); }),
           fmt::format("cannot be part of a file's name: no / or sign without a picture, no dot "
                       "at its beginning, and {} signs at most are wanted",
                       longest_name));
  phase.place = in.place();
  read_engine(in, phase);
  in.need("step", "", phase.step, positive(time));
  in.need("duration", "with until = \"settled\" the longest", phase.duration, positive(time));
  in.check("step", phase.step <= phase.duration, "is longer than the duration");
  constexpr double most_steps = 1e15;  // that a double counts exactly, and a time tells apart
  in.check("step", phase.duration <= most_steps * phase.step,
           fmt::format("= {} s makes {:.3g} steps of the duration; {} can be counted", phase.step,
                       phase.duration / phase.step, most_steps));
  in.take("until", "", phase.until, ends);
  if (in.reads(phase.until == PhaseEnd::settled))
    in.need("settled_speed",
            "rms speed: the phase ends at the first row of the series below it, after one above; a "
            "few bodies that are at the top of a bounce at once end it, too",
            phase.settled_speed, positive(speed));
  in.take("cohesion", "from the start of this phase on; [[contact.between]] keeps its own",
          phase.cohesion, not_negative(force));
  in.take("remove_drift", "at the start: centre of mass to rest at the origin", phase.remove_drift);
  Impactor impactor;
  if (in.table("impactor", "added at the start of the phase",
               [&](Section& s) { read_impactor(s, impactor); }))
    phase.impactor = impactor;
  phase.settings = engines;
  for (const EngineType* type : all_engines())
    if (in.reads(type == phase.engine)) type->read_phase(in, phase.settings);
}

std::optional<Grid> read_gravity_map(Section& in) {
  Vec3 center = Vec3::Zero(), size = Vec3::Zero();
  double spacing = 0;
  const auto read = [&](Section& s) {
    s.take("center", "of the box of points", center, any(length));
    s.need("size", "full widths of the box; 0 for a plane, a line", size, not_negative(length));
    s.need("spacing", "of the points", spacing, positive(length));
    s.check("spacing", size.maxCoeff() <= 1e5 * spacing, "is less than a 1e5th of size");
  };
  if (!in.table("map", "the field of the bodies' gravity on a grid of points, in each snapshot",
                read))
    return {};
  if (spacing == 0) return {};  // while the reference is written
  const Grid grid = Grid::in_box(center, size, spacing);
  constexpr double most_points = 1e9;  // 32 GB a snapshot
  in.check(
      "map", static_cast<double>(grid.total()) <= most_points,
      fmt::format("has {:.3g} points; at most {} are written", double(grid.total()), most_points));
  return grid;
}

void read_case_keys(Section& in, Case& scene) {
  const std::string folder = std::filesystem::path(scene.file).parent_path().string();
  std::int64_t seed = 1;
  in.take("title", "what is simulated", scene.title);
  in.take("reference", "file with values of a source, for the report; beside the case",
          scene.reference);
  if (in.has("reference")) {
    scene.reference = (std::filesystem::path(folder) / scene.reference).string();
    scene.reference_place = in.place("reference");
  }
  in.take("seed", "of random packings, of how crystals lie and of flaws in brittle solids", seed,
          0);
  scene.seed = static_cast<std::uint64_t>(seed);
  in.take("allowed_overlap", "of two bodies at the start, in units of the smaller radius",
          scene.allowed_overlap, Quantity{number, 0, 1});
  in.named_tables("materials", "[materials.NAME]", [&](Section& s, const std::string& name) {
    Material& material = scene.materials.emplace_back();
    material.name = name;
    read_material(s, material);
  });
  in.named_tables("shapes", "[shapes.NAME]", [&](Section& s, const std::string& name) {
    ListedShape& shape = scene.listed_shapes.emplace_back();
    shape.name = name;
    read_shape(s, shape);
    s.check(
        "", name != "sphere" && name.find('/') == std::string::npos && name[0] != '.',
        "cannot be the name of a shape: neither sphere, nor with a dot at its beginning or a /");
  });
  in.table("contact", "where two bodies meet", [&](Section& s) { read_contact(s, scene); });
  for (const EngineType* type : all_engines()) type->read(in, scene.engines);
  in.tables("groups", "[[groups]]: recipes of bodies", [&](Section& s) {
    read_group(s, scene.groups.emplace_back(), scene.materials, folder);
  });
  read_walls(in, scene);
  in.table("gravity", "of bodies on each other, and uniform", [&](Section& s) {
    s.take("method", "of self-gravity", scene.gravity.method, gravity_methods);
    s.take("accuracy", "rms relative force error of tree", scene.gravity.accuracy,
           positive(number));
    s.take("refresh", "change of force, relative, up to which the field is held",
           scene.gravity.refresh, not_negative(number));
    s.take("near_clumps",
           "sums of their radii, up to which clumps attract by their parts; 0: by centres alone",
           scene.gravity.near_clumps, not_negative(number));
    s.check("near_clumps", scene.gravity.near_clumps == 0 || scene.gravity.near_clumps >= 1,
            "must be 0, or 1 and more");
    s.take("constant", "of gravity", scene.gravity.constant, positive(gravitational_constant));
    s.take("uniform", "field beside self-gravity", scene.uniform_gravity, any(acceleration));
    scene.gravity_map = read_gravity_map(s);
    s.check("map", !scene.gravity_map || scene.gravity.method != GravityMethod::none,
            "needs a method of self-gravity");
  });
  in.table("domain", "how bodies are shared out to the ranks", [&](Section& s) {
    s.take("cut", "by planes that halve space again and again, or by METIS's graph of coarse cells",
           scene.cut, cuts);
  });
  in.tables("phases", "[[phases]]: in the order in which they run",
            [&](Section& s) { read_phase(s, scene.phases.emplace_back(), scene.engines); });
  in.table("output", "snapshots, time series and restarts", [&](Section& s) {
    s.take("snapshot_every", "simulated; 0: at the ends of phases only",
           scene.output.snapshot_every, not_negative(time));
    s.take("series_every",
           "simulated; 0: every step; left out: every step where impulses are solved for, else "
           "each hundredth. Under self-gravity steps that are solved for have a row at each "
           "evaluation of it",
           scene.output.series_every, not_negative(time));
    s.take("restart_every", "of wall time", scene.output.restart_every, positive(time));
  });
  Binary binary;
  if (in.table("orbit", "of the target about its primary, whose change is asked for",
               [&](Section& s) {
                 s.need("separation", "R", binary.separation, positive(length));
                 s.need("speed", "v_old along the impactor's flight, negative against it",
                        binary.speed, any(speed));
                 s.need("parameter", "mu", binary.parameter, positive(gravitational_parameter));
                 s.need("period", "T_old, as the others give it", binary.period, positive(time));
                 binary.place = s.place();
               }))
    scene.binary = binary;
  DebrisSettings debris;
  if (in.table("debris", "of a projectile behind a plate: what is measured",
               [&](Section& s) { read_debris(s, debris); }))
    scene.debris = debris;
  in.tables("shields", "[[shields]]: walls that are judged in the end",
            [&](Section& s) { read_shield(s, scene.shields.emplace_back()); });
  in.take("read_out", "after the impact: when dv is tabulated", scene.read_out, positive(time));
  scene.read_out_place = in.place("read_out");
}

/// What single keys cannot tell: names told twice, and parts that need each other.
void check_whole(const Case& scene, Groups groups) {
  const auto twice = [&](std::string_view what, const auto& things) {
    for (auto a = things.begin(); a != things.end(); ++a)
      for (auto b = things.begin(); b != a; ++b)
        require(a->name != b->name, "{}: two {} are named \"{}\"", a->place, what, a->name);
  };
  twice("groups", scene.groups);
  twice("phases", scene.phases);
  for (const Phase& phase : scene.phases)
    for (const Phase& other : scene.phases)
      require(phase.name != other.name + "_before",
              "{}: phases.{}: after_{}.h5 is the file before that of phases.{}; another name is "
              "wanted",
              phase.place, phase.name, phase.name, other.name);
  require(groups == Groups::may_lack || !scene.groups.empty(),
          "{}: no bodies: it has no [[groups]]", scene.file);
  require(!scene.phases.empty(), "{}: nothing to run: it has no [[phases]]", scene.file);
  const auto first = std::ranges::find_if(scene.phases, &Phase::has_impactor);
  if (first != scene.phases.end())
    for (auto phase = first + 1; phase != scene.phases.end(); ++phase)
      require(!phase->has_impactor(), "{}: phases.{} has an impactor, too; there can be one",
              phase->impactor->place, first->name);
  std::vector<MaterialUse> uses = material_uses(scene);
  bool struck = false;
  for (const Phase& phase : scene.phases) {
    if (const auto& impactor = phase.impactor) {
      struck = true;
      uses.push_back({.place = impactor->place,
                      .group = "impactor",
                      .material = impactor->material,
                      .diameter = 2 * impactor->radius,
                      .lone = true});
    }
    phase.engine->check(
        scene, uses, phase.settings,
        {.place = phase.place, .impactor = struck, .cohesion = phase.cohesion.has_value()});
    require(scene.read_out.empty() || phase.engine->deflects,
            "{}.method = \"{}\": read_out is for phases of method = \"nonsmooth\" only",
            phase.place, phase.engine->name);
  }
  for (const Phase& phase : scene.phases)
    require(phase.cohesion.value_or(0) == 0 || scene.contact.common().cohesion_range > 0,
            "{}.cohesion needs contact.cohesion_range: the gap up to which it acts", phase.place);
  check_consistency(scene, groups);
}

/// The impactor's material is the case's of this name; else one of its density is added.
void find_material_of(Impactor& impactor, std::vector<Material>& materials) {
  const std::string name = "impactor";
  const double density = impactor.mass / ball_volume(impactor.radius);
  auto found = std::ranges::find(materials, name, &Material::name);
  if (found == materials.end()) found = materials.insert(found, Material{name, density});
  constexpr double told_apart = 1e-3;
  require(std::abs(found->density - density) <= told_apart * density,
          "{}: its mass and radius give {:.6g} kg/m^3, materials.impactor.density is {:.6g} kg/m^3",
          impactor.place, density, found->density);
  impactor.material = static_cast<int>(found - materials.begin());
}

/// The element of an array of tables that has this place or name; null without one.
toml::table* find_element(toml::array& array, std::string_view wanted) {
  std::size_t place = 0;
  for (toml::node& node : array) {
    toml::table* element = node.as_table();
    if (element &&
        (std::to_string(place) == wanted || (*element)["name"].value<std::string>() == wanted))
      return element;
    ++place;
  }
  return nullptr;
}

/// Moves what `from` holds into `into`, of which `option` changes single keys.
void merge(toml::table& from, toml::table& into, const std::string& option) {
  for (auto&& [key, node] : from) {
    toml::node* present = into.get(key);
    if (toml::table* below = node.as_table(); below && present && present->is_table()) {
      merge(*below, *present->as_table(), option);
    } else if (below && present && present->is_array()) {
      for (auto&& [name, change] : *below) {
        toml::table* element = find_element(*present->as_array(), name.str());
        require(element && change.is_table(), "{}: {} has no element {} to change the keys of",
                option, key.str(), name.str());
        merge(*change.as_table(), *element, option);
      }
    } else {
      node.visit([&, &at = key](auto& value) { into.insert_or_assign(at, std::move(value)); });
    }
  }
}

/// Tables and keys of methods that the case does not have: whoever wrote them may believe that they
/// act.
std::vector<std::string> unused_parts(const toml::table& root, const Case& scene) {
  std::map<std::string_view, std::vector<std::string>> methods;  // that read a table of this name
  for (const EngineType* type : all_engines())
    for (const std::string_view table : type->tables)
      methods[table].push_back(fmt::format("\"{}\"", type->name));
  for (const Phase& phase : scene.phases)
    for (const std::string_view table : phase.engine->tables) methods.erase(table);
  std::vector<std::string> unused;
  for (const auto& [table, names] : methods)
    if (root.contains(table))
      unused.push_back(fmt::format("[{}] is not used: no phase has method = {}", table,
                                   fmt::join(names, " or ")));
  // Who asks for no friction and no restitution asks for no material of a wall, but for its law
  // between pairs.
  if (methods.contains("contact") && methods.contains("pair_potential"))
    for (const char* walls : {"planes", "boxes", "cylinders"})
      if (const toml::array* all = root[walls].as_array())
        for (const toml::node& wall : *all)
          if (wall.is_table() && wall.as_table()->contains("material"))
            unused.push_back(fmt::format("material of [[{}]] is not used: no phase has method = {}",
                                         walls, fmt::join(methods.at("contact"), " or ")));
  for (const ListedShape& shape : scene.listed_shapes)
    if (std::ranges::none_of(scene.groups, [&](const Group& group) {
          const auto& names = group.packing.shape_names;
          return std::ranges::find(names, shape.name) != names.end();
        }))
      unused.push_back(
          fmt::format("[shapes.{}] is not used: no packing of a group names it", shape.name));
  for (const char* key : {"accuracy", "constant", "near_clumps", "refresh"})
    if (root["gravity"][key] && scene.gravity.method == GravityMethod::none)
      unused.push_back(fmt::format("gravity.{} is not used: no gravity.method is named", key));
  if (root["gravity"]["accuracy"] && scene.gravity.method == GravityMethod::direct)
    unused.push_back("gravity.accuracy is not used: gravity.method = \"direct\" is exact");
  if (root["gravity"]["refresh"] && scene.gravity.method != GravityMethod::none &&
      !scene.uniform_gravity.isZero(0))
    unused.push_back(
        "gravity.refresh is not used: beside gravity.uniform each step evaluates the field");
  if (root["gravity"]["near_clumps"] && scene.shapes.empty())
    unused.push_back("gravity.near_clumps is not used: no group has a shape");
  const bool coheres =
      has_cohesion(scene.contact) ||
      std::ranges::any_of(scene.phases, [](const Phase& phase) { return phase.cohesion > 0; });
  for (const char* key : {"cohesion_range", "cohesion_law"})
    if (root["contact"][key] && !methods.contains("contact") && !coheres)
      unused.push_back(fmt::format("contact.{} is not used: nothing coheres", key));
  for (const char* key : {"tangential_ratio", "tangential_damping"})
    if (root["penalty"][key] && !methods.contains("penalty") && !has_friction(scene.contact))
      unused.push_back(fmt::format("penalty.{} is not used: nothing has friction", key));
  for (std::size_t k = 0; k < scene.phases.size(); ++k)
    for (const char* key : {"n2", "p"})
      if (root["phases"][k]["impactor"]["coupling"][key] &&
          !scene.phases[k].impactor->coupling->crater_radius)
        unused.push_back(
            fmt::format("phases.{}.impactor.coupling.{} is not used: without crater_radius no rim "
                        "ends the flow",
                        scene.phases[k].name, key));
  return unused;
}

/// Of a case file, as its own reader asks for them.
const Section::Reference& all_keys() {
  static const Section::Reference keys = Section::reference([](Section& in) {
    Case scene;
    read_case_keys(in, scene);
  });
  return keys;
}

}  // namespace

Case parse_case(const std::string& text, const std::string& file,
                const std::vector<std::string>& overrides, Groups groups, const InputFiles& files,
                const std::vector<std::string>& constants) {
  toml::table root;
  try {
    root = parse_toml(text, file);
  } catch (const toml::parse_error& error) {
    throw Error(fmt::format("{}:{}:{}: {}", file, error.source().begin.line,
                            error.source().begin.column, error.description()));
  }
  // Overrides change a material's constants, but not the shapes that a file gave bodies, though one
  // of them named it.
  std::vector<std::string> changes = constants;
  const auto shapes = std::stable_partition(
      changes.begin(), changes.end(),
      [](const std::string& change) { return !change.starts_with("shapes."); });
  changes.insert(shapes, overrides.begin(), overrides.end());
  for (const std::string& change : changes) {
    toml::table from = parse_override(change);
    merge(from, root, "--set " + change);
  }
  Case scene;
  scene.file = file;
  scene.text = text;
  scene.overrides = overrides;
  scene.constants = constants;
  insert_named_constants(root, file, scene.constants, files);
  insert_filled_shapes(root, file, scene.constants, files);
  Section::read_all(
      root, file, [&](Section& in) { read_case_keys(in, scene); }, all_keys());
  draw_orientations(scene);
  gather_shapes(scene);
  const auto hit = std::ranges::find_if(scene.phases, &Phase::has_impactor);
  if (hit != scene.phases.end()) find_material_of(*hit->impactor, scene.materials);
  const std::vector<MaterialUse> uses = material_uses(scene);
  derive_contact_law(scene, uses);
  scene.unused = unused_parts(root, scene);
  for (const EngineType* type : all_engines()) type->derive(scene, uses, scene.engines);
  for (Phase& phase : scene.phases) phase.engine->derive(scene, uses, phase.settings);
  // These ask how wide groups are, also of a run that goes on, which else reads no meshes.
  if (scene.debris || !scene.shields.empty()) load_meshes(scene, files);
  find_debris_groups(scene);
  gather_motions(scene);
  check_whole(scene, groups);
  find_shield_walls(scene);
  scene.resolved = resolved_text(std::move(root), scene);
  return scene;
}

void check_spheres(Case& scene) {
  if (scene.spheres.empty()) return;
  const std::vector<MaterialUse> uses = material_uses(scene);
  for (const EngineType* type : all_engines()) type->derive(scene, uses, scene.engines);
  for (Phase& phase : scene.phases) phase.engine->derive(scene, uses, phase.settings);
  check_whole(scene, Groups::may_lack);
}

Case read_case(const std::string& file, const std::vector<std::string>& overrides,
               const InputFiles& files) {
  Case scene = parse_case(files.text(file), file, overrides, Groups::needed, files);
  require(scene.reference_place.empty() || files.exists(scene.reference),
          "{}: there is no file '{}'", scene.reference_place, scene.reference);
  load_meshes(scene, files);
  return scene;
}

std::vector<std::string> find_cases(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
    const std::filesystem::path& path = entry.path();
    if (path.extension() != ".toml" || path.parent_path().filename() == "materials") continue;
    if (path.stem() == "case" || !std::filesystem::exists(path.parent_path() / "case.toml"))
      files.push_back(path.string());
  }
  std::ranges::sort(files);
  return files;
}

std::string case_reference() {
  return all_keys().text;
}

}  // namespace spall
