// An engine in one file: bodies fly past each other, slowed by a drag. Compiled by the tests.
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "engine/smooth.hpp"
#include "engine/type.hpp"
#include "spall/error.hpp"
#include "state/pack.hpp"

namespace spall {
namespace {

/// What a case tells it.
struct FreeSettings {
  double drag = 0;  ///< 1/s: speeds fall as exp(-drag t)
};

/// What `smooth_steps` asks of forces.
class Flight {
 public:
  Flight(World& world, const FreeSettings& settings) : world_(world), settings_(settings) {}

  void begin(double) {}
  void drift(double t) {
    Bodies& bodies = world_.bodies;
    for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] += t * bodies.velocity[b];
  }
  double energy() const { return 0; }
  void kick(double h, double first, double second) {
    kick_by_own_forces(world_, h);
    Bodies& bodies = world_.bodies;
    const double kept = std::exp(-settings_.drag * h);
    for (Index b = 0; b < bodies.owned; ++b) {
      if (!std::isfinite(bodies.mass[b])) continue;
      world_.ledger.dissipated +=
          bodies.mass[b] / 2 * (1 - kept * kept) * bodies.velocity[b].squaredNorm();
      bodies.velocity[b] = kept * bodies.velocity[b] + h * world_.steady_gravity();
    }
    drift(first);
    if (second != 0) drift(second);
  }
  void end() {}

 private:
  World& world_;
  FreeSettings settings_;
};

struct Free final : Engine {
  FreeSettings settings;

  explicit Free(const FreeSettings& of_case) : settings(of_case) {}

  void check_steps(const World&, const PlannedSteps& steps) const override {
    require(settings.drag * steps.h < 1, "{}.step = {} s is longer than 1/drag, {} s", steps.place,
            steps.h, 1 / settings.drag);
  }
  StepReport advance(World& world, const StepRequest& request) override {
    return smooth_steps(world, Flight(world, settings), leapfrog, request);
  }
  double energy(const World&) const override { return 0; }
  PairMemory remember(const World&) const override { return {}; }
  void restart_pairs(World& world, PairMemory) override {
    resize(world.bodies, world.bodies.owned);
  }
  LinkedBodies links(const World& world) const override {
    LinkedBodies alone{world.bodies, Ghosts(world.comm, world.bodies.owned, {}), {}};
    resize(alone.bodies, alone.bodies.owned);
    return alone;
  }
};

void read_free(Section& in, FreeSettings& settings) {
  in.take("drag", "rate at which speeds fall", settings.drag, not_negative(Dimension{0, 0, -1}));
}

void read(Section& in, EngineSettings& settings) {
  FreeSettings free;
  in.table("free", "bodies that do not meet, in phases with method = \"free\"",
           [&](Section& s) { read_free(s, free); });
  settings.set(free);
}

void check(const Surroundings& around, std::span<const MaterialUse>, const EngineSettings&,
           const PhaseView& phase) {
  require(around.planes.empty() && around.cylinders.empty() && !around.period.any(),
          "{}.method = \"free\": [[planes]], [[boxes]], [[cylinders]] and [periodic] do not act in "
          "it",
          phase.place);
}

FieldSet fields(const Surroundings&, const EngineSettings&) {
  return {};  // beside those of every run
}

std::string describe(const Surroundings&, std::span<const MaterialUse>,
                     const EngineSettings& settings) {
  return fmt::format("  free flight, drag {:.4g} 1/s\n", settings.get<FreeSettings>().drag);
}

std::unique_ptr<Engine> make(const EngineSettings& settings) {
  return std::make_unique<Free>(settings.get<FreeSettings>());
}

}  // namespace

extern const EngineType free_engine;
const EngineType free_engine{.name = "free",
                             .help = "bodies that fly past each other, slowed by a drag",
                             .read = read,
                             .check = check,
                             .fields = fields,
                             .describe = describe,
                             .make = make};

}  // namespace spall
