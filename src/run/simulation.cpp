// Events stand at the starts of phases; between them there is one call to the engine.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/simulation.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/reduce.hpp"
#include "engine/prescribed.hpp"
#include "engine/type.hpp"
#include "gravity/kick.hpp"
#include "output/stored_bodies.hpp"
#include "pairs/lost_motion.hpp"
#include "run/later_steps.hpp"
#include "run/record.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Sums over all ranks go to rank 0; others begin anew. Collective.
void gather(const Comm& comm, std::vector<Reaction>& all) {
  static_assert(sizeof(Reaction) == 6 * sizeof(double), "summed as doubles");
  comm.sum(std::span(reinterpret_cast<double*>(all.data()), 6 * all.size()));
  if (comm.rank > 0) all.assign(all.size(), {});
}

/// With stored bodies, and checked with the spheres of a program.
std::shared_ptr<const Case> whole_case(const Comm& comm, const Scene& scene) {
  auto whole = std::make_shared<Case>(with_stored_bodies(*scene.parts(), InputFiles(comm)));
  check_spheres(*whole);
  return whole;
}

bool is_measure(double value) {
  return value >= 0 && std::isfinite(value);
}

/// Throws Error, on every rank, where a body is none any more after a program has changed it.
/// Collective.
void check_changed(const World& world, const Bodies& former) {
  constexpr std::array what{"a radius that is not more than 0",
                            "a mass that is not more than 0 or finite as before",
                            "a material that is not in [materials]",
                            "another group",
                            "a place, velocity or spin that is not finite",
                            "another shape, or an orientation whose length is not 1",
                            "another radius, mass or material than its stress is of",
                            "a compression that is not more than 0, or a negative strain or "
                            "energy, or one that is not finite",
                            "a damage that is less than 0 or more than 1",
                            "a sum of strains (`strained`) that is negative or not finite",
                            "pores that are crushed by less than 0 or more than 1",
                            "a stress that is not finite"};
  std::array<double, what.size()> wrong;  // ids
  wrong.fill(-1);
  constexpr double round_off = 1e-12;  // what a step leaves is much less
  const Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) {
    const bool held = is_held(former, b);
    const std::array right{
        bodies.radius[b] > 0 && std::isfinite(bodies.radius[b]),
        bodies.mass[b] > 0 && is_held(bodies, b) == held,
        bodies.material[b] >= 0 && bodies.material[b] < std::ssize(world.materials),
        bodies.group[b] == former.group[b],
        bodies.position[b].allFinite() && bodies.velocity[b].allFinite() &&
            (!bodies.has(Field::angular_velocity) || bodies.angular_velocity[b].allFinite()),
        !bodies.has(Field::shape) ||
            (bodies.shape[b] == former.shape[b] &&
             std::abs(bodies.orientation[b].squaredNorm() - 1) <= round_off),
        !bodies.has(Field::direct_stress) ||
            (bodies.radius[b] == former.radius[b] && bodies.mass[b] == former.mass[b] &&
             bodies.material[b] == former.material[b]),
        !bodies.has(Field::compression) ||
            (bodies.compression[b] > 0 && std::isfinite(bodies.compression[b]) &&
             is_measure(bodies.plastic_strain[b]) &&
             (bodies.internal_energy[b] == former.internal_energy[b] ||
              is_measure(bodies.internal_energy[b]))),
        !bodies.has(Field::compression) || (bodies.damage[b] >= 0 && bodies.damage[b] <= 1),
        !bodies.has(Field::strained) || is_measure(bodies.strained[b]),
        !bodies.has(Field::crushed) || (bodies.crushed[b] >= 0 && bodies.crushed[b] <= 1),
        !bodies.has(Field::direct_stress) ||
            (bodies.direct_stress[b].allFinite() && bodies.shear_stress[b].allFinite() &&
             std::isfinite(bodies.pressure[b]))};
    for (std::size_t k = 0; k < right.size(); ++k)
      if (!right[k]) wrong[k] = static_cast<double>(bodies.id[b]);
  }
  world.comm.max(wrong);
  for (std::size_t k = 0; k < what.size(); ++k)
    require(wrong[k] < 0, "change_bodies: body {:.0f} would have {}", wrong[k], what[k]);
}

