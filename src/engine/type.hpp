// An engine as a case sees it: its name, keys, fields and checks. The table is scene/engines.cpp.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/engine.hpp"
#include "engine/settings.hpp"
#include "keys/section.hpp"

namespace spall {

/// A group of bodies as laws see it.
struct MaterialUse {
  std::string place;     ///< where the case asks for it, for messages
  std::string group;     ///< its name
  int material = 0;      ///< index into the materials
  Lattice lattice = {};  ///< no neighbours: none
  double diameter = 0;   ///< m, of its spheres, the largest of unequal ones; 0: not known yet
  bool lone = false;     ///< it is one body
  bool unequal = false;  ///< its bodies have different sizes
  bool scaled = false;   ///< total_mass changes the density of its bodies
  double mass = 0;       ///< kg, of its lightest body; 0: not known yet
  bool fixed = false;    ///< or moves as prescribed: infinite mass
};

/// The lattice that all lattices of a material share. Throws Error, which begins with `place` where
/// there is none.
Lattice shared_lattice(const Surroundings& around, std::span<const MaterialUse> uses, int material,
                       const std::string& place);

/// Throws Error, which begins with `place`, where bodies would have to attract images of others.
void check_images(const Surroundings& around, const std::string& place);

/// A phase as its engine sees it.
struct PhaseView {
  std::string place;      ///< "cases/x.toml:12:1: phases.impact"
  bool impactor = false;  ///< there is one, whose material no law of materials can name
  bool cohesion = false;  ///< it sets another cohesion of contacts
};

struct EngineType {
  std::string_view name;      ///< of `method` in a phase
  std::string_view help;      ///< in a line
  bool deflects = false;      ///< its contacts tell what hangs together: read-outs of dv
  bool solves = false;        ///< for impulses: results tell its residuals
  int steps_a_keep = 1000;    ///< from one state that a stop can go back to, to the next
  bool has_shapes = false;    ///< its bodies may be other than spheres: state/body_shape.hpp
  bool moves_groups = false;  ///< its steps move groups as prescribed: engine/prescribed.hpp

  std::vector<std::string_view> tables = {};  ///< of a case, which say nothing to others

  /// Reads its own tables of a case.
  void (*read)(Section& in, EngineSettings& settings);
  /// Reads its keys of a phase, where it has any; `settings` begin as those of the case.
  void (*read_phase)(Section& in, EngineSettings& settings) = [](Section&, EngineSettings&) {};
  /// Completes the laws by the materials in use, where they need it: throws Error, with file, line
  /// and key, where one cannot be derived. Called for every type.
  void (*derive)(const Surroundings& around, std::span<const MaterialUse> uses,
                 EngineSettings& settings) = [](const Surroundings&, std::span<const MaterialUse>,
                                                EngineSettings&) {};
  /// Throws Error where a phase of this type asks for what it does not model.
  void (*check)(const Surroundings& around, std::span<const MaterialUse> uses,
                const EngineSettings& settings, const PhaseView& phase);
  /// Fields that it requests.
  FieldSet (*fields)(const Surroundings& around, const EngineSettings& settings);
  /// Whether what bodies of this material have gone through can part them for good: `damage`.
  bool (*breaks)(const EngineSettings& settings, int material) = [](const EngineSettings&, int) {
    return false;
  };
  /// Its laws in words and the longest step, for `spall check`; uses with masses.
  std::string (*describe)(const Surroundings& around, std::span<const MaterialUse> uses,
                          const EngineSettings& settings);
  std::unique_ptr<Engine> (*make)(const EngineSettings& settings);
};

}  // namespace spall
