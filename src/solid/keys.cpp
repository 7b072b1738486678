// One line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <set>

#include "solid/engine.hpp"
#include "solid/flaws.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

void read(Section& in, EngineSettings& settings) {
  SolidSettings solid;
  in.table("solid", "bodies with a stress, in phases with method = \"solid\"", [&](Section& s) {
    s.take("elastic", "true: nothing yields, melts or tears", solid.elastic);
    s.take("courant",
           "steps are parted: sound and bodies that meet cross this share of a spacing in a part; "
           "0: they are not",
           solid.courant, Quantity{dimension::number, 0, usual_courant});
  });
  settings.set(solid);
}

void derive(const Surroundings& around, std::span<const MaterialUse>, EngineSettings& settings) {
  auto solid = settings.get<SolidSettings>();
  solid.laws.assign(around.materials.size() + 1, {});  // the last: of an impactor, which has none
  for (std::size_t m = 0; m < around.materials.size(); ++m) {
    const auto& constants = around.materials[m].solid;
    if (!constants) continue;
    try {
      solid.laws[m] = solid_law(*constants, !solid.elastic, "");
      solid.laws[m].seed = around.seed;
    } catch (const Error&) {  // `check` tells, where a phase needs it
    }
  }
  settings.set(solid);
}

void check(const Surroundings& around, std::span<const MaterialUse> uses,
           const EngineSettings& settings, const PhaseView& phase) {
  const auto solid = settings.get<SolidSettings>();
  check_images(around, phase.place);
  require(!phase.cohesion, "{}.cohesion is that of contacts: in method = \"solid\" there is none",
          phase.place);
  require(!phase.impactor,
          "{}.method = \"solid\": the impactor has no constants of a solid; make it a group",
          phase.place);
  for (const MaterialUse& use : uses) {
    const Material& material = around.materials[use.material];
    const std::string place = fmt::format("{}.material = \"{}\"", use.place, material.name);
    require(material.solid.has_value(),
            "{}: {}.method = \"solid\" needs a solid of [materials]: one with a library, a file or "
            "a table [materials.{}.solid]",
            place, phase.place, material.name);
    solid_law(*material.solid, !solid.elastic, place);
    require(
        use.lattice.neighbours == 12,
        "{}: {}.method = \"solid\" needs a close-packed lattice: packing.kind = \"fcc\" or \"hcp\"",
        use.place, phase.place);
    constexpr double rounding = 1e-9;
    require(
        use.lattice.distance <= use.diameter * (1 + rounding),
        "{}: {}.method = \"solid\" needs spheres that touch: packing.spacing = {:g} m is more than "
        "their diameter, {:g} m; leave it out",
        use.place, phase.place, use.lattice.distance, use.diameter);
    require(
        !use.scaled,
        "{}.total_mass: in {}.method = \"solid\" the density is that of the material {}; change "
        "materials.{}.solid.density",
        use.place, phase.place, material.name, material.name);
  }
  const auto spacing = [](const MaterialUse& use) { return use.lattice.distance; };
  const auto [finest, coarsest] = std::ranges::minmax_element(uses, {}, spacing);
  if (finest == uses.end()) return;
  const double gap = 2 / std::sqrt(3.0) - 1;  // what passes between three spheres that touch
  require(spacing(*finest) > gap * spacing(*coarsest),
          "{}: its bodies, of {:.3g} m, would fly through the gaps between those of groups.{}, of "
          "{:.3g} m, and nothing would be said: more than {:.3g} of these is wanted",
          finest->place, spacing(*finest), coarsest->group, spacing(*coarsest), gap);
}

FieldSet fields(const Surroundings& around, const EngineSettings&) {
  FieldSet set{Field::heat,         Field::kick,           Field::damage,
               Field::compression,  Field::pressure,       Field::direct_stress,
               Field::shear_stress, Field::plastic_strain, Field::internal_energy};
  for (const Material& material : around.materials) {
    if (material.solid && material.solid->johnson_cook.fails()) set |= {Field::strained};
    if (material.solid && material.solid->pores.any()) set |= {Field::crushed};
  }
  return set;
}

bool breaks(const EngineSettings& settings, int material) {
  const SolidLaw& law = settings.get<SolidSettings>().laws[material];
  return law.yields && (std::isfinite(law.strength) || law.flow.fails() || law.flaws.known());
}

/// When it flows.
std::string flow_of(const SolidLaw& law) {
  if (law.steinberg.known())
    return fmt::format(
        "    flows at {:.4g} Pa (1 + {:g} eps)^{:g}, at most {:.4g} Pa, times what its shear "
        "modulus grows by: {:.4g}/GPa less {:.4g}/K\n",
        law.steinberg.y0, law.steinberg.beta, law.steinberg.n, law.steinberg.ymax,
        1e9 * law.steinberg.a, law.steinberg.b);
  if (!law.rock.known())
    return fmt::format("    flows at {:.4g} Pa + {:.4g} Pa eps^{:g}, C = {:g}, m = {:g}\n",
                       law.flow.a, law.flow.b, law.flow.n, law.flow.c, law.flow.m);
  return fmt::format(
      "    intact, bears a shear stress of {:.4g} Pa, and under pressure {:g} of it more, but at "
      "most {:.4g} Pa\n",
      law.rock.cohesion, law.rock.friction, law.rock.limit);
}