/// Throws Error, on every rank, where stored bodies have a shape that the scene lacks, or lack the
/// shapes that it has. Collective.
void check_shapes(const Comm& comm, const Case& scene, const Bodies& stored) {
  const bool has = stored.has(Field::shape);
  const std::int64_t known = std::max<std::int64_t>(std::ssize(scene.shapes), 1);  // the sphere
  bool wrong = !has && !scene.shapes.empty();
  for (Index b = 0; has && b < stored.owned; ++b)
    wrong |= stored.shape[b] < 0 || stored.shape[b] >= known;
  require(!comm.any(wrong),
          "{}: bodies of the restart file have other shapes than [shapes] and packings tell",
          scene.file);
}

/// Calls of a program within another one: its force would move bodies while they are moved.
class Alone {
 public:
  Alone(bool& busy, std::string_view call) : busy_(busy) {
    require(!busy, "{} is called within a force or a change of bodies, which wait for it", call);
    busy = true;
  }
  ~Alone() { busy_ = false; }
  Alone(const Alone&) = delete;

 private:
  bool& busy_;
};

}  // namespace

struct Simulation::State {
  std::shared_ptr<const Case> scene;
  World world;
  std::unique_ptr<Engine> engine;
  const EngineType* type = nullptr;  // of `engine`
  Clock clock;
  Account account;
  bool has_moved = false;  // faster than the speed at which the phase's bodies are settled
  bool busy = false;       // a program's step or change goes on
  bool broken = false;     // one of its steps ended by an error

  State(const Comm& comm, std::shared_ptr<const Case> of)
      : scene(std::move(of)), world(make_world(comm, *scene)) {
    for (const auto& stage : stages) world.stages[stage];
  }
  void set_engine(const Phase& phase) {
    type = phase.engine;
    engine = type->make(phase.settings);
  }
  /// Throws Error where the steps that are left of the phase are too long. Collective.
  void check_steps() const {
    const Phase& phase = scene->phases[clock.phase];
    engine->check_steps(world, {.h = phase.step,
                                .lasts = std::max(phase.duration - clock.time_in_phase,
                                                  phase.step),  // what ends at once
                                .place = phase.place});
  }
  void tick(double h) {
    ++clock.step;
    ++clock.step_in_phase;
    clock.time_in_phase += h;  // steps may have been others before a restart
    clock.time += h;
    if (clock.since_impact >= 0) clock.since_impact += h;
  }
  /// Lets `change(sums)` change the bodies, sums being those before it, and books what that gives;
  /// gravity is evaluated before and after. Collective.
  template <class Change>
  void book_change(Change&& change) {
    evaluate_field(world);
    const Diagnostics before = diagnose(world);
    const double potential_before = world.kick.potential;
    change(before);
    world.kick.evaluated = false;
    evaluate_field(world);
    account.book_event(before, potential_before, diagnose(world), world.kick.potential);
  }

  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    f("simulation.has_moved", self.has_moved);
  }
};

Simulation::Simulation(const Comm& comm, const Scene& scene)
    : state_(std::make_unique<State>(comm, whole_case(comm, scene))) {
  state_->world.bodies = make_bodies(this->scene(), comm);
  state_->set_engine(phase());
}

