// The loop over phases and steps; everything that a run writes is written from here.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <new>

#include "base/first_rank.hpp"
#include "base/process.hpp"
#include "base/reduce.hpp"
#include "gravity/kick.hpp"
#include "output/files.hpp"
#include "output/restart.hpp"
#include "output/results.hpp"
#include "output/run_folder.hpp"
#include "output/series.hpp"
#include "output/snapshot.hpp"
#include "output/stored_bodies.hpp"
#include "pairs/lost_motion.hpp"
#include "run/changes.hpp"
#include "run/communication.hpp"
#include "run/debris_log.hpp"
#include "run/foretell.hpp"
#include "run/progress.hpp"
#include "run/reactions.hpp"
#include "run/record.hpp"
#include "run/shields.hpp"
#include "run/signal_guard.hpp"
#include "run/simulation.hpp"
#include "run/timetable.hpp"
#include "run/verdict.hpp"
#include "scene/scene.hpp"

namespace spall {
namespace {

/// The case that a restart file keeps, with these changes.
Case stored_case(const RestartState& state, const std::vector<std::string>& overrides,
                 const InputFiles& files) {
  return parse_case(state.case_text, state.case_file, overrides, Groups::may_lack, files,
                    state.constants);
}

/// What happened after the last row of the series counts, too: nothing goes on from here. Where
/// velocities lag behind a kick of gravity, it is closed if forces are smooth. What contacts would
/// answer to it, only the next step tells: there the last row closes the account.
void close_account(Simulation& simulation) {
  World& world = simulation.world();
  const Phase& phase = simulation.scene().phases[simulation.clock().phase_of_last_step()];
  if (!phase.engine->solves) close_kick(world);
  evaluate_field(world);
  if (world.kick.interval > 0) return;
  simulation.account().balance(diagnose(world), world.kick.potential,
                               simulation.engine().energy(world));
}

class Run {
 public:
  /// What `from` holds is let go, where there is one: bodies and pairs are there once.
  Run(const Comm& comm, const Scene& parts, const RunFolder& held, RestartState* from)
      : comm_(comm),
        scene_(*parts.parts()),
        folder_(held),
        resumes_at_(from ? from->clock.step : -1),
        debris_(scene_),
        shields_(comm, scene_),
        progress_(comm, scene_),
        reactions_(scene_),
        provenance_(provenance_of(comm, scene_)),
        verdict_(scene_),
        seconds_at_start_(MPI_Wtime()),
        last_restart_(seconds_at_start_) {
    if (from) {
      simulation_.emplace(comm, parts, *from);
      load(from->scalars);
      *from = RestartState{};
      std::string changes;
      for (const std::string& change : scene_.overrides) changes += " --set " + change;
      progress_.say(fmt::format("goes on: {}{}, step {}", scene_.file, changes, clock().step));
    } else {
      progress_.say(describe_bodies(scene_, comm.size, resident_bytes()));
      simulation_.emplace(comm, parts);
    }
    keep();  // with what --set changed, as files have it that are written before the next
  }

  bool go() {
    SignalGuard signals;
    const std::vector<GroupContent> contents = measure_bodies(comm_, scene_, world().bodies);
    debris_.weigh(contents);
    for (const std::string& told : unfilled_lattices(scene_, contents))
      unfilled_ += (unfilled_.empty() ? "" : "; ") + told;
    progress_.say(describe_phases(scene_, contents) + shields_.describe());
    say_what_is_over();
    if (begins_phase()) begin_phase();
    open_files();  // a run that was refused by now has left nothing
    while (!simulation_->over()) {
      progress_.begin_phase(clock());
      if (clock().step == 0) snapshot();
      if (!run_phase(signals)) return false;
      end_phase();
      if (begins_phase()) begin_phase();
    }
    finish();
    return true;
  }

  /// Beside what its parts keep.
  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    f("run.seconds", self.seconds_before_);
    f("run.rows", self.rows_.count);
    f("run.rows_checksum", self.rows_.checksum);
    f("run.snapshots", self.snapshots_written_);
    f("run.row", self.row_);
  }

 private:
  const Phase& phase() const { return simulation_->phase(); }
  const Clock& clock() const { return simulation_->clock(); }
  World& world() { return simulation_->world(); }
  const World& world() const { return simulation_->world(); }

