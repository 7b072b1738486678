// Reads a case: one line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/scene/case.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "debris.hpp"
#include "materials.hpp"
#include "penalty_keys.hpp"
#include "potential_keys.hpp"
#include "read_group.hpp"
#include "section.hpp"
#include "spall/base/require.hpp"
#include "spall/scene/shape.hpp"

namespace spall {
namespace {

using namespace dimension;  // length, mass, time, speed ...: the units of the keys

constexpr Choice<GravityMethod> gravity_methods[] = {{"none", GravityMethod::none},
                                                     {"direct", GravityMethod::direct},
                                                     {"tree", GravityMethod::tree},
                                                     {"auto", GravityMethod::automatic}};
constexpr Choice<bool> cohesion_laws[] = {{"force", false}, {"impulse", true}};
constexpr Choice<bool> aims[] = {{"head-on", true}, {"line", false}};
constexpr Choice<Method> methods[] = {{"nonsmooth", Method::nonsmooth},
                                      {"potential", Method::potential},
                                      {"penalty", Method::penalty}};
constexpr Choice<bool> ends[] = {{"time", false}, {"settled", true}};

void read_contact(Section& in, ContactLaw& law, std::optional<DerivedLaw>& derived) {
  read_derived_law(in, "cohesion, cohesion_range and friction follow from its strengths", derived);
  in.take("friction", "Coulomb's coefficient", law.friction, not_negative(number));
  in.take("restitution", "of normal speeds", law.restitution, fraction);
  in.take("cohesion", "attraction of every pair closer than cohesion_range", law.cohesion,
          not_negative(force));
  in.take("cohesion_range", "gap up to which cohesion acts", law.cohesion_range,
          not_negative(length));
  in.take("cohesion_law", "impulse: cohesion is N s a step, as the reference engine reads it",
          law.cohesion_is_impulse, cohesion_laws);
  in.check("cohesion", law.cohesion == 0 || law.cohesion_range > 0 || derived,
           "needs a cohesion_range: the gap up to which it acts");
}

void read_solver(Section& in, SolverSettings& settings) {
  in.take("method", "", settings.method, solver_methods);
  in.take("friction", "", settings.friction, friction_models);
  in.take("tolerance", "on the residual, relative to that without impulses", settings.tolerance,
          positive(number));
  std::int64_t max_iterations = settings.max_iterations;
  in.take("max_iterations", "a step", max_iterations, 1);
  settings.max_iterations = static_cast<int>(std::min<std::int64_t>(max_iterations, 1 << 30));
  in.take("prox", "eps of the proximal Coulomb problem; 0: none", settings.prox,
          not_negative(number));
  in.take("relaxation", "of sor", settings.relaxation, Quantity{number, 0, 2, false});
}

void read_impactor(Section& in, Impactor& impactor) {
  in.need("mass", "its material is named impactor", impactor.mass, positive(mass));
  in.radius("", impactor.radius);
  in.need("speed", "relative to the target's centre of mass", impactor.speed, positive(speed));
  in.take("direction", "of flight", impactor.direction, any(number));
  in.take("distance", "flown before the first contact", impactor.distance, not_negative(length));
  in.take("offset", "of the line of flight from the target's centre of mass", impactor.offset,
          any(length));
  in.take("aim", "head-on: the line is shifted through the centre of the first sphere it meets",
          impactor.head_on, aims);
  in.check("direction", !impactor.direction.isZero(0), "is zero");
  impactor.direction.normalize();
}

void read_phase(Section& in, Phase& phase, const SolverSettings& solver) {
  in.need("name", "", phase.name);
  in.take("method", "potential: bodies act by [pair_potential] alone; penalty: by [penalty]",
          phase.method, methods);
  in.need("step", "", phase.step, positive(time));
  in.need("duration", "with until = \"settled\" the longest", phase.duration, positive(time));
  in.check("step", phase.step <= phase.duration, "is longer than the duration");
  in.take("until", "", phase.until_settled, ends);
  if (in.reads(phase.until_settled))
    in.need("settled_speed", "rms speed below which bodies are settled", phase.settled_speed,
            positive(speed));
  in.take("cohesion", "from the start of this phase on", phase.cohesion, not_negative(force));
  in.take("remove_drift", "at the start: centre of mass to rest at the origin", phase.remove_drift);
  Impactor impactor;
  if (in.table("impactor", "added at the start of the phase",
               [&](Section& s) { read_impactor(s, impactor); }))
    phase.impactor = impactor;
  SolverSettings changed = solver;
  if (in.table("solver", "where it differs from [solver]",
               [&](Section& s) { read_solver(s, changed); }))
    phase.solver = changed;
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
  if (!in.table("map", "gravity's field on a grid of points, in each snapshot", read)) return {};
  return Grid::in_box(center, size, spacing);
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
  in.take("seed", "of random packings", seed, 0);
  scene.seed = static_cast<std::uint64_t>(seed);
  in.take("allowed_overlap", "of two bodies at the start, in units of the smaller radius",
          scene.allowed_overlap, not_negative(number));
  in.named_tables("materials", "[materials.NAME]", [&](Section& s, const std::string& name) {
    Material& material = scene.materials.emplace_back();
    material.name = name;
    read_material(s, material);
  });
  in.table("contact", "where two bodies meet",
           [&](Section& s) { read_contact(s, scene.contact, scene.contact_of); });
  PairPotential potential;
  if (in.table("pair_potential", "between bodies, in phases with method = \"potential\"",
               [&](Section& s) { read_pair_potential(s, potential, scene.potential_of); }))
    scene.potential = potential;
  PenaltySettings penalty;
  if (in.table("penalty",
               "springs and dashpots between bodies, in phases with method = \"penalty\"",
               [&](Section& s) { read_penalty(s, penalty); }))
    scene.penalty = penalty;
  in.tables("groups", "[[groups]]: recipes of bodies", [&](Section& s) {
    read_group(s, scene.groups.emplace_back(), scene.materials, folder);
  });
  in.tables("planes", "[[planes]]: half-spaces that never move", [&](Section& s) {
    Plane& plane = scene.planes.emplace_back();
    s.take("point", "on the surface", plane.point, any(length));
    s.take("normal", "to the free side", plane.normal, any(number));
    s.check("normal", !plane.normal.isZero(0), "is zero");
    plane.normal.normalize();
  });
  read_walls(in, scene);
  in.table("gravity", "of bodies on each other, and uniform", [&](Section& s) {
    s.take("method", "of self-gravity", scene.gravity.method, gravity_methods);
    s.take("accuracy", "rms relative force error of tree", scene.gravity.accuracy,
           positive(number));
    s.take("refresh", "change of force, relative, up to which the field is held",
           scene.gravity.refresh, not_negative(number));
    s.take("constant", "of gravity", scene.gravity.constant, positive(gravitational_constant));
    s.take("uniform", "field beside self-gravity", scene.uniform_gravity, any(acceleration));
    scene.gravity_map = read_gravity_map(s);
    s.check("map", !scene.gravity_map || scene.gravity.method != GravityMethod::none,
            "needs a method of self-gravity");
  });
  in.table("solver", "of contact impulses", [&](Section& s) { read_solver(s, scene.solver); });
  in.tables("phases", "[[phases]]: in the order in which they run",
            [&](Section& s) { read_phase(s, scene.phases.emplace_back(), scene.solver); });
  in.table("output", "snapshots, time series and restarts", [&](Section& s) {
    s.take("snapshot_every", "simulated; 0: at the ends of phases only",
           scene.output.snapshot_every, not_negative(time));
    s.take("series_every", "simulated; 0: every step", scene.output.series_every,
           not_negative(time));
    s.take("restart_every", "of wall time", scene.output.restart_every, positive(time));
  });
  Binary binary;
  if (in.table("orbit", "of the target about its primary, whose change is asked for",
               [&](Section& s) {
                 s.need("separation", "R", binary.separation, positive(length));
                 s.need("speed", "v_old along the impactor's flight, negative against it",
                        binary.speed, any(speed));
                 s.need("parameter", "mu", binary.parameter, positive(gravitational_parameter));
                 s.need("period", "T_old", binary.period, positive(time));
               }))
    scene.binary = binary;
  DebrisSettings debris;
  if (in.table("debris", "of a projectile behind a plate: what is measured",
               [&](Section& s) { read_debris(s, debris); }))
    scene.debris = debris;
  in.take("read_out", "after the impact: when dv is tabulated", scene.read_out, positive(time));
}

/// What single keys cannot tell: names told twice, and parts that need each other.
void check_whole(const Case& scene) {
  const auto twice = [&](std::string_view what, const auto& things) {
    for (auto a = things.begin(); a != things.end(); ++a)
      for (auto b = things.begin(); b != a; ++b)
        require(a->name != b->name, "{}: two {} are named \"{}\"", scene.file, what, a->name);
  };
  twice("groups", scene.groups);
  twice("phases", scene.phases);
  require(!scene.groups.empty(), "{}: no bodies: it has no [[groups]]", scene.file);
  require(!scene.phases.empty(), "{}: nothing to run: it has no [[phases]]", scene.file);
  const auto has_impactor = [](const Phase& phase) { return phase.impactor.has_value(); };
  require(std::ranges::count_if(scene.phases, has_impactor) <= 1,
          "{}: two phases have an impactor; there can be one", scene.file);
  require(scene.read_out.empty() || std::ranges::any_of(scene.phases, has_impactor),
          "{}: read_out tells times after the impact, but no phase has an impactor", scene.file);
  for (const Phase& phase : scene.phases) {
    if (phase.method == Method::penalty) check_penalty(scene, phase);
    require(phase.method == Method::penalty || (scene.cylinders.empty() && !scene.period.any()),
            "{}: [[cylinders]] and [periodic] act in phases of method = \"penalty\" only, not in "
            "phases.{}",
            scene.file, phase.name);
    if (phase.method == Method::potential) check_potential(scene, phase);
  }
  for (const Phase& phase : scene.phases)
    require(phase.cohesion.value_or(0) == 0 || scene.contact.cohesion_range > 0,
            "{}: phases.{}.cohesion needs contact.cohesion_range: the gap up to which it acts",
            scene.file, phase.name);
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

/// An override is a line of TOML, "step=1e-4"; a text may come without quotes, "duration=10 s".
toml::table parse_override(const std::string& text) {
  const std::string option = "--set " + text;
  const std::size_t equals = text.find('=');
  require(equals != text.npos && equals > 0, "{}: key.path=value is wanted", option);
  try {
    return toml::parse(text, option);
  } catch (const toml::parse_error&) {
    try {
      return toml::parse(fmt::format("{}='{}'", text.substr(0, equals), text.substr(equals + 1)),
                         option);
    } catch (const toml::parse_error& error) {
      throw Error(fmt::format("{}: {}", option, error.description()));
    }
  }
}

}  // namespace

Case parse_case(const std::string& text, const std::string& file,
                const std::vector<std::string>& overrides) {
  toml::table root;
  try {
    root = toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    throw Error(fmt::format("{}:{}:{}: {}", file, error.source().begin.line,
                            error.source().begin.column, error.description()));
  }
  for (const std::string& change : overrides) {
    toml::table from = parse_override(change);
    merge(from, root, "--set " + change);
  }
  Case scene;
  scene.file = file;
  scene.text = text;
  scene.overrides = overrides;
  insert_material_files(root, file, scene.overrides);
  Section::read_all(root, file, [&](Section& in) { read_case_keys(in, scene); });
  draw_orientations(scene);
  derive_laws(scene);
  find_debris_groups(scene);
  check_whole(scene);
  for (Phase& phase : scene.phases)
    if (phase.impactor) {
      phase.impactor->material = static_cast<int>(scene.materials.size());
      scene.materials.push_back(
          {"impactor", phase.impactor->mass / ball_volume(phase.impactor->radius)});
    }
  return scene;
}

Case read_case(const std::string& file, const std::vector<std::string>& overrides) {
  std::ifstream in(file);
  require(in.good(), "{}: cannot be opened: {}", file, std::strerror(errno));
  require(!std::filesystem::is_directory(file), "{}: is a folder; a case file is wanted", file);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  Case scene = parse_case(text, file, overrides);
  require(scene.reference_place.empty() || std::filesystem::is_regular_file(scene.reference),
          "{}: there is no file '{}'", scene.reference_place, scene.reference);
  load_meshes(scene);
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
  return Section::reference([](Section& in) {
    Case scene;
    read_case_keys(in, scene);
  });
}

}  // namespace spall
