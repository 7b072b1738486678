// Says in words and tables what a case will make and run.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "gravity/field.hpp"
#include "scene/consistency.hpp"
#include "scene/engines.hpp"
#include "scene/materials.hpp"
#include "scene/packing.hpp"
#include "scene/scene.hpp"
#include "scene/shape.hpp"

namespace spall {
namespace {

/// Bytes that the bodies of a group need at most, in the phase that needs most.
double bytes_of(const Case& scene, const Lattice& lattice, std::int64_t count) {
  // A settled pile has 2.4 contacts a body; inside a lattice each body shares its neighbours' ones.
  constexpr double of_a_pile = 2.4;
  const double contacts = lattice.neighbours > 0 ? lattice.neighbours / 2.0 : of_a_pile;
  double most = 0;
  for (const Phase& phase : scene.phases)
    most = std::max(most, bytes_a_body(*phase.engine, scene, contacts));
  // Who looks for pieces has bodies, ghosts and pairs of its own. Peaks of shots at shields.
  constexpr double of_looks = 1100;
  if (scene.debris || !scene.shields.empty()) most += of_looks;
  return most * static_cast<double>(count);
}

/// A row of the table of groups; `fraction`: of the volume that is filled.
std::string describe_content(const std::string& name, const GroupContent& content, double mass,
                             const std::string& fraction, const std::string& note) {
  const double each = mass / static_cast<double>(std::max<std::int64_t>(content.movable, 1));
  std::string radius = fmt::format("{:.6g}", content.largest);
  if (content.smallest < content.largest)
    radius = fmt::format("{:.3g} to {:.3g}", content.smallest, content.largest);
  const std::string fixed = content.movable < content.count
                                ? fmt::format("  {} fixed", content.count - content.movable)
                                : "";
  return fmt::format("  {:<16}{:>10}{:>22}{:>14.6g}{:>14.6g}{:>10}{}\n", name, content.count,
                     radius, each, mass, fraction, note.empty() ? fixed : note);
}

std::string describe_group(const Group& group, const GroupContent& content) {
  return describe_content(group.name, content, content.mass * content.mass_factor(group),
                          fmt::format("{:.4f}", content.volume / volume_of(group.volume)),
                          group.fixed    ? "  fixed"
                          : group.motion ? "  moves as prescribed"
                                         : "");
}

/// Those that a program adds.
std::string describe_spheres(const std::vector<SceneSphere>& spheres) {
  GroupContent content;
  for (const SceneSphere& sphere : spheres) content.add(sphere.radius, sphere.mass, !sphere.fixed);
  return describe_content("of the program", content, content.mass, "", "");
}

std::string describe_phase(const Phase& phase, double start) {
  std::string text = fmt::format("  {:<16}{:>12.6g}{:>12.6g}{:>10}{:>12.6g}", phase.name,
                                 phase.step, phase.lasts(), phase.steps(), start);
  if (phase.until == PhaseEnd::settled)
    text += fmt::format("  at most, until the rms speed is below {:g} m/s", phase.settled_speed);
  if (phase.remove_drift) text += "  drift removed";
  if (phase.cohesion) text += fmt::format("  cohesion {:g} N", *phase.cohesion);
  if (phase.impactor)
    text +=
        fmt::format("  impactor {:g} kg at {:g} m/s", phase.impactor->mass, phase.impactor->speed);
  return text + "\n";
}

/// Bodies of files bring their masses, whatever the density of their group's material is, and
/// neither damage nor material.
std::vector<std::string> told_of_files(const Case& scene) {
  std::vector<std::string> told;
  for (const Group& group : scene.groups) {
    double mass = 0, volume = 0;
    bool broken = false;
    std::set<int> materials;
    for (const StoredBody& body : group.packing.stored) {
      broken |= body.damage > 0;
      materials.insert(body.material);
      if (body.fixed) continue;
      mass += body.mass;
      volume += ball_volume(body.radius);
    }
    const Material& material = scene.materials[group.material];
    if (broken)
      told.push_back(fmt::format(
          "groups.{}: bodies of '{}' have damage, and go on without the bonds or stresses that are "
          "left",
          group.name, group.packing.file));
    if (materials.size() > 1)
      told.push_back(
          fmt::format("groups.{}: bodies of '{}' are of {} materials, and all of "
                      "materials.{} here",
                      group.name, group.packing.file, materials.size(), material.name));
    constexpr double told_apart = 1e-3;
    if (group.held() || group.total_mass ||
        std::abs(mass - material.density * volume) <= told_apart * material.density * volume)
      continue;
    told.push_back(fmt::format(
        "groups.{}: masses are those of '{}', {:.6g} kg/m^3 on average, not those of "
        "materials.{}, {:g} kg/m^3; total_mass would scale them",
        group.name, group.packing.file, mass / volume, material.name, material.density));
  }
  return told;
}

std::int64_t count_bodies(const Case& scene, const std::vector<GroupContent>& contents) {
  std::int64_t all = std::ssize(scene.spheres);
  for (const GroupContent& content : contents) all += content.count;
  return all;
}

}  // namespace

std::vector<std::string> unfilled_lattices(const Case& scene,
                                           const std::vector<GroupContent>& contents) {
  std::vector<std::string> told;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    const Material& material = scene.materials[group.material];
    if (group.held() || group.total_mass || !material.solid ||
        lattice_of(group.packing).neighbours == 0)
      continue;
    const double filled = filled_by(group, contents[g].count);
    if (std::abs(filled - 1) <= most_unfilled) continue;
    told.push_back(fmt::format(
        "groups.{}: its lattice has {:.3g} of the mass that its volume has at the density of "
        "materials.{}; {}",
        group.name, filled, material.name,
        group.packing.rotation.isZero(0) ? "packing.orientation = \"random\" fills plates"
                                         : "finer bodies or another diameter come nearer"));
  }
  return told;
}

