// Bodies are made once, and phases begin once: their keys say nothing any more.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/changes.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "engine/prescribed.hpp"
#include "keys/toml_text.hpp"
#include "spall/error.hpp"
#include "state/walls.hpp"

namespace spall {
namespace {

using Keys = std::initializer_list<std::string_view>;

bool is_one_of(std::string_view key, Keys keys) {
  return std::ranges::find(keys, key) != keys.end();
}

/// An impactor's material weighs nothing before it is added. A restart file keeps the constants
/// that a library or a file gave, and asks neither again.
void check_materials(const RestartState& state, const toml::table& materials,
                     const std::string& option) {
  const bool struck = state.clock.since_impact >= 0;
  for (const auto& [name, node] : materials) {
    const toml::table* material = node.as_table();
    if (!material) continue;
    require(!material->contains("library") && !material->contains("file"),
            "{}: what goes on keeps the constants of its materials; "
            "materials.NAME.solid.CONSTANT=... changes one",
            option);
    if (name.str() == "impactor" && !struck) continue;
    const auto solid = (*material)["solid"];
    require(!material->contains("density") && !solid["density"] && !solid["distension"],
            "{}: bodies have their masses already, of the density and the pores before", option);
  }
}

void check_phases(const RestartState& state, const Case& before, const toml::node& phases,
                  const std::string& option) {
  const Clock& clock = state.clock;
  if (clock.step == 0) return;
  const toml::table* told = phases.as_table();
  require(told, "{}: a part of these phases is over; name one, as phases.NAME.step", option);
  for (std::int64_t p = 0; p < std::ssize(before.phases) && p <= clock.phase; ++p) {
    const std::string& name = before.phases[p].name;
    const toml::node* node = told->get(name);
    if (!node) node = told->get(std::to_string(p));
    if (!node) continue;
    require(p == clock.phase, "{}: phase {} is over", option, name);
    const toml::table* phase = node->as_table();
    if (!phase || clock.step_in_phase == 0) continue;
    for (const auto& [key, value] : *phase)
      require(!is_one_of(key.str(), {"name", "method", "cohesion", "remove_drift", "impactor"}),
              "{}: phase {} has begun; {} is asked for when it begins. A restart file of the end "
              "of the "
              "phase before, after_NAME.h5, can be told",
              option, name, key.str());
  }
}

/// Whether the state has this value of its key: what was told later of it counts.
bool is_in_force(const RestartState& state, const std::string& change) {
  const auto key_of = [](const std::string& text) { return text.substr(0, text.find('=')) + "."; };
  const std::string key = key_of(change);
  for (auto told = state.overrides.rbegin(); told != state.overrides.rend(); ++told) {
    if (*told == change) return true;
    if (key.starts_with(key_of(*told)) || key_of(*told).starts_with(key)) return false;
  }
  return false;
}

}  // namespace

void check_change(const RestartState& state, const Case& before, const std::string& change) {
  if (is_in_force(state, change)) return;
  const std::string option = "--set " + change;
  const toml::table told = parse_override(change);
  for (const auto& [key, node] : told) {
    require(
        !is_one_of(key.str(), {"groups", "shapes", "seed", "allowed_overlap"}),
        "{}: the bodies are made already, and keep what they are; --set changes what lies ahead",
        option);
    const toml::table* table = node.as_table();
    if (key.str() == "materials" && table) check_materials(state, *table, option);
    require(key.str() != "periodic", "{}: bodies and their images lie in the box so far", option);
    if (key.str() == "phases") check_phases(state, before, node, option);
    if (key.str() == "contact" && table)
      require(!table->contains("cohesion") && !table->contains("material"),
              "{}: cohesion is that of the phases so far; phases.NAME.cohesion of one that has not "
              "begun changes it",
              option);
  }
}

namespace {

/// m, how deep a sphere lies in the walls; 0 where it is clear of them.
double depth_in(const Walls& walls, const Vec3& center, double radius) {
  double deepest = 0;
  for (std::size_t w = 0; w < walls.size(); ++w)
    deepest = std::max(deepest, radius - face_of(walls, w, center).height);
  return deepest;
}

}  // namespace

void check_walls_ahead(const Comm& comm, const RestartState& state, const Case& before,
                       const Case& after) {
  const Bodies& bodies = state.bodies;
  const Walls former = before.walls(), walls = after.walls();
  bool same = former.size() == walls.size();
  for (std::size_t w = 0; same && w < walls.size(); ++w) same = walls.name(w) == former.name(w);
  require(same,
          "{}: --set adds or takes away walls, or names them otherwise; what bodies remember of "
          "them, and what they have received, would be that of others. Move those away that are in "
          "the way",
          state.case_file);
  std::array<double, 1> wrong{-1};  // id
  for (Index b = 0; b < bodies.owned; ++b) {
    if (is_held(bodies, b)) continue;
    const double radius = bodies.radius[b];
    const double deeper =
        depth_in(walls, bodies.position[b], radius) - depth_in(former, bodies.position[b], radius);
    if (deeper > after.allowed_overlap * radius) wrong[0] = static_cast<double>(bodies.id[b]);
  }
  comm.max(wrong);
  require(
      wrong[0] < 0,
      "{}: body {:.0f} lies in a wall where --set has moved it to; walls may be moved away from "
      "bodies",
      state.case_file, wrong[0]);
}

void follow_materials(const Case& before, const Case& after, Bodies& bodies) {
  for (auto& material : bodies.material) {
    const auto found =
        std::ranges::find(after.materials, before.materials[material].name, &Material::name);
    material = static_cast<std::int32_t>(found - after.materials.begin());
  }
}

void check_cohesion_ahead(const Case& before, const Case& after) {
  const double was = before.contact.common().cohesion, would = after.contact.common().cohesion;
  require(was == would,
          "{}: --set changes the cohesion that follows from materials.{}, {:.4g} N to {:.4g} N, "
          "which is that of the phases so far; phases.NAME.cohesion of one that has not begun "
          "changes it",
          after.file, after.contact_of, was, would);
}

void check_read_outs_ahead(const RestartState& state, const Case& before, const Case& after) {
  const Clock& clock = state.clock;
  if (clock.since_impact < 0) return;
  for (const double at : after.read_out)
    require(at > clock.since_impact || std::ranges::count(before.read_out, at) > 0,
            "{}: {:g} s is over: the run goes on {:g} s after the impactor was added",
            after.read_out_place, at, clock.since_impact);
}

}  // namespace spall