/// A yield strength beside another law of flow.
bool yields_in_contacts_alone(const Solid& solid) {
  return solid.yield_strength > 0 &&
         (solid.johnson_cook.a > 0 || solid.steinberg.known() || solid.rock.known());
}

/// How it breaks, in bodies of this spacing (m).
std::string failure_of(const SolidLaw& law, double spacing) {
  std::string failed =
      law.rock.failed_friction > 0
          ? fmt::format("    failed, slides at a shear stress of {:g} of its pressure\n",
                        law.rock.failed_friction)
          : "    failed, bears pressure alone: failed_friction is not known\n";
  if (!std::isfinite(law.melting_heat()))
    failed +=
        fmt::format("    {}: specific_heat or melting_point is not known\n",
                    law.steinberg.known() ? "does not melt" : "neither softens by heat nor melts");
  if (law.brittle()) {
    const double strain = strain_of_first_flaw(law, spacing);
    return fmt::format(
        "    breaks by cracks that grow at {:.4g} m/s from {:.4g}/m^3 eps^{:g} flaws: a tension of "
        "{:.4g} Pa opens one in half of the bodies\n{}",
        crack_speed(law), law.flaws.k, law.flaws.m, law.youngs_modulus() * strain, failed);
  }
  constexpr double of_a_bar = 1.0 / 3;  // the triaxiality
  std::string text =
      std::isfinite(law.strength)
          ? fmt::format(
                "    opens voids at a tension of {:.4g} Pa and fails where they are {:.3g} of the "
                "volume{}\n",
                law.strength, law.most_voids(volume_of_lattice(spacing)),
                law.fracture_energy > 0 ? "" : ": fracture_energy is not known")
          : std::string("    does not tear by tension: spall_strength is not known\n");
  if (!law.flow.fails())
    text += "    does not fail by strain: johnson_cook_d1 … are not known\n";
  else if (law.fracture_energy > 0)
    text += fmt::format(
        "    once strain fails it, parts over {:.3g} of plastic strain at {:.4g} Pa in "
        "a bar\n",
        law.parting_strain(of_a_bar, law.flow.a, volume_of_lattice(spacing)), law.flow.a);
  return text + failed;
}

std::string describe(const Surroundings& around, std::span<const MaterialUse> uses,
                     const EngineSettings& settings) {
  const auto solid = settings.get<SolidSettings>();
  std::string text;
  std::set<int> told;
  for (const MaterialUse& use : uses) {
    if (!told.insert(use.material).second) continue;
    const SolidLaw& law = solid.laws[use.material];
    double spacing = infinity;
    for (const MaterialUse& same : uses)
      if (same.material == use.material && same.lattice.distance > 0)
        spacing = std::min(spacing, same.lattice.distance);
    text += fmt::format(
        "\n  solid {}: bulk modulus {:.4g} Pa, shear modulus {:.4g} Pa, waves of {:.4g} and {:.4g} "
        "m/s\n",
        around.materials[use.material].name, law.bulk, law.shear, law.sound_speed(),
        std::sqrt(law.shear / law.density));
    if (law.yields) {
      if (law.pores.any())
        text += fmt::format(
            "    pores, {:.3g} of its volume, are crushed from {:.4g} Pa on and closed at {:.4g} "
            "Pa\n",
            1 - law.filled, law.pores.elastic, law.pores.compacted);
      text += flow_of(law);
      if (yields_in_contacts_alone(*around.materials[use.material].solid))
        text += "    yield_strength is not used: its flow has constants of its own\n";
      text += failure_of(law, spacing);
    } else {
      text += "    elastic: nothing yields, melts or tears\n";
    }
    if (solid.courant > 0)
      text += fmt::format("    steps are parted: parts of {:.3g} s at rest\n",
                          longest_step(law, spacing, 0, solid.courant));
    else
      text += fmt::format("    steps of at most {:.3g} s at rest\n", longest_step(law, spacing, 0));
  }
  return text;
}

std::unique_ptr<Engine> make(const EngineSettings& settings) {
  const auto solid = settings.get<SolidSettings>();
  return std::make_unique<Elastoplastic>(solid.laws, solid.courant);
}

}  // namespace

const EngineType solid_engine{
    .name = "solid",
    .help = "bodies with a stress each: metals that yield, melt and tear, rock and ice that crack",
    .steps_a_keep = 50,
    .tables = {"solid"},
    .read = read,
    .derive = derive,
    .check = check,
    .fields = fields,
    .breaks = breaks,
    .describe = describe,
    .make = make};

}  // namespace spall
