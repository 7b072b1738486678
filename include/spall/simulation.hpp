// A scene on its way through time: what a program drives, `spall run` among them.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "spall/scene.hpp"

namespace spall {

struct World;
struct Phase;
struct Clock;
struct StepReport;
struct RestartState;
struct PhaseEvents;
struct Diagnostics;
class Account;
class Engine;

/// Forces of a program: adds to the force (N) on each owned body, row by row.
using OwnForce = std::function<void(const Bodies&, std::span<Vec3> force)>;

/// What steps were, over all ranks.
struct StepSummary {
  int steps = 0;              ///< made
  std::int64_t contacts = 0;  ///< of the last step; 0 of pair potentials
  double residual = 0;        ///< E of the contact solver, relative to no impulses; else 0
  bool converged = true;      ///< it met its tolerance
  double overlap = 0;         ///< largest, over the smaller radius; non-smooth contact
};

/// J, over all ranks. Kinetic energy is that of the velocities as they are.
struct Energies {
  double kinetic = 0;          ///< translation and rotation
  double pairs = 0;            ///< elastic, of potentials, or of cohesion (negative)
  double gravitational = 0;    ///< of bodies on each other, and in the uniform field
  double dissipated = 0;       ///< so far
  double own_work = 0;         ///< of the program's own forces, so far
  double prescribed_work = 0;  ///< of groups that move as prescribed, on the others, so far
};

/// Two bodies that touch, are within the range of cohesion, or are bound; each pair once.
struct BodyPair {
  BodyId i, j;  ///< i < j
};

/// All calls are collective. Questions are const and move nothing.
class Simulation {
 public:
  /// The bodies of a scene at its start, on the ranks of `comm`.
  Simulation(const Comm& comm, const Scene& scene);
  /// Goes on with the state of a restart file. Throws Error where it does not fit the scene.
  Simulation(const Comm& comm, const Scene& scene, const RestartState& from);
  ~Simulation();
  Simulation(Simulation&&) noexcept;

  double time() const;         ///< s since the start
  std::int64_t steps() const;  ///< since the start
  std::string phase_name() const;
  /// All phases are over.
  bool over() const;

  /// One step; at the start of a phase its events come first, at its end the next phase is due.
  /// Where forces are smooth, up to `most` steps, until gravity's next kick at the latest.
  /// After an error within a step, such as an exception of an own force, no other can be made.
  StepSummary step(int most = 1);
  /// Steps until the whole step that ends nearest to this time (s), or until all phases are over;
  /// `each` is called after each step.
  void run_until(double time, const std::function<void()>& each = {});

  /// This rank's bodies; rows [0, owned) are its own. They move to other rows and ranks as steps
  /// are made: their ids stay.
  const Bodies& bodies() const;
  /// Lets `change` change owned rows in place, but not their number or ids. Neighbours are found
  /// anew, what contacts remember stays with them; the energy that it gives is booked. Bodies that
  /// are fixed or move as prescribed must stay so. Throws Error where a body would be none any
  /// more; then, and where `change` throws, all bodies are as before.
  void change_bodies(const std::function<void(Bodies&)>& change);

  Energies energies() const;
  /// On the rank that owns body i.
  std::vector<BodyPair> pairs() const;

  /// From now on at each step. Their work is booked.
  void add_force(OwnForce force);

  // For Spall's own rooms: what a run with phases, books and files needs beside that.
  const Case& scene() const;
  const World& world() const;
  World& world();
  const Engine& engine() const;
  const Clock& clock() const;
  Account& account();
  /// Of the present phase; after the end of the last one still that.
  const Phase& phase() const;
  std::int64_t steps_left() const;  ///< of the phase
  /// Whether velocities and positions belong to the same instant, as they do when gravity's next
  /// kick is due.
  bool synchronous() const;
  /// Removes the drift, adds the impactor and sets the cohesion as the phase asks for; what that
  /// gives or takes is booked. Throws Error where the phase's step is too long. `before_impactor`
  /// is called with bodies that are about to be hit.
  PhaseEvents begin_phase(const std::function<void(const World&)>& before_impactor = {});
  /// Whether bodies have come to rest, as phases with until = "settled" ask; `now`: the sums.
  bool settled(const Diagnostics& now);
  /// The clock goes on to the next phase.
  void end_phase();
  /// One step where contacts are solved for, else as many as may pass until gravity's next kick,
  /// but at most `most`. With `energy` the report has what pairs held at the start.
  StepReport advance(int most, bool energy);
  /// Fields that follow from the pairs are current.
  void measure_fields();
  /// The state that a restart file keeps, sums with rank 0.
  RestartState save();
  /// Goes on with bodies and pairs that `save` took: pairs are searched anew, as they are after
  /// reading the file.
  void go_on(const RestartState& state);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace spall