Simulation::Simulation(const Comm& comm, const Scene& scene, const RestartState& from)
    : state_(std::make_unique<State>(comm, scene.parts())) {
  World& world = state_->world;
  check_shapes(comm, this->scene(), from.bodies);
  state_->clock = from.clock;
  world.bodies = from.bodies;
  FieldSet fields = fields_of(this->scene());
  // Spheres that a program added are not in the case's text, but they may spin.
  if (from.bodies.has(Field::angular_velocity)) fields |= {Field::angular_velocity};
  set_fields(world.bodies, fields);
  // At the start of a phase what pairs remember and hold is still the former phase's.
  const Clock& clock = state_->clock;
  state_->set_engine(this->scene().phases[clock.phase_of_last_step()]);
  state_->engine->restart_pairs(world, {from.contacts, from.bonds});
  world.time = clock.time;
  check_held(world, this->scene().file);
  load_scalars(world, from.scalars);
  // The field that was kept is of the settings then.
  const bool turns = from.bodies.has(Field::angular_acceleration);
  if (from.overridden || world.has_near_clumps() != turns) world.kick.evaluated = false;
  if (comm.rank > 0) {
    world.ledger = {};
    for (auto* all : {&world.reactions.of_walls, &world.reactions.of_groups})
      all->assign(all->size(), {});
  }
  load_scalars(state_->account, from.scalars);
  if (from.overridden) state_->account.change_laws();
  load_scalars(*state_, from.scalars);
  set_cohesion(world.contact, find_scalar(from.scalars, "law.cohesion"));
  if (!over() && clock.step_in_phase > 0) {
    // What the phase began with was checked then; what changed since are settings, and the step.
    constexpr double round_off = 1e-9;  // of a sum of steps
    const double former = clock.time_in_phase / static_cast<double>(clock.step_in_phase);
    if (from.overridden || std::abs(phase().step - former) > round_off * former)
      state_->check_steps();
    check_later_steps(world, this->scene(), clock);
  }
}

Simulation::~Simulation() = default;
Simulation::Simulation(Simulation&&) noexcept = default;

double Simulation::time() const {
  return state_->clock.time;
}
std::int64_t Simulation::steps() const {
  return state_->clock.step;
}
std::string Simulation::phase_name() const {
  return phase().name;
}
const Bodies& Simulation::bodies() const {
  return world().bodies;
}
const Case& Simulation::scene() const {
  return *state_->scene;
}
const World& Simulation::world() const {
  return state_->world;
}
World& Simulation::world() {
  return state_->world;
}
const Engine& Simulation::engine() const {
  return *state_->engine;
}
const Clock& Simulation::clock() const {
  return state_->clock;
}
Account& Simulation::account() {
  return state_->account;
}
bool Simulation::synchronous() const {
  return world().kick.steps_left == 0;
}
void Simulation::measure_fields() {
  state_->engine->measure_fields(world());
}
void Simulation::add_force(OwnForce force) {
  const Alone alone(state_->busy, "add_force");
  world().own_forces.push_back(std::move(force));
}

bool Simulation::over() const {
  return clock().phase >= std::ssize(scene().phases);
}

const Phase& Simulation::phase() const {
  return scene().phases[std::min<std::size_t>(clock().phase, scene().phases.size() - 1)];
}

std::int64_t Simulation::steps_left() const {
  return std::llround((phase().duration - clock().time_in_phase) / phase().step);
}

StepSummary Simulation::step(int most) {
  require(most > 0, "step: {} steps are asked for; 1 or more are wanted", most);
  require(!over(), "{}: all phases are over: there is no step to make", scene().file);
  const Alone alone(state_->busy, "step");
  require(
      !state_->broken,
      "an error broke off a step before: bodies and time no longer belong together; begin anew");
  state_->broken = true;
  if (clock().step_in_phase == 0) begin_phase();
  const auto check_finite = [&] {
    const double lost = first_lost_id(world().comm, world().bodies);
    require(!std::isfinite(lost),
            "{}: body {} has no finite place, velocity or spin any more after step {} of phase {}: "
            "the step may be too long, or a force of the program no number",
            phase().place, lost, clock().step, phase().name);
  };
  const StepReport report = [&] {
    try {
      return advance(static_cast<int>(std::min<std::int64_t>(most, steps_left())), false);
    } catch (const LostMotion&) {
      check_finite();
      throw;
    }
  }();
  auto contacts = static_cast<double>(report.contacts);
  double overlap = report.overlap;
  reduce(world().comm, {&contacts, 1}, {&overlap, 1});
  StepSummary summary{.steps = report.steps,
                      .contacts = static_cast<std::int64_t>(contacts),
                      .residual = report.solver.residual,
                      .converged = report.solver.converged,
                      .overlap = overlap};
  check_finite();
  if (steps_left() <= 0 ||
      (phase().until == PhaseEnd::settled && synchronous() && settled(diagnose(world()))))
    end_phase();
  state_->broken = false;
  return summary;
}