  std::vector<Column> columns() const {
    std::vector<Column> all = Record::columns();
    const std::vector<Column> more = reactions_.columns();
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  bool begins_phase() const { return !simulation_->over() && clock().step_in_phase == 0; }

  void open_files() {
    if (!folder_.goes_on()) folder_.begin(comm_);
    snapshots_.emplace(comm_, folder_.path(), scene_, provenance_, snapshots_written_);
    series_.emplace(comm_, folder_.path(), columns(), resumes_at_ - 1, rows_);
    snapshots_->begin();  // nothing that either needs is lost
    if (folder_.goes_on()) folder_.begin(comm_);
    count_files();
    save_scalars(*this, kept_.scalars);  // another folder has others than those of the state
    keep_reference(comm_, folder_.path(), scene_.reference);
    keep_case(comm_, folder_.path(), scene_.resolved);
  }

  void count_files() {
    rows_ = series_->rows();
    snapshots_written_ = snapshots_->count();
  }

  void begin_phase() {
    progress_.say(fmt::format(
        "phase {}: steps of {} for {}{}", phase().name, readable_time(phase().step),
        phase().until == PhaseEnd::settled ? "at most " : "", readable_time(phase().duration)));
    const PhaseEvents events =
        simulation_->begin_phase([&](const World& world) { verdict_.look_at_pile(world); });
    if (!events.closing.converged)
      progress_.say(fmt::format(
          "WARNING: what contacts do at the end of the phase before was found to a residual of "
          "{:.2g} only",
          events.closing.residual));
    constexpr double little = 0.01;
    if (events.pushed_share > little) {
      pushed_[static_cast<std::size_t>(clock().phase)] = events.pushed;
      progress_.say("WARNING: " + words_of_pushed(phase(), events.pushed));
    }
    if (!events.aim) return;
    const Bodies& bodies = world().bodies;
    const auto struck = std::ranges::find(bodies.id, events.aim->struck);
    const bool own = struck != bodies.id.end();
    const auto row = struck - bodies.id.begin();
    const double material = comm_.max(own ? bodies.material[row] : -1.0);
    const bool meets = std::ranges::count(phase().engine->tables, "contact") > 0;
    const double struck_mass = comm_.max(own && meets ? bodies.mass[row] : 0.0);
    const std::string coupled = verdict_.impactor_added(
        events, world().contact(phase().impactor->material, static_cast<int>(material)).restitution,
        struck_mass);
    if (!events.flow) verdict_.look_at_target(world(), simulation_->engine());
    progress_.say(fmt::format("impactor: {:.4g} kg at {:.4g} m/s, aimed at body {}",
                              phase().impactor->mass, phase().impactor->speed, events.aim->struck));
    if (!coupled.empty()) progress_.say(coupled);
    if (events.flow)
      progress_.say(fmt::format(
          "its flow: {:.4g} kg get {:.4g} of its momentum back, beyond {:.4g} m; {:.4g} leave from "
          "within with its body; {:.3g} % of its energy moves bodies, {:.3g} % its own body, the "
          "rest is booked as heat",
          events.flow->found_mass, events.flow->given_momentum / verdict_.impactor_momentum(),
          events.flow->hand_over, events.flow->inner_momentum / verdict_.impactor_momentum(),
          100 * events.flow->flow_energy / events.flow->energy,
          100 * events.flow->carrier_energy / events.flow->energy));
  }

  /// Of a run that goes on from a restart file: what there is nothing left to do of.
  void say_what_is_over() {
    if (simulation_->over()) {
      progress_.say("all phases of this run are over: its results are written, no step is made");
    } else if (clock().step_in_phase > 0 && simulation_->steps_left() <= 0) {
      progress_.say(
          fmt::format("phase {} is over: it has run for {} in {} steps, its duration is {}",
                      phase().name, readable_time(clock().time_in_phase), clock().step_in_phase,
                      readable_time(phase().duration)));
    }
  }

  /// A phase that settled early may end before them.
  void say_what_was_not_read() {
    const auto asked = scene_.read_out.size(), made = verdict_.read_outs();
    if (made < asked)
      progress_.say(fmt::format(
          "{}: {} of {} times are left out: phases ended {:.4g} s after the impactor was added",
          scene_.read_out_place, asked - made, asked, std::max(clock().since_impact, 0.0)));
  }

  /// What a rank knows that all must act upon, the most pressing last.
  enum class News { none, restart_due, warned, stop, lost };

  News news_of_ranks(const SignalGuard& signals) const {
    News own = News::none;
    if (MPI_Wtime() - last_restart_ > scene_.output.restart_every) own = News::restart_due;
    if (signals.warned()) own = News::warned;
    if (signals.stops()) own = News::stop;
    if (first_lost(world().bodies) < world().bodies.owned) own = News::lost;
    return static_cast<News>(static_cast<int>(comm_.max(static_cast<double>(own))));
  }

  /// False where a signal ended it.
  bool run_phase(SignalGuard& signals) {
    Clock looked = clock();
    row_ = row_ || row_due(scene_, looked, looked);
    while (simulation_->steps_left() > 0) {
      const bool row = std::exchange(row_, false);
      Diagnostics sums;
      std::vector<double> received;  // by walls and held groups
      if (row) {
        evaluate_field(world());
        sums = diagnose(world());
        if (simulation_->settled(sums)) {
          progress_.say(fmt::format("settled after {}: rms speed {:.3g} m/s",
                                    readable_time(clock().time_in_phase), sums.rms_speed));
          break;
        }
        received = reactions_.received(world());
      }
      const Clock start = clock();
      const StepReport report = advance(row);
      record_.book(report, phase().engine->solves);
      ghosts_ = simulation_->engine().ghosts(world());
      shown_.residual = report.solver.residual;
      if (row) write_row(start, sums, report, received);
      if (progress_.due()) progress_.show(clock(), shown_);
      const News news = news_of_ranks(signals);
      if (news == News::lost) end_as_lost();
      if (simulation_->synchronous()) {
        at_instant(looked);
        row_ = row_due(scene_, looked, clock());
        looked = clock();
      }
      if (keep_due(scene_, clock())) keep();
      if (news == News::warned) signals.forget_warning();
      if (news == News::warned || news == News::restart_due) write_newest();
      if (news == News::stop) {
        write_newest();
        progress_.say(
            fmt::format("stopped by a signal; go on with: spall resume {}", restart_file()));
        return false;
      }
    }
    return true;
  }

  StepReport advance(bool row) {
    try {
      return simulation_->advance(most_steps(scene_, clock(), simulation_->steps_left(), world()),
                                  row);
    } catch (const LostMotion&) {
      end_as_lost();
    }
  }

  /// Snapshots and read-outs at the instant that the clock has just reached; `before` is the last
  /// one that was looked at.
  void at_instant(const Clock& before) {
    const auto passed = [&](double every) {
      return passed_multiple(scene_, before, clock(), every);
    };
    const double snapshots = scene_.output.snapshot_every, duration = phase().duration;
    const bool none = snapshots == 0 || snapshots > duration;
    if (passed(snapshots)) snapshot();
    if (passed(none ? duration / judgements_a_phase : snapshots)) judge_walls();
    if (passed(duration / looks_a_phase)) watch_walls();
    if (passed(debris_.every())) {
      StageTimer timer(world().stages, "analysis");
      for (const std::string& line : debris_.read_out(world(), clock().time)) progress_.say(line);
    }
    for (double at : scene_.read_out) {
      if (!read_out_due(scene_, before, clock(), at)) continue;
      evaluate_field(world());
      StageTimer timer(world().stages, "analysis");
      progress_.say(verdict_.read_out(world(), simulation_->engine(), clock().since_impact));
    }
  }

  /// The row of the instant at which the step began.
  void write_row(const Clock& start, const Diagnostics& sums, const StepReport& report,
                 std::vector<double>& received) {
    StageTimer timer(world().stages, "output");
    const std::array<double, 3> own{report.energy, static_cast<double>(report.contacts),
                                    report.gravity_work};
    std::vector<double> parts(own.begin(), own.end());
    parts.insert(parts.end(), received.begin(), received.end());
    double overlap = report.overlap;
    reduce(comm_, parts, {&overlap, 1});
    std::copy(parts.begin() + own.size(), parts.end(), received.begin());
    // Velocities lag by half an interval; the kick's work up to this instant makes up for it.
    const GravityKick& kick = world().kick;
    const double lag = kick.closed > 0 ? parts[2] * kick.closed / (kick.closed + kick.interval) : 0;
    const Balance balance = simulation_->account().balance(sums, kick.potential + lag, parts[0]);
    shown_.rms_speed = sums.rms_speed;
    shown_.contacts = static_cast<std::int64_t>(parts[1]);
    std::vector<double> values =
        Record::row(start.phase, shown_.contacts, balance, report, overlap, world().stages);
    const std::vector<double> forces = reactions_.row(start.time, received);
    values.insert(values.end(), forces.begin(), forces.end());
    series_->append(start.step, start.time, values);
  }

  void snapshot() {
    evaluate_field(world());
    StageTimer timer(world().stages, "output");
    simulation_->measure_fields();
    snapshots_->write(world().bodies, clock().step, clock().time);
  }

  void watch_walls() {
    StageTimer timer(world().stages, "analysis");
    shields_.watch(world(), simulation_->engine());
  }

  void judge_walls() {
    StageTimer timer(world().stages, "analysis");
    for (const std::string& line : shields_.read_out(world(), simulation_->engine(), clock().time))
      progress_.say(fmt::format("at {}: {}", readable_time(clock().time), line));
  }

  /// Of a phase that was to settle and has not.
  static std::string words_of_unsettled(const Phase& one, double rms_speed) {
    return fmt::format(
        "phase {} has not settled: its rms speed was {:.3g} m/s, and below {:.3g} m/s was asked "
        "for; a longer duration may settle it, unless whole groups move or spin, which counts",
        one.name, rms_speed, one.settled_speed);
  }
  /// Of a phase whose bodies overlap as the method before it bore them.
  static std::string words_of_pushed(const Phase& one, double energy) {
    return fmt::format(
        "phase {} pushes apart bodies that overlap as the method before it bore them: its pairs "
        "hold {:.3g} J more than pairs held before, out of nothing",
        one.name, energy);
  }
  /// Of all phases until now, one after another; empty where there are none.
  template <class Words>
  std::string all_of(const std::map<std::size_t, double>& of_phases, Words&& words) const {
    std::string text;
    for (const auto& [k, value] : of_phases)
      text += (text.empty() ? "" : "; ") + words(scene_.phases[k], value);
    return text;
  }
  std::string all_unsettled() const { return all_of(unsettled_, words_of_unsettled); }
  std::string all_pushed() const { return all_of(pushed_, words_of_pushed); }

  void say_if_unsettled(double rms_speed) {
    if (rms_speed < phase().settled_speed) return;
    unsettled_[static_cast<std::size_t>(clock().phase)] = rms_speed;
    progress_.say("WARNING: " + words_of_unsettled(phase(), rms_speed));
  }

  void end_phase() {
    if (snapshots_->last_step() != clock().step) snapshot();
    progress_.say(fmt::format("phase {} done at {}: {} steps", phase().name,
                              readable_time(clock().time), clock().step_in_phase));
    if (phase().until == PhaseEnd::settled) say_if_unsettled(diagnose(world()).rms_speed);
    const std::string file = folder_.path() + "/after_" + phase().name + ".h5";
    simulation_->end_phase();
    keep();
    write(file);
  }

  std::string restart_file() const { return folder_.path() + "/restart.h5"; }

  /// Leaves the state before, from which steps half as long may go on.
  [[noreturn]] void end_as_lost() {
    const double id = first_lost_id(comm_, world().bodies);
    write_newest();
    throw Error(fmt::format(
        "{}: body {} has no finite place, velocity or spin any more after step {} of phase {}: the "
        "step may be too long; '{}' is the state of step {}, before",
        phase().place, id, clock().step, phase().name, restart_file(), kept_.clock.step));
  }

  /// What is warned of phases, by the names that restart files have for it.
  template <class Self>
  static auto warned_phases(Self& self) {
    return std::array{std::pair{"unsettled", &self.unsettled_}, std::pair{"pushed", &self.pushed_}};
  }
  static std::string name_of(const char* what, std::size_t phase) {
    return fmt::format("run.{}.{}", what, phase);
  }

  void keep() {
    StageTimer timer(world().stages, "output");
    const double now = MPI_Wtime();
    seconds_before_ += now - seconds_at_start_;
    seconds_at_start_ = now;
    if (series_) count_files();
    kept_ = {};  // the former one is as large
    kept_ = simulation_->save();
    save_scalars(*this, kept_.scalars);
    record_.meet(comm_);
    record_.save(kept_.scalars);
    verdict_.save(kept_.scalars);
    debris_.save(kept_.scalars);
    shields_.save(kept_.scalars);
    reactions_.save(kept_.scalars);
    for (const auto& [what, of_phases] : warned_phases(*this))
      for (const auto& [k, value] : *of_phases) kept_.scalars[name_of(what, k)] = value;
    simulation_->go_on(kept_);
  }

  void write(const std::string& file) {
    StageTimer timer(world().stages, "output");
    write_restart(comm_, file, kept_);
  }

  /// Both generations would be the same where nothing was kept since.
  void write_newest() {
    if (restart_holds_ < 0) remove_unless_whole(comm_, restart_file());
    if (restart_holds_ != kept_.clock.step) write(restart_file());
    restart_holds_ = kept_.clock.step;
    last_restart_ = MPI_Wtime();
  }

  void load(const Scalars& scalars) {
    load_scalars(*this, scalars);
    record_.load(scalars);
    verdict_.load(scalars);
    debris_.load(scalars);
    shields_.load(scalars);
    reactions_.load(scalars);
    for (const auto& [what, of_phases] : warned_phases(*this))
      for (std::size_t k = 0; k < scene_.phases.size(); ++k)
        if (const std::string name = name_of(what, k); scalars.contains(name))
          (*of_phases)[k] = find_scalar(scalars, name);
  }

  void finish() {
    say_what_was_not_read();
    kept_ = {};  // nothing goes on from it, and what comes needs the memory
    close_account(*simulation_);
    const Diagnostics sums = diagnose(world());
    if (!verdict_.has_impact()) verdict_.look_at_pile(world());
    ResultTable table;
    add_case(table);
    if (const std::string told = all_unsettled(); !told.empty())
      table.add("settling", "warning", told);
    if (const std::string told = all_pushed(); !told.empty()) table.add("overlap", "warning", told);
    if (!unfilled_.empty()) table.add("lattices", "warning", unfilled_);
    verdict_.add_to(table, scene_.binary);
    const std::vector<std::string> doubts = debris_.conclude(
        world(), simulation_->engine(), !phase().engine->solves, clock().time, table);
    const std::vector<std::string> judged =
        shields_.conclude(world(), simulation_->engine(), clock().time, table);
    add_conservation(table, sums);
    const bool solves =
        std::ranges::any_of(scene_.phases, [](const Phase& one) { return one.engine->solves; });
    record_.meet(comm_);
    record_.add_to(table, clock().step, solves);
    const std::string slow_hits = record_.warning(sums.dissipated);
    if (!slow_hits.empty()) table.add("solver", "warning", slow_hits);
    table.add("gravity", "evaluations", world().kick.evaluations);
    const double total = MPI_Wtime() - seconds_at_start_ + seconds_before_;
    table.add("time", "total_s", comm_.max(total), "s");
    for (const auto& stage : stages)
      table.add("time", stage + "_s", comm_.max(world().stages[stage].seconds), "s",
                "longest rank");
    table.add("time", "ranks", static_cast<std::int64_t>(comm_.size));
    add_communication(world(), ghosts_, clock().step - std::max<std::int64_t>(resumes_at_, 0),
                      table);
    progress_.say("\n" + table.text());
    for (const std::string& told : {all_unsettled(), all_pushed()})
      if (!told.empty()) progress_.say("WARNING: " + told);
    if (const std::string warning = verdict_.warning(); !warning.empty()) progress_.say(warning);
    if (const std::string open = simulation_->account().warning(sums); !open.empty())
      progress_.say("WARNING: " + open);
    if (!slow_hits.empty()) progress_.say("WARNING: " + slow_hits);
    if (record_.relaxed() > 0)
      progress_.say(fmt::format(
          "WARNING: in {} of {} steps Coulomb's law and restitution gave contacts no impulses that "
          "were found; the convex law of friction gave them some",
          record_.relaxed(), clock().step));
    if (sums.gained > 0)
      progress_.say(fmt::format(
          "WARNING: hits of clumps gave {:.3g} J, beside {:.3g} J that bodies move with: "
          "restitution with friction may do so where a hit is eccentric, and without restitution "
          "nothing is gained",
          sums.gained, sums.kinetic));
    for (const std::string& line : doubts) progress_.say(line);
    for (const std::string& line : judged) progress_.say(line);
    snapshots_->write_index();
    series_->write_hdf5();
    write_results(comm_, folder_.path(), table, provenance_);  // the last: then the run is done
  }

  /// What tells the runs of a sweep apart.
  void add_case(ResultTable& table) {
    double cohesion = scene_.contact.common().cohesion;
    for (const Phase& phase : scene_.phases) {
      cohesion = phase.cohesion.value_or(cohesion);
      if (!phase.impactor) continue;
      table.add("case", "cohesion", cohesion, "N", "during the impact");
      table.add("case", "impactor_mass", phase.impactor->mass, "kg");
      table.add("case", "impactor_speed", phase.impactor->speed, "m/s");
    }
  }

  void add_conservation(ResultTable& table, const Diagnostics& sums) {
    // What held groups give is in the books. So is what walls give, but for the angular momentum of
    // overlaps that are taken apart there.
    const bool free = scene_.walls().size() == 0 && scene_.uniform_gravity.isZero(0);
    // An impactor's own momentum is the measure of its impact.
    const double unit = verdict_.has_impact() ? verdict_.impactor_momentum() : 0;
    const bool turns = !scene_.period.any();
    if (free)
      simulation_->account().add_drifts(
          table, unit, turns ? std::optional(unit * verdict_.pile_radius()) : std::nullopt);
    simulation_->account().add_energies(table, sums, world().kick.potential);
  }

  const Comm& comm_;
  const Case& scene_;
  const RunFolder& folder_;
  std::int64_t resumes_at_;  // the step of the restart file; negative: from the start
  Index ghosts_ = 0;         // of this rank, after the last step
  DebrisLog debris_;
  Shields shields_;
  Progress progress_;
  Progress::State shown_;
  ReactionRows reactions_;
  Provenance provenance_;
  std::optional<Series> series_;
  std::optional<SnapshotWriter> snapshots_;
  std::optional<Simulation> simulation_;
  Record record_;
  Verdict verdict_;
  RestartState kept_;
  std::int64_t restart_holds_ = -1;  // the step of the state that this run wrote into it last
  SeriesRows rows_;                  // that the folder has of this run
  std::int64_t snapshots_written_ = 0;
  bool row_ = false;                         // whether the series has one of this instant
  std::string unfilled_;                     // which lattices lack mass, or have too much
  std::map<std::size_t, double> unsettled_;  // phase -> m/s, rms, of those that were to settle
  std::map<std::size_t, double> pushed_;     // phase -> J, of those whose bodies overlapped
  double seconds_before_ = 0, seconds_at_start_, last_restart_;
};

/// Calls `f`. Where memory ends, an Error says how much was wanted and what `spall check`
/// foretells.
template <class F>
auto within_memory(const Comm& comm, const Case& scene, F&& f) {
  const double bytes_of_program = resident_bytes();
  try {
    return f();
  } catch (const std::bad_alloc& error) {
    std::string foretold = "more than there is";
    try {
      foretold = fmt::format(
          "{:.3g} MB a rank",
          1e-6 * bytes_of_a_rank(scene, measure_groups(scene), comm.size, bytes_of_program));
    } catch (const std::exception&) {  // to draw its bodies alone takes more
    }
    throw Error(fmt::format("{}: {}; its bodies are foretold to take {}", scene.file, error.what(),
                            foretold));
  }
}

}  // namespace

std::string check_case(const Comm& comm, const Case& scene, Foretold foretold) {
  const auto whole = std::make_shared<Case>(with_stored_bodies(scene, InputFiles(comm)));
  return within_memory(comm, *whole, [&] {
    const double bytes_of_program = resident_bytes();
    const Shields shields(comm, *whole);
    Simulation simulation(comm, Scene(whole));
    simulation.begin_phase();
    std::string text =
        describe_bodies(*whole, comm.size, bytes_of_program) +
        describe_phases(*whole, measure_bodies(comm, *whole, simulation.world().bodies)) +
        shields.describe();
    constexpr double seconds_of_sample = 2;
    if (foretold == Foretold::time_too)
      text += describe_time(simulation, sample_steps(simulation, seconds_of_sample));
    return text;
  });
}

std::string check_restart(const Comm& comm, const std::string& file) {
  const RestartState state = read_restart(comm, file);
  return fmt::format("a whole restart file of {}: step {}, {} from the start, {} bodies\n",
                     state.case_file, state.clock.step, readable_time(state.clock.time),
                     comm.sum(std::int64_t{state.bodies.owned}));
}

bool run_case(const Comm& comm, const Case& scene, const std::string& folder, Former former) {
  const RunFolder held(comm, folder, former);
  const auto whole = std::make_shared<Case>(with_stored_bodies(scene, InputFiles(comm)));
  return within_memory(comm, *whole, [&] { return Run(comm, Scene(whole), held, nullptr).go(); });
}

Case case_to_go_on(const Comm& comm, RestartState& state, const std::vector<std::string>& overrides,
                   const InputFiles& files) {
  const Case before = stored_case(state, state.overrides, files);
  state.overridden = !overrides.empty();
  if (overrides.empty()) return before;
  for (const std::string& change : overrides) check_change(state, before, change);
  std::vector<std::string> all = state.overrides;
  all.insert(all.end(), overrides.begin(), overrides.end());
  Case after = stored_case(state, all, files);
  check_cohesion_ahead(before, after);
  check_read_outs_ahead(state, before, after);
  check_walls_ahead(comm, state, before, after);
  follow_materials(before, after, state.bodies);
  return after;
}

namespace {

/// The account until now is that of the laws until now, which are changed.
void close_former_account(const Comm& comm, RestartState& state, const InputFiles& files) {
  const auto before = std::make_shared<Case>(stored_case(state, state.overrides, files));
  Simulation former(comm, Scene(before), state);
  close_account(former);
  save_scalars(former.account(), state.scalars);
}

}  // namespace

bool resume_case(const Comm& comm, const std::string& file, const ResumeOptions& options) {
  namespace fs = std::filesystem;
  RestartState state = read_restart(comm, file);
  on_first_rank(comm, [&] {
    const bool there = fs::is_regular_file(state.case_file);
    require(options.stored_case || !there || read_whole(state.case_file) == state.case_text,
            "'{}' has changed since '{}' was written: --set changes what lies ahead, --stored-case "
            "goes on with the case as it was",
            state.case_file, file);
  });
  const InputFiles files(comm);
  if (!options.overrides.empty()) close_former_account(comm, state, files);
  Case scene = case_to_go_on(comm, state, options.overrides, files);
  std::string own = fs::path(file).parent_path().string();
  if (own.empty()) own = ".";
  // Away from its case a run still has the copy beside its restart file.
  const std::string copy = own + "/reference.toml";
  if (!files.exists(scene.reference)) scene.reference = files.exists(copy) ? copy : "";
  const std::string folder = options.folder.empty() ? own : options.folder;
  const bool same = fs::exists(folder) && fs::equivalent(folder, own);
  // Unchanged it ends as it did; from the newest state it only grows longer.
  on_first_rank(comm, [&] {
    require(
        !same || options.overrides.empty() || options.former == Former::overwrite ||
            fs::path(file).filename().string().starts_with("restart") ||
            !fs::exists(folder + "/results.toml"),
        "'{}' holds a run that has ended, which --set would change from '{}' on: choose another "
        "folder with --out, or --overwrite it",
        folder, file);
  });
  const RunFolder held(comm, folder, same ? Former::go_on : options.former);
  return within_memory(comm, scene, [&] {
    return Run(comm, Scene(std::make_shared<Case>(scene)), held, &state).go();
  });
}

}  // namespace spall
