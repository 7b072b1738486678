// One line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "engine/between.hpp"
#include "penalty/adhesions.hpp"
#include "penalty/engine.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using dimension::spring_constant;
constexpr Choice<PenaltyModel> models[] = {{"hertz", PenaltyModel::hertz},
                                           {"hooke", PenaltyModel::hooke}};
constexpr Choice<Adhesion> adhesions[] = {
#define SPALL_ADHESION(name, Law) {#name, Adhesion::name},
    SPALL_ADHESIONS(SPALL_ADHESION)
#undef SPALL_ADHESION
};

AdhesionKey key_of(Adhesion adhesion) {
  return with_adhesion(adhesion, []<template <class> class Law>() { return Law<double>::key; });
}

/// A key that tells how strong some laws of adhesion are.
struct Strength {
  AdhesionKey key;
  std::string meaning;  ///< with the names of its laws
  bool asked = false;   ///< by the law that is chosen
};
std::vector<Strength> strengths(Adhesion chosen) {
  std::vector<Strength> all;
  for (const auto& [name, adhesion] : adhesions) {
    const AdhesionKey key = key_of(adhesion);
    if (!key.name) continue;
    const auto same = [&](const Strength& s) { return std::string_view(s.key.name) == key.name; };
    const auto known = std::find_if(all.begin(), all.end(), same);
    Strength& strength = known == all.end() ? all.emplace_back() : *known;
    strength.key = key;
    strength.meaning += strength.meaning.empty() ? fmt::format("{}: {}", key.meaning, name)
                                                 : fmt::format(", {}", name);
    strength.asked |= adhesion == chosen;
  }
  return all;
}

/// What a case tells in [penalty].
struct PenaltyKeys {
  ByPair<PenaltySettings> laws;
  std::vector<Between<PenaltySettings>> between;
};

void read_penalty(Section& in, PenaltyKeys& keys) {
  PenaltySettings s;
  for (const char* moved : {"young_modulus", "poisson_ratio"})
    in.check(moved, !in.has(moved),
             "is the materials' now: write [materials.NAME] youngs_modulus, poisson_ratio");
  in.take("model", "hertz: Hertz and Mindlin, by the materials' youngs_modulus; hooke: linear",
          s.model, models);
  const bool hooke = s.model == PenaltyModel::hooke;
  if (in.reads(!hooke))
    in.take("adhesion", "beside contact.cohesion: hertz", s.adhesion, adhesions);
  const Quantity ratio{{}, 0, 1, false};
  const std::vector<Strength> adhesive = strengths(s.adhesion);
  for (const auto& [key, meaning, asked] : adhesive)
    if (in.reads(asked)) in.need(key.name, meaning, s.adhesion_strength, positive(key.dimension));
  if (in.reads(hooke)) {
    in.need("stiffness", "of a pair: hooke", s.stiffness, positive(spring_constant));
    in.take("tangential_ratio", "tangential stiffness over stiffness: hooke", s.tangential_ratio,
            ratio);
  }
  in.take(
      "tangential_damping",
      "dashpot along the contact over that across it; left out: sqrt of their stiffnesses' ratio",
      s.tangential_damping, Quantity{{}, 0, 1});
  in.take("rolling_friction", "largest rolling torque over R_eff and the normal force",
          s.rolling_friction, not_negative({}));
  keys.laws = s;
  keys.between = read_between<PenaltySettings>(in, [&](Section& one, auto& between) {
    for (const auto& [key, meaning, asked] : adhesive)
      if (one.reads(asked))
        between.take(one, key.name, &PenaltySettings::adhesion_strength, positive(key.dimension));
    if (one.reads(hooke)) {
      between.take(one, "stiffness", &PenaltySettings::stiffness, positive(spring_constant));
      between.take(one, "tangential_ratio", &PenaltySettings::tangential_ratio, ratio);
    }
    between.take(one, "rolling_friction", &PenaltySettings::rolling_friction, not_negative({}));
  });
}

void read(Section& in, EngineSettings& settings) {
  PenaltyKeys keys;
  if (in.table("penalty",
               "springs and dashpots between bodies, in phases with method = \"penalty\"",
               [&](Section& s) { read_penalty(s, keys); }))
    settings.set(keys);
}

void derive(const Surroundings& around, std::span<const MaterialUse>, EngineSettings& settings) {
  if (auto* keys = settings.find<PenaltyKeys>())
    keys->laws = laws_between(keys->laws.common(), around.materials, keys->between,
                              [](PenaltySettings&, const Between<PenaltySettings>&) {});
}

