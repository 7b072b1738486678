// Steps of smooth forces, whatever the forces: a splitting into kicks and drifts.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "engine/engine.hpp"
#include "gravity/kick.hpp"

namespace spall {

/// A symplectic integrator of H = T + V: a drift, then pairs of a kick and a drift; all are shares
/// of the step. The kicks add up to 1, and so do the drifts.
struct Splitting {
  struct Stage {
    double kick, drift;
  };
  double first_drift = 0;
  std::vector<Stage> stages;
};

/// Second order, one evaluation of the forces a step: drift, kick, drift.
inline const Splitting leapfrog{0.5, {{1, 0.5}}};

/// Gives the kick of gravity that is due and says how many steps of `h` may follow: up to
/// `most_steps`, the last of which ends at the next kick at the latest. A uniform field alone is
/// left to the kicks of the forces. Collective.
StepReport begin_smooth_steps(World& world, double h, int most_steps);
/// They were made: bodies have moved.
void end_smooth_steps(World& world, int steps);

/// Sets owned bodies back into the period; the height that this gives them in the uniform field is
/// booked. A search for pairs follows.
void wrap_bodies(World& world);

/// What half of a kick gives, told from the bodies before it and after all of it.
class HalfKick {
 public:
  explicit HalfKick(const World& before);
  /// J on this rank, of a kick over `t` (s): given to the bodies, or dissipated, but not by a
  /// program's forces or what moves as prescribed, whose work is booked whole. What the uniform
  /// field gives along the drift before the kick is left out: heights are told from before it.
  double energy(const World& after, double t) const;

 private:
  std::vector<Vec3> velocity_;
  std::vector<Vec3> spin_momentum_;    // kg m^2/s: a drift after the kick keeps it
  std::vector<Mat3> inverse_inertia_;  // where the kick is given; of shapes, which the drift turns
  double dissipated_, own_work_, prescribed_work_;
};

/// Advances the world by up to `most_steps` steps, the last of which ends at the next kick of
/// gravity at the latest; positions and velocities belong to its end. `forces` has
///
///   begin(h)                    of a step; owned velocities are current
///   drift(t)                    moves owned bodies by their velocities
///   energy()                    J on this rank, that pairs hold where bodies are
///   kick(t, drift, next_drift)  forces where bodies are, the kick by them and by
///                               `world.steady_gravity()`, then the two drifts, each rounded as if
///                               alone, while a body is in the cache
///   end()                       owned positions and velocities are current
///
/// The report's energy is read in the middle of the first kick, where leapfrog's positions and
/// velocities belong to one instant; what half the kick gives is added to it. With the kinetic
/// energy from before the drift it adds up to the energy that velocity Verlet tells. Collective.
template <class Forces>
StepReport smooth_steps(World& world, Forces&& forces, const Splitting& scheme,
                        const StepRequest& request) {
  const double h = request.h;
  StepReport report = begin_smooth_steps(world, h, request.most_steps);
  {
    StageTimer timer(world.stages, "motion");
    forces.begin(h);
    forces.drift(scheme.first_drift * h);
  }
  for (int step = 1; step <= report.steps; ++step)
    for (std::size_t k = 0; k < scheme.stages.size(); ++k) {
      const auto& [kick, drift] = scheme.stages[k];
      const bool goes_on = k + 1 == scheme.stages.size() && step < report.steps;
      const bool reads = request.energy && step == 1 && k == 0;
      if (reads) report.energy = forces.energy();
      std::optional<HalfKick> half;
      if (reads && scheme.first_drift > 0) half.emplace(world);
      forces.kick(kick * h, drift * h, goes_on ? scheme.first_drift * h : 0);
      if (half) report.energy += half->energy(world, kick * h);
    }
  forces.end();
  end_smooth_steps(world, report.steps);
  return report;
}

}  // namespace spall