void Simulation::run_until(double time, const std::function<void()>& each) {
  require(!std::isnan(time), "run_until: the time is not a number");
  // Half a step early counts as reached: sums of steps are not exact.
  while (!over() && this->time() + phase().step / 2 < time) {
    step();
    if (each) each();
  }
}

void Simulation::change_bodies(const std::function<void(Bodies&)>& change) {
  const Alone alone(state_->busy, "change_bodies");
  World& world = state_->world;
  const double held = state_->engine->energy(world);
  state_->book_change([&](const Diagnostics&) {
    PairMemory memory = state_->engine->remember(world);
    resize(world.bodies, world.bodies.owned);
    const Bodies former = world.bodies;
    try {
      std::exception_ptr refused;
      try {
        change(world.bodies);
        require(world.bodies.id == former.id,
                "change_bodies: ids and the number of bodies must stay");
      } catch (...) {
        refused = std::current_exception();
      }
      // What fails on one rank fails on all: they would wait for it in what comes.
      const bool fails = world.comm.any(static_cast<bool>(refused));
      if (refused) std::rethrow_exception(refused);
      require(!fails, "change_bodies: it has failed on another rank");
      check_changed(world, former);
      check_held(world, "change_bodies");
    } catch (...) {  // what is refused has changed nothing
      world.bodies = former;
      state_->engine->restart_pairs(world, std::move(memory));
      throw;
    }
    state_->engine->restart_pairs(world, std::move(memory));
  });
  state_->account.book_energy(state_->engine->energy(world) - held);
}

Energies Simulation::energies() const {
  const Diagnostics sums = diagnose(world());
  World copy = world();
  resize(copy.bodies, copy.bodies.owned);
  evaluate_field(copy);
  return {.kinetic = sums.kinetic,
          .pairs = engine().energy(world()),
          .gravitational = copy.kick.potential - sums.fallen,
          .dissipated = sums.dissipated,
          .own_work = sums.own_work,
          .prescribed_work = sums.prescribed_work};
}

std::vector<BodyPair> Simulation::pairs() const {
  const LinkedBodies linked = engine().links(world());
  const std::vector<BodyId>& id = linked.bodies.id;
  std::vector<BodyPair> pairs;
  for (std::size_t k = 0; k < linked.links.i.size(); ++k) {
    const Index a = linked.links.i[k], b = linked.links.j[k];
    const Index lower = id[a] < id[b] ? a : b;
    if (lower < linked.bodies.owned)
      pairs.push_back({std::min(id[a], id[b]), std::max(id[a], id[b])});
  }
  return pairs;
}

bool Simulation::settled(const Diagnostics& now) {
  if (phase().until != PhaseEnd::settled) return false;
  if (now.rms_speed > phase().settled_speed) state_->has_moved = true;
  return state_->has_moved && now.rms_speed < phase().settled_speed;
}