/// Throws Error where Hertz's law does not know the material.
void check_elastic(const Surroundings& around, int material, const std::string& place) {
  const Material& m = around.materials[material];
  const std::string table = fmt::format("materials.{}{}", m.name, m.solid ? ".solid" : "");
  require(m.youngs_modulus > 0, "{}: penalty.model = \"hertz\" needs {}.youngs_modulus", place,
          table);
  require(!m.solid || m.poisson_ratio != 0, "{}: penalty.model = \"hertz\" needs {}.poisson_ratio",
          place, table);
}

/// Throws Error where the contact of two materials that meet is none of springs and dashpots.
void check_pair(const Surroundings& around, const ByPair<PenaltySettings>& laws, int a, int b,
                const std::string& place) {
  const ContactLaw& contact = around.contact(a, b);
  const std::string of = around.contact.uniform() && laws.uniform()
                             ? ""
                             : " between " + pair_name(around.materials, a, b);
  require(contact.restitution > 0,
          "{}.method = \"penalty\" needs contact.restitution > 0{}: it sets the damping", place,
          of);
  require(laws(a, b).rolling_friction == 0 || contact.friction > 0,
          "{}: penalty.rolling_friction needs contact.friction > 0{}: bodies without it slide",
          place, of);
}

void check(const Surroundings& around, std::span<const MaterialUse> uses,
           const EngineSettings& settings, const PhaseView& phase) {
  const PenaltyKeys* penalty = settings.find<PenaltyKeys>();
  require(penalty,
          "{}.method = \"penalty\" needs [penalty]: its model, and stiffness or the materials' "
          "youngs_modulus",
          phase.place);
  const Walls walls = around.walls();
  const bool elastic = penalty->laws.common().model == PenaltyModel::hertz;
  for (const MaterialUse& use : uses)
    if (elastic) check_elastic(around, use.material, use.place);
  for (const MaterialUse& use : uses) {
    for (const MaterialUse& other : uses)
      check_pair(around, penalty->laws, use.material, other.material, phase.place);
    for (std::size_t w = 0; w < walls.size(); ++w) {
      if (walls.material(w) == same_material) continue;
      if (elastic) check_elastic(around, walls.material(w), phase.place + ": its walls");
      check_pair(around, penalty->laws, use.material, walls.material(w), phase.place);
    }
  }
  require(around.contact.common().cohesion_law == CohesionLaw::force,
          "{}.method = \"penalty\": contact.cohesion_law = \"impulse\" is for phases of method = "
          "\"nonsmooth\" only",
          phase.place);
  check_images(around, phase.place);
}

FieldSet fields(const Surroundings& around, const EngineSettings&) {
  FieldSet fields{Field::angular_velocity, Field::heat};
  if (!around.shapes.empty()) fields |= {Field::shape, Field::orientation};
  return fields;
}

/// The stiffness of each pair of materials that the law knows, where there are several.
std::string describe(const Surroundings& around, std::span<const MaterialUse>,
                     const EngineSettings& settings) {
  const ByPair<PenaltySettings> laws = settings.get<PenaltyKeys>().laws;
  const int count = static_cast<int>(around.materials.size());
  const bool hooke = laws.common().model == PenaltyModel::hooke;
  if (count == 1 || (hooke && laws.uniform())) return "";
  const AdhesionKey strength = key_of(laws.common().adhesion);
  const std::string adhesion =
      strength.name ? fmt::format("adhesion ({})", si_unit(strength.dimension)) : "adhesion";
  std::string text = fmt::format("\n  {:<24}{:>14}{:>18}{:>10}{:>18}\n", "springs between",
                                 hooke ? "k (N/m)" : "E* (Pa)", hooke ? "k_t (N/m)" : "8 G* (Pa)",
                                 "rolling", adhesion);
  for (int a = 0; a < count; ++a)
    for (int b = a; b < count; ++b) {
      const PenaltySettings& s = laws(a, b);
      const PenaltyLaw law =
          penalty_law(s, around.contact(a, b), around.materials[a], around.materials[b]);
      if (!(law.normal > 0)) continue;
      text += fmt::format("  {:<24}{:>14.4g}{:>18.4g}{:>10.4g}{:>18.4g}\n",
                          pair_name(around.materials, a, b), law.normal, law.tangential,
                          s.rolling_friction, s.adhesion_strength);
    }
  return text;
}

std::unique_ptr<Engine> make(const EngineSettings& settings) {
  return std::make_unique<Penalty>(settings.get<PenaltyKeys>().laws);
}

}  // namespace

const EngineType penalty_engine{
    .name = "penalty",
    .help = "grains that touch by springs and dashpots: Hertz and Mindlin, Hooke, DMT, JKR",
    .has_shapes = true,
    .moves_groups = true,
    .tables = {"contact", "penalty"},
    .read = read,
    .derive = derive,
    .check = check,
    .fields = fields,
    .describe = describe,
    .make = make};

}  // namespace spall
