// Says in words and tables what a case will make and run.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "spall/scene/packing.hpp"
#include "spall/scene/scene.hpp"
#include "spall/scene/shape.hpp"

namespace spall {
namespace {

/// Bytes that a body needs while a pile of them is solved: its row, its share of contacts (at most
/// six, in a close packing) with the solver's copies of them, its row of the field and of the
/// velocity changes.
std::size_t bytes_of_a_body(const Case& scene) {
  std::size_t row = 0;
  Bodies none;
  none.has = fields_of(scene);
  for_each_field(none, [&](const char*, auto& field) {
    row += sizeof(typename std::remove_reference_t<decltype(field)>::value_type);
  });
  constexpr std::size_t contact = 250, contacts = 6, field = 40, changes = 2 * 64;
  return row + contacts * contact + field + changes;
}

std::string describe_group(const Group& group, const GroupContent& content) {
  const double each = content.mean_mass(group), mass = each * static_cast<double>(content.count);
  std::string radius = fmt::format("{:.6g}", content.largest);
  if (content.smallest < content.largest)
    radius = fmt::format("{:.3g} to {:.3g}", content.smallest, content.largest);
  return fmt::format("  {:<16}{:>10}{:>14}{:>14.6g}{:>14.6g}{:>10.4f}{}\n", group.name,
                     content.count, radius, each, mass, content.volume / volume_of(group.volume),
                     group.fixed ? "  fixed" : "");
}

std::string describe_phase(const Phase& phase, double start) {
  std::string text =
      fmt::format("  {:<16}{:>12.6g}{:>12.6g}{:>10.0f}{:>12.6g}", phase.name, phase.step,
                  phase.duration, std::ceil(phase.duration / phase.step * (1 - 1e-12)), start);
  if (phase.until_settled)
    text += fmt::format("  at most, until the rms speed is below {:g} m/s", phase.settled_speed);
  if (phase.remove_drift) text += "  drift removed";
  if (phase.cohesion) text += fmt::format("  cohesion {:g} N", *phase.cohesion);
  if (phase.impactor)
    text +=
        fmt::format("  impactor {:g} kg at {:g} m/s", phase.impactor->mass, phase.impactor->speed);
  return text + "\n";
}

const char* name_of(PairLaw law) {
  switch (law) {
    case PairLaw::lennard_jones:
      return "Lennard-Jones";
    case PairLaw::mie:
      return "Mie";
    case PairLaw::morse:
      return "Morse";
    case PairLaw::steinhauser:
      return "Steinhauser";
  }
  return "";
}

/// The pair potential, what it makes of an fcc or hcp lattice, and the longest step.
std::string describe_potential(const Case& scene) {
  const PairPotential& p = *scene.potential;
  double lightest = infinity;
  const Group* lattice_group = nullptr;
  const std::vector<GroupContent> contents = measure_groups(scene);
  for (std::size_t g = 0; g < contents.size(); ++g) {
    const Group& group = scene.groups[g];
    if (group.fixed) continue;
    lightest = std::min(lightest, contents[g].mean_mass(group));
    if (!lattice_group && lattice_of(group.packing).neighbours == 12) lattice_group = &group;
  }
  std::string text = fmt::format(
      "\n  pair potential: {}, stiffness {:.4g} N/m, depth {:.4g} J, distance {:.4g} m{}\n",
      name_of(p.law), stiffness(p), p.depth, p.distance,
      scene.potential_of ? ", from " + scene.potential_of->material : "");
  if (p.law == PairLaw::morse) text += fmt::format("    steepness a d = {:.4g}\n", p.steepness);
  if (p.embedding.bulk_modulus > 0)
    text += fmt::format(
        "    embedded: bulk modulus {:.4g} Pa, Hugoniot slope {:.4g}, Gruneisen's parameter "
        "{:.4g}\n",
        p.embedding.bulk_modulus, p.embedding.hugoniot_slope, p.embedding.gruneisen);
  if (p.breaking_strain > 0)
    text += fmt::format("    bonds break at {:.3g} % of strain\n", 100 * p.breaking_strain);
  if (p.damping > 0)
    text += fmt::format("    damped at {:g} of critical where nearer than that\n", p.damping);
  if (lattice_group && std::isfinite(lightest)) {
    const Lattice lattice = lattice_of(lattice_group->packing);
    const LatticeSpeeds c = sound_speeds(p, lightest);
    text += fmt::format(
        "    its lattice: bulk sound speed {:.4g} m/s; waves along [100] {:.4g}, [110] {:.4g}, "
        "[111] {:.4g} m/s;\n    tears at {:.3g} Pa in a plane wave\n",
        c.bulk, c.along_100, c.along_110, c.along_111, plane_strength(p, lattice));
  }
  return text + fmt::format("    steps of at most {:.3g} s\n", longest_step(p, lightest));
}

}  // namespace

std::string describe_bodies(const Case& scene) {
  std::string text = fmt::format("{}\n\n", scene.title.empty() ? scene.file : scene.title);
  text += fmt::format("  {:<16}{:>10}{:>14}{:>14}{:>14}{:>10}\n", "group", "bodies", "radius (m)",
                      "mean (kg)", "all (kg)", "filled");
  const std::vector<GroupContent> contents = measure_groups(scene);
  std::int64_t all = 0;
  for (std::size_t g = 0; g < contents.size(); ++g) {
    text += describe_group(scene.groups[g], contents[g]);
    all += contents[g].count;
  }
  return text +
         fmt::format("\n  {} bodies, about {:.3g} MB over all ranks\n", all,
                     1e-6 * static_cast<double>(all) * static_cast<double>(bytes_of_a_body(scene)));
}

std::string describe_phases(const Case& scene) {
  std::string text;
  const auto has_cohesion = [](const Phase& phase) { return phase.cohesion.value_or(0) > 0; };
  if (scene.contact.friction == 0)
    text += "  no friction: one unknown a contact, no spins change\n";
  if (scene.contact.cohesion == 0 && std::ranges::none_of(scene.phases, has_cohesion))
    text += "  no cohesion\n";
  if (scene.gravity.method == GravityMethod::none) text += "  no self-gravity\n";

  if (scene.contact_of)
    text += fmt::format(
        "  contacts from {}: cohesion {:.4g} N up to a gap of {:.3g} m, friction {:.3g}\n",
        scene.contact_of->material, scene.contact.cohesion, scene.contact.cohesion_range,
        scene.contact.friction);
  if (scene.potential) text += describe_potential(scene);

  text += fmt::format("\n  {:<16}{:>12}{:>12}{:>10}{:>12}\n", "phase", "step (s)", "lasts (s)",
                      "steps", "starts (s)");
  double start = 0;
  for (const Phase& phase : scene.phases) {
    text += describe_phase(phase, start);
    start += phase.duration;
  }

  for (const Phase& phase : scene.phases)
    if (phase.impactor) {
      // Contacts are found however fast bodies fly; what a longer step loses is the order of hits.
      const double flight = phase.impactor->speed * phase.step;
      text += fmt::format(
          "\n  the impactor flies {:.3g} m a step, {:.3g} of its radius; steps of {:.3g} s are one "
          "radius (thesis eq. 3.1)\n",
          flight, flight / phase.impactor->radius, phase.impactor->radius / phase.impactor->speed);
    }
  return text;
}

}  // namespace spall
