// What every engine is: a way to advance a world by steps, with a memory of its own.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "domain/ghosts.hpp"
#include "pairs/bonds.hpp"
#include "pairs/links.hpp"
#include "pairs/search.hpp"
#include "solver/report.hpp"
#include "state/contact_memory.hpp"
#include "state/world.hpp"

namespace spall {

/// What steps were; sums are over this rank's part until reduced by whoever prints them.
struct StepReport {
  int steps = 1;                ///< made
  SolverReport solver;          ///< of engines that solve for impulses
  std::int64_t contacts = 0;    ///< counted on one rank each
  double energy = 0;            ///< J, that pairs held at the start, if asked for; of smooth
                                ///< forces read as `smooth_steps` says
  double gravity_work = 0;      ///< J, of the kick at the start
  double overlap = 0;           ///< largest overlap over the smaller radius, on this rank
  int correction_products = 0;  ///< of the problem that took overlaps apart
  double withheld = 0;          ///< J of all ranks: what restitution would leave, at most, those
                                ///< that hit slower than gravity may drive what rests in a step
};

/// What is asked of an engine.
struct StepRequest {
  double h = 0;         ///< s
  int most_steps = 1;   ///< the field of gravity may be held so long
  bool energy = false;  ///< tell what pairs held at the start
};

/// Steps that a phase is about to make, from `world.time` on.
struct PlannedSteps {
  double h = 0;       ///< s
  double lasts = 0;   ///< s, all of them
  std::string place;  ///< "x.toml:12:1: phases.impact", for messages
};

/// What an engine keeps from one search for pairs to the next, and over a restart.
struct PairMemory {
  SharedContacts contacts;
  std::optional<Bonds> bonds;
};

/// What the last search for pairs went by and found: what a plan for other ranks begins with.
struct FoundPairs {
  const Search* search;       ///< rows are where it found them
  std::vector<double> reach;  ///< m, beyond its sphere, up to which an owned row was to meet others
  std::vector<double> work;   ///< of owned bodies, as the domain is cut by
  Links pairs;                ///< of rows, each once; those with walls are none of them
  /// Where not bodies meet but spheres of clumps, which are the rows then: these, of each the row
  /// of its body, and where bodies were (m).
  const Bodies* members = nullptr;
  std::span<const Index> whole = {};
  std::span<const Vec3> bodies_at = {};
};

/// A method of phases. Questions are const and move nothing; all calls are collective.
class Engine {
 public:
  virtual ~Engine() = default;

  /// Throws Error that begins with the steps' place where they are too long for this world, or
  /// where it repeats itself so soon that a body would meet two images of another.
  virtual void check_steps(const World& world, const PlannedSteps& steps) const = 0;

  /// Advances the world by one step where contacts are solved for, else by up to `most_steps`, the
  /// last of which ends at the next kick of gravity at the latest.
  virtual StepReport advance(World& world, const StepRequest& request) = 0;

  /// Brings velocities, which lag behind by half of the last interval between kicks of gravity, to
  /// the instant of the positions; `h` is the step that was made last (s).
  virtual SolverReport close_kick(World& world, double h);

  /// J over all ranks: what pairs hold, as they are.
  virtual double energy(const World& world) const = 0;

  /// What the pairs remember now.
  virtual PairMemory remember(const World& world) const = 0;
  /// The next step searches pairs anew and starts from this; ghosts are dropped.
  virtual void restart_pairs(World& world, PairMemory memory) = 0;

  /// Brings the fields that follow from the pairs (damage) up to date.
  virtual void measure_fields(World&) const {}
  /// Pairs that hold together: that touch, are within the range of cohesion, or are bound.
  virtual LinkedBodies links(const World& world) const = 0;
  /// Copies on this rank of what other ranks own, or of its own beyond the period.
  virtual Index ghosts(const World& world) const {
    return world.bodies.size() - world.bodies.owned;
  }
  /// None before the first step, and of engines without pairs.
  virtual std::optional<FoundPairs> found_pairs(const World&) const { return {}; }
};

}  // namespace spall
