// What a run says in the end: the pile, and each read-out beside what momentum demands.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/deflection.hpp"
#include "analysis/interior.hpp"
#include "engine/engine.hpp"
#include "output/restart.hpp"
#include "output/results.hpp"
#include "run/simulation.hpp"
#include "scene/consistency.hpp"

namespace spall {

class Verdict {
 public:
  explicit Verdict(const Case& scene) : of_scene_(warning_of_read_outs(scene)) {}

  /// Looks at the pile as it is before the impactor is added, or at the end where there is none.
  /// Collective.
  void look_at_pile(const World& world);
  /// Called when the impactor is in the world; `struck_mass` as in BeforeImpact. Returns a line to
  /// show, or nothing.
  std::string impactor_added(const PhaseEvents& events, double restitution, double struck_mass);
  /// Looks at what moves in the target before anything has hit it. Collective.
  void look_at_target(const World& world, const Engine& engine);
  std::size_t read_outs() const { return rows_.size(); }
  /// Measures the deflection at this instant, `since_impact` seconds after the impactor was added.
  /// Velocities and positions must belong to the same instant. Returns a line to show. Collective.
  std::string read_out(const World& world, const Engine& engine, double since_impact);

  /// Adds its sections: [pile], [coupling], [deflection], [clump], [ejecta], [read_out].
  void add_to(ResultTable& table, const std::optional<Binary>& binary) const;

  /// What else than the impact moved the target, or nothing.
  std::string foreign_motion() const;
  /// What a reader of `beta` must know, or nothing: that, or no ejecta were resolved.
  std::string warning() const;

  bool has_impact() const { return before_.impactor >= 0; }
  /// kg m/s; the unit in which drifts are judged.
  double impactor_momentum() const { return before_.impactor_mass * before_.speed(); }
  double pile_radius() const { return pile_.extent / 2; }  ///< m

  void save(Scalars& scalars) const;
  void load(const Scalars& scalars);
  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f);

 private:
  /// What is kept of each read-out.
  struct Row {
    double since_impact, dv, beta, beta_along, clump_mass, clump_count, ejecta_count, ejecta_mass,
        v_ejecta, back_momentum, fastest, cone_half, cone_most, dv_impactor, dv_rebound, dv_ejecta,
        closure;
  };

  std::string of_scene_;  // warning
  BeforeImpact before_;
  Interior pile_;
  std::optional<HandOver> flow_;
  double restitution_ = 0;
  double closure_ = 0;      // largest of the read-outs
  bool has_struck_ = true;  // the largest clump, before the impact
  std::vector<Row> rows_;
  std::vector<FasterThan> faster_;  // of the last read-out
};

}  // namespace spall