PhaseEvents Simulation::begin_phase(const std::function<void(const World&)>& before_impactor) {
  PhaseEvents events;
  World& world = state_->world;
  std::unique_ptr<Engine>& engine = state_->engine;
  state_->has_moved = false;
  // Events are of one instant, and another method's forces act on velocities of this instant.
  if (clock().phase > 0 &&
      (phase().engine != state_->type || phase().remove_drift || phase().impactor))
    events.closing = engine->close_kick(world, scene().phases[clock().phase - 1].step);
  const bool other_method = clock().phase > 0 && phase().engine != state_->type;
  const bool other_law = phase().engine != state_->type || phase().cohesion;
  // What pairs hold changes hands: from the former engine and cohesion to these.
  const double held = other_law ? engine->energy(world) : 0;
  PairMemory memory = engine->remember(world);
  resize(world.bodies, world.bodies.owned);
  if (phase().engine != state_->type) {
    memory = {};
    // Of what another method did, bodies at rest have their heat.
    if (world.bodies.has(Field::internal_energy)) world.bodies.internal_energy = world.bodies.heat;
  }
  state_->set_engine(phase());
  if (phase().remove_drift || phase().impactor)
    state_->book_change([&](const Diagnostics& before) {
      if (phase().remove_drift) {
        const Vec3 velocity = before.momentum / before.mass;
        for (Index b = 0; b < world.bodies.owned; ++b) {
          world.bodies.position[b] -= before.centre;
          world.bodies.velocity[b] -= velocity;
        }
      }
      if (phase().impactor) {
        if (before_impactor) before_impactor(world);
        const BodyId id = world.comm.sum(static_cast<std::int64_t>(world.bodies.owned));
        events.aim = add_impactor(world.comm, scene(), *phase().impactor, world.bodies);
        events.before = before_impact(world.comm, world.bodies, id);
        if (phase().impactor->coupling)
          events.flow = hand_over_flow(world.comm, *phase().impactor, id, world.bodies);
        state_->clock.since_impact = 0;
      }
    });
  if (events.flow) {  // all that the impactor brought and no body carries
    if (world.comm.rank == 0) world.ledger.dissipated += events.flow->heat;
    state_->account.book_energy(events.flow->heat);
  }
  engine->restart_pairs(world, std::move(memory));
  if (phase().cohesion) set_cohesion(world.contact, *phase().cohesion);
  world.time = clock().time;
  set_prescribed_velocities(world, world.time, phase().step);
  state_->check_steps();
  check_later_steps(world, scene(), clock());
  if (other_law) {
    const double holds = engine->energy(world), had = std::max(held, 0.0);
    state_->account.book_energy(holds - held);
    if (other_method && holds > had) {
      const Diagnostics sums = diagnose(world);
      events.pushed = holds - had;
      events.pushed_share = events.pushed / (events.pushed + sums.kinetic + sums.dissipated + had);
    }
  }
  return events;
}

void Simulation::end_phase() {
  Clock& clock = state_->clock;
  ++clock.phase;
  clock.step_in_phase = 0;
  clock.time_in_phase = 0;
}

StepReport Simulation::advance(int most, bool energy) {
  const double h = phase().step;
  world().time = clock().time;
  if (!world().own_forces.empty()) most = 1;  // they may ask what time it is
  const StepReport report =
      state_->engine->advance(world(), {.h = h, .most_steps = most, .energy = energy});
  for (int k = 0; k < report.steps; ++k) state_->tick(h);
  return report;
}

RestartState Simulation::save() {
  // What the ranks know in parts goes to rank 0, whose scalars a restart file keeps.
  World& world = state_->world;
  Ledger& ledger = world.ledger;
  std::array<double, 7> sums{ledger.dissipated, ledger.cohesion_work, ledger.corrections,
                             ledger.own_work,   ledger.fallen,        ledger.prescribed_work,
                             ledger.gained};
  world.comm.sum(sums);
  const bool keeps = world.comm.rank == 0;
  ledger = keeps ? Ledger{sums[0], sums[1], sums[2], sums[3], sums[4], sums[5], sums[6]} : Ledger{};
  for (auto* all : {&world.reactions.of_walls, &world.reactions.of_groups})
    gather(world.comm, *all);
  PairMemory memory = engine().remember(world);
  RestartState state{.case_file = scene().file,
                     .case_text = scene().text,
                     .overrides = scene().overrides,
                     .constants = scene().constants,
                     .clock = clock(),
                     .scalars = {},
                     .period = world.period.size,
                     .bodies = world.bodies,
                     .contacts = std::move(memory.contacts),
                     .bonds = std::move(memory.bonds)};
  resize(state.bodies, state.bodies.owned);
  const StageUses own = world.stages;
  for (auto& [stage, use] : world.stages) use.seconds = world.comm.max(use.seconds);
  save_scalars(world, state.scalars);
  for (auto& [stage, use] : world.stages) use = own.at(stage);  // timers under way point to them
  save_scalars(state_->account, state.scalars);
  save_scalars(*state_, state.scalars);
  state.scalars["law.cohesion"] = world.contact.common().cohesion;
  return state;
}

void Simulation::go_on(const RestartState& state) {
  world().bodies = state.bodies;
  state_->engine->restart_pairs(world(), {state.contacts, state.bonds});
}

}  // namespace spall
