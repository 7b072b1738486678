// A scene as a program holds it: a case, and spheres of its own.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "potential/settings.hpp"
#include "scene/case.hpp"
#include "scene/read_group.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"
#include "spall/scene.hpp"

namespace spall {

Scene Scene::from_file(const std::string& file, const std::vector<std::string>& overrides) {
  return Scene(std::make_shared<Case>(read_case(file, overrides)));
}

Scene Scene::from_text(const std::string& toml, const std::vector<std::string>& overrides) {
  const auto parts = std::make_shared<Case>(parse_case(toml, "scene", overrides, Groups::may_lack));
  load_meshes(*parts, {});
  return Scene(parts);
}

Scene& Scene::add(const SceneSphere& sphere) {
  const auto number = case_->spheres.size();
  const auto found = std::ranges::find(case_->materials, sphere.material, &Material::name);
  require(found != case_->materials.end(), "{}: sphere {}: material \"{}\" is not in [materials]",
          case_->file, number, sphere.material);
  require(sphere.radius > 0 && std::isfinite(sphere.radius), "{}: sphere {}: radius = {} m",
          case_->file, number, sphere.radius);
  require(sphere.mass >= 0 && std::isfinite(sphere.mass), "{}: sphere {}: mass = {} kg",
          case_->file, number, sphere.mass);
  require(sphere.position.allFinite() && sphere.velocity.allFinite() && sphere.spin.allFinite(),
          "{}: sphere {}: position, velocity and spin must be finite", case_->file, number);
  require(!sphere.fixed || (sphere.velocity.isZero(0) && sphere.spin.isZero(0)),
          "{}: sphere {}: it is fixed and has a velocity or a spin", case_->file, number);
  case_->resolved.clear();
  SceneSphere& added = case_->spheres.emplace_back(sphere);
  if (added.mass == 0) added.mass = found->density * ball_volume(added.radius);
  if (added.fixed) added.mass = infinity;
  return *this;
}

Scene& Scene::set_law_of_program(std::shared_ptr<const PairLawOfProgram> law) {
  bool asked = false;
  const auto set_in = [&](EngineSettings& settings) {
    auto* potential = settings.find<PotentialSettings>();
    if (!potential) return;
    const auto set = [&](PairPotential& p) {
      if (p.law != PairLaw::program) return;
      p.program = law;
      asked = true;
    };
    potential->law.for_each(set);
    set(potential->common);
    for (LawBetween& between : potential->between) set(between.law);
  };
  set_in(case_->engines);
  for (Phase& phase : case_->phases) set_in(phase.settings);
  require(asked, "{}: set_pair_law: no [pair_potential] has law = \"program\"", case_->file);
  return *this;
}

}  // namespace spall