double bytes_of_a_rank(const Case& scene, const std::vector<GroupContent>& contents, int ranks,
                       double bytes_of_program) {
  double bytes = 0;  // of bodies
  for (std::size_t g = 0; g < contents.size(); ++g)
    bytes += bytes_of(scene, lattice_of(scene.groups[g].packing), contents[g].count);
  bytes += bytes_of(scene, {}, std::ssize(scene.spheres));
  // Libraries take more once they are used: measured beside 36 MB at the start.
  constexpr double bytes_of_use = 6e6;
  return bytes_of_program + bytes_of_use + bytes / ranks;
}

std::string describe_bodies(const Case& scene, int ranks, double bytes_of_program) {
  std::string text = fmt::format("{}\n\n", scene.title.empty() ? scene.file : scene.title);
  text += fmt::format("  {:<16}{:>10}{:>22}{:>14}{:>14}{:>10}\n", "group", "bodies", "radius (m)",
                      "mean (kg)", "all (kg)", "filled");
  const std::vector<GroupContent> contents = measure_groups(scene);
  for (std::size_t g = 0; g < contents.size(); ++g)
    text += describe_group(scene.groups[g], contents[g]);
  if (!scene.spheres.empty()) text += describe_spheres(scene.spheres);
  const std::int64_t all = count_bodies(scene, contents);
  return text + fmt::format("\n  {} bodies, at most about {:.3g} MB a rank on {} rank{}\n", all,
                            1e-6 * bytes_of_a_rank(scene, contents, ranks, bytes_of_program), ranks,
                            ranks == 1 ? "" : "s");
}

std::string describe_phases(const Case& scene, const std::vector<GroupContent>& contents) {
  std::string text;
  const ByPair<ContactLaw>& contact = scene.contact;
  const auto sticks = [](const Phase& phase) { return phase.cohesion.value_or(0) > 0; };
  if (!has_cohesion(contact) && std::ranges::none_of(scene.phases, sticks))
    text += "  no cohesion\n";
  if (scene.gravity.method == GravityMethod::none) {
    text += "  no self-gravity\n";
  } else {
    text +=
        "  self-gravity: " + describe_gravity(scene.gravity, count_bodies(scene, contents)) + "\n";
  }
  if (!scene.contact_of.empty())
    text += fmt::format(
        "  contacts from {}: cohesion {:.4g} N up to a gap of {:.3g} m, friction {:.3g}\n",
        scene.contact_of, contact.common().cohesion, contact.common().cohesion_range,
        contact.common().friction);
  if (!contact.uniform()) {
    text += fmt::format("\n  {:<24}{:>10}{:>13}{:>14}{:>11}\n", "contacts of", "friction",
                        "restitution", "cohesion (N)", "range (m)");
    contact.for_each_pair([&](int a, int b, const ContactLaw& law) {
      text += fmt::format("  {:<24}{:>10.4g}{:>13.4g}{:>14.4g}{:>11.4g}\n",
                          pair_name(scene.materials, a, b), law.friction, law.restitution,
                          law.cohesion, law.cohesion_range);
    });
  }
  std::vector<MaterialUse> uses = material_uses(scene);
  for (std::size_t g = 0; g < contents.size(); ++g)
    if (contents[g].count > 0)
      uses[g].mass = contents[g].lightest * contents[g].mass_factor(scene.groups[g]);
  for (const EngineType* type : all_engines()) {
    std::vector<std::pair<std::string, std::string>> told;  // of each phase
    for (const Phase& phase : scene.phases)
      if (phase.engine == type)
        told.emplace_back(phase.name, type->describe(scene, uses, phase.settings));
    const auto differs = [&](const auto& one) { return one.second != told.front().second; };
    const bool alike = std::ranges::none_of(told, differs);
    if (alike && !told.empty()) text += told.front().second;
    for (const auto& [phase, words] : told)
      if (!alike && !words.empty()) text += fmt::format("\n  in phase {}:\n{}", phase, words);
  }

  text += fmt::format("\n  {:<16}{:>12}{:>12}{:>10}{:>12}\n", "phase", "step (s)", "lasts (s)",
                      "steps", "starts (s)");
  double start = 0;
  for (const Phase& phase : scene.phases) {
    text += describe_phase(phase, start);
    start += phase.lasts();
  }

  for (const Phase& phase : scene.phases)
    if (phase.impactor) {
      // Contacts are found however fast bodies fly; what a longer step loses is the order of hits.
      const double flight = phase.impactor->speed * phase.step;
      text += fmt::format(
          "\n  the impactor flies {:.3g} m a step, {:.3g} of its radius; steps of {:.3g} s are one "
          "radius\n",
          flight, flight / phase.impactor->radius, phase.impactor->radius / phase.impactor->speed);
    }
  for (const std::string& table : scene.unused) text += "\n  " + table + "\n";
  for (const std::string& told : warnings_of(scene)) text += "\n  " + told + "\n";
  for (const std::string& told : told_of_files(scene)) text += "\n  " + told + "\n";
  for (const std::string& told : unfilled_lattices(scene, contents)) text += "\n  " + told + "\n";
  return text;
}

}  // namespace spall
