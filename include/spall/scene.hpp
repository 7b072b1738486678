// A scene: what a case file says, and spheres that a program adds to it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "spall/pair_law.hpp"
#include "spall/types.hpp"

namespace spall {

struct Case;

/// A sphere that a program places.
struct SceneSphere {
  std::string material;  ///< one of the scene's [materials]
  double radius = 0;     ///< m
  double mass = 0;       ///< kg; 0: by the material's density
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();  ///< rad/s
  bool fixed = false;        ///< never moves
};

/// All calls throw Error with file, line, key and what would be right. No MPI: read it on every
/// rank.
class Scene {
 public:
  /// Of a case file; `overrides` are "key.path=value", as after --set.
  static Scene from_file(const std::string& file, const std::vector<std::string>& overrides = {});
  /// Of the text of a case file. [[groups]] may be left out where spheres are added.
  static Scene from_text(const std::string& toml, const std::vector<std::string>& overrides = {});

  /// Adds a sphere. Its id is the next: ids of groups come first, in the order of the case.
  Scene& add(const SceneSphere& sphere);

  /// The law of [pair_potential] law = "program": see spall/pair_law.hpp for what a law is.
  template <class Law>
  Scene& set_pair_law(Law law) {
    return set_law_of_program(std::make_shared<const PairLawOf<Law>>(std::move(law)));
  }
  Scene& set_law_of_program(std::shared_ptr<const PairLawOfProgram> law);

  // For Spall's own rooms.
  explicit Scene(std::shared_ptr<Case> parts) : case_(std::move(parts)) {}
  const std::shared_ptr<Case>& parts() const { return case_; }

 private:
  std::shared_ptr<Case> case_;
};

}  // namespace spall
