// The loop over phases and steps; everything that a run writes is written from here.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/run/run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "methods.hpp"
#include "phase_start.hpp"
#include "signal_guard.hpp"
#include "spall/domain/pack.hpp"
#include "spall/motion/gravity_kick.hpp"
#include "spall/output/restart.hpp"
#include "spall/output/results.hpp"
#include "spall/output/series.hpp"
#include "spall/output/snapshot.hpp"
#include "spall/output/stored_bodies.hpp"
#include "spall/run/debris_log.hpp"
#include "spall/run/progress.hpp"
#include "spall/run/record.hpp"
#include "spall/run/verdict.hpp"
#include "spall/scene/scene.hpp"
#include "timetable.hpp"

namespace spall {
namespace {

class Run {
 public:
  Run(const Comm& comm, const Case& scene, const std::string& folder, const RestartState* from)
      : comm_(comm),
        scene_(scene),
        folder_(folder),
        debris_(scene),
        progress_(comm, scene),
        clock_(from ? from->clock : Clock{}),
        series_(comm, folder, Record::columns(), from ? clock_.step - 1 : -1),
        snapshots_(comm, folder, scene, from ? clock_.step : -1),
        seconds_at_start_(MPI_Wtime()),
        last_restart_(seconds_at_start_) {
    keep_reference(comm, folder, scene.reference);
    world_ = make_world(comm, scene);
    for (const auto& stage : stages) world_.times[stage] = 0;
    if (from) {
      world_.bodies = from->bodies;
      set_fields(world_.bodies, fields_of(scene));
      carried_memory(world_, phase().method) = from->contacts;
      world_.near.bonds = from->bonds;
      load(from->scalars);
    } else {
      progress_.say(describe_bodies(scene));
      world_.bodies = make_bodies(scene, comm);
    }
  }

  bool go() {
    const SignalGuard signals;
    progress_.say(describe_phases(scene_));
    while (clock_.phase < static_cast<std::int64_t>(scene_.phases.size())) {
      if (clock_.step_in_phase == 0) begin_phase();
      if (!run_phase(signals)) return false;
      end_phase();
    }
    finish();
    return true;
  }

  /// Beside what its parts keep.
  template <class Self, class F>
  static void for_each_scalar(Self& self, F&& f) {
    f("run.cohesion_before", self.cohesion_before_);
    f("run.has_moved", self.has_moved_);
    f("run.seconds", self.seconds_before_);
  }

 private:
  /// After the end still the last one.
  const Phase& phase() const {
    return scene_.phases[std::min<std::size_t>(clock_.phase, scene_.phases.size() - 1)];
  }
  const SolverSettings& solver() const { return phase().solver ? *phase().solver : scene_.solver; }
  std::int64_t steps_of_phase() const {
    return std::max<std::int64_t>(1, std::llround(phase().duration / phase().step));
  }

  void begin_phase() {
    progress_.say(fmt::format("phase {}: steps of {} for {}{}", phase().name,
                              readable_time(phase().step), phase().until_settled ? "at most " : "",
                              readable_time(phase().duration)));
    has_moved_ = false;
    const double energy_before = former() == Method::penalty ? elastic_energy(world_, former()) : 0;
    forget_former_pairs();
    if (phase().remove_drift || phase().impactor) begin_with_other_bodies();
    cohesion_before_ = world_.law.cohesion;
    if (phase().cohesion) world_.law.cohesion = *phase().cohesion;
    check_phase_step(world_, phase(), fmt::format("{}: phases.{}", scene_.file, phase().name));
    if (by_penalty() || former() == Method::penalty)
      book_springs(world_, phase().method, former(), cohesion_before_, energy_before, account_);
  }

  bool by_penalty() const { return phase().method == Method::penalty; }
  /// Before the first phase nothing is pressed together.
  Method former() const {
    return clock_.phase > 0 ? scene_.phases[clock_.phase - 1].method : Method::nonsmooth;
  }

  /// What the former phase's method knew of pairs and ghosts.
  void forget_former_pairs() {
    const bool same = clock_.phase == 0 || phase().method == former();
    if (same) {
      forget_near_pairs(world_, bonds_of(world_.bodies, world_.near));
    } else {
      resize(world_.bodies, world_.bodies.owned);
      forget_pairs(world_, std::nullopt);
    }
  }

  void begin_with_other_bodies() {
    const auto aim = change_bodies(world_, scene_, phase(), account_, verdict_);
    if (!aim) return;
    clock_.since_impact = 0;
    progress_.say(fmt::format("impactor: {:.4g} kg at {:.4g} m/s, aimed at body {}",
                              phase().impactor->mass, phase().impactor->speed, aim->struck));
  }

  /// False where a signal ended it.
  bool run_phase(const SignalGuard& signals) {
    const std::int64_t steps = steps_of_phase();
    while (clock_.step_in_phase < steps) {
      const bool fresh = world_.kick.steps_left == 0;
      const bool row = fresh && (scene_.output.series_every == 0 || row_due());
      Diagnostics sums;
      double elastic = 0;
      if (row) {
        evaluate_field(world_);
        elastic = elastic_energy(world_, phase().method);
        sums = diagnose(world_);
        if (is_settled(sums)) {
          progress_.say(fmt::format("settled after {}: rms speed {:.3g} m/s",
                                    readable_time(clock_.time_in_phase), sums.rms_speed));
          break;
        }
      }
      const auto limit = std::min<std::int64_t>(steps - clock_.step_in_phase,
                                                steps_to_event(scene_, clock_, phase().step));
      const Clock start = clock_;
      const StepReport report = step(static_cast<int>(std::min<std::int64_t>(limit, 1 << 30)));
      book(report);
      if (row) write_row(start, sums, elastic, report);
      if (progress_.due()) progress_.show(clock_, shown_);
      if (world_.kick.steps_left == 0) at_instant();
      if (comm_.any(signals.caught())) {
        save(restart_file());
        progress_.say(
            fmt::format("stopped by a signal; go on with: spall resume {}", restart_file()));
        return false;
      }
      if (comm_.any(MPI_Wtime() - last_restart_ > scene_.output.restart_every))
        save(restart_file());
    }
    return true;
  }

  /// One step, or as many without impulses as may pass before somebody asks for something.
  StepReport step(int most) {
    const StepsTaken taken =
        take_steps(world_, phase(), solver(), most, scene_.output.series_every == 0);
    for (int k = 0; k < taken.steps; ++k) tick();
    return taken.report;
  }

  void tick() {
    ++clock_.step;
    ++clock_.step_in_phase;
    clock_.time_in_phase = static_cast<double>(clock_.step_in_phase) * phase().step;
    clock_.time += phase().step;
    if (clock_.since_impact >= 0) clock_.since_impact += phase().step;
  }

  bool passed_multiple(double every) const {
    return spall::passed_multiple(clock_, phase().step, every);
  }
  bool row_due() const { return clock_.step == 0 || passed_multiple(scene_.output.series_every); }

  /// Snapshots and read-outs at the instant that the clock has just reached.
  void at_instant() {
    if (passed_multiple(scene_.output.snapshot_every)) snapshot();
    if (passed_multiple(debris_.every())) {
      StageTimer timer(world_.times, "analysis");
      progress_.say(debris_.read_out(world_, clock_.time));
    }
    if (clock_.since_impact < 0) return;
    for (double at : scene_.read_out) {
      if (std::abs(at - clock_.since_impact) > phase().step / 2) continue;
      evaluate_field(world_);
      StageTimer timer(world_.times, "analysis");
      progress_.say(verdict_.read_out(world_, clock_.since_impact));
    }
  }

  bool is_settled(const Diagnostics& sums) {
    if (!phase().until_settled) return false;
    if (sums.rms_speed > phase().settled_speed) has_moved_ = true;
    return has_moved_ && sums.rms_speed < phase().settled_speed;
  }

  void book(const StepReport& report) {
    record_.book(report);
    shown_.residual = report.solver.residual;
    if (phase().cohesion && !by_penalty() && clock_.step_in_phase == 1)
      account_.book_cohesion(cohesion_before_, world_.law.cohesion, comm_.sum(report.bonds));
  }

  /// The row of the instant at which the step began; `bonds` of that instant came with the step.
  void write_row(const Clock& start, const Diagnostics& sums, double elastic,
                 const StepReport& report) {
    StageTimer timer(world_.times, "output");
    // One reduction for what the ranks know in parts, one for what is largest on one of them.
    std::array<double, 3> parts{report.bonds, static_cast<double>(report.contacts),
                                report.gravity_work};
    comm_.sum(parts);
    // Velocities lag by half an interval; the kick's work up to this instant makes up for it.
    const GravityKick& kick = world_.kick;
    const double lag = kick.closed > 0 ? parts[2] * kick.closed / (kick.closed + kick.interval) : 0;
    const Balance balance =
        account_.balance(sums, kick.potential + lag, elastic - world_.law.cohesion * parts[0]);
    shown_.rms_speed = sums.rms_speed;
    shown_.contacts = static_cast<std::int64_t>(parts[1]);
    series_.append(start.step, start.time,
                   Record::row(start.phase, shown_.contacts, balance, report,
                               comm_.max(report.overlap), world_.times));
  }

  void snapshot() {
    evaluate_field(world_);
    StageTimer timer(world_.times, "output");
    measure_damage(world_.bodies, world_.near);
    snapshots_.write(world_.bodies, clock_.step, clock_.time);
  }

  void end_phase() {
    if (!passed_multiple(scene_.output.snapshot_every)) snapshot();
    progress_.say(fmt::format("phase {} done at {}: {} steps", phase().name,
                              readable_time(clock_.time), clock_.step_in_phase));
    const std::string file = folder_ + "/after_" + phase().name + ".h5";
    ++clock_.phase;
    clock_.step_in_phase = 0;
    clock_.time_in_phase = 0;
    save(file);
  }

  std::string restart_file() const { return folder_ + "/restart.h5"; }

  /// Leaves with rank 0, whose scalars a restart file keeps, what the ranks know in parts.
  void gather() {
    std::array<double, 3> sums{world_.ledger.dissipated, world_.ledger.cohesion_work,
                               world_.ledger.corrections};
    comm_.sum(sums);
    world_.ledger = comm_.rank == 0 ? Ledger{sums[0], sums[1], sums[2]} : Ledger{};
    for (auto& [stage, seconds] : world_.times) seconds = comm_.max(seconds);
    const double now = MPI_Wtime();
    seconds_before_ += now - seconds_at_start_;
    seconds_at_start_ = now;
  }

  /// Both the run that goes on and the one that resumes start from the file's state: pairs searched
  /// anew.
  void save(const std::string& file) {
    StageTimer timer(world_.times, "output");
    gather();
    RestartState state{.case_file = scene_.file,
                       .case_text = scene_.text,
                       .overrides = scene_.overrides,
                       .clock = clock_,
                       .scalars = {},
                       .bodies = world_.bodies,
                       .contacts = contact_memory(world_, phase().method),
                       .bonds = bonds_of(world_.bodies, world_.near)};
    resize(state.bodies, state.bodies.owned);
    save_scalars(*this, state.scalars);
    save_scalars(world_, state.scalars);
    save_scalars(record_, state.scalars);
    save_scalars(account_, state.scalars);
    verdict_.save(state.scalars);
    debris_.save(state.scalars);
    write_restart(comm_, file, state);
    world_.bodies = std::move(state.bodies);
    forget_pairs(world_, std::move(state.bonds));
    carried_memory(world_, phase().method) = std::move(state.contacts);
    last_restart_ = MPI_Wtime();
  }

  void load(const Scalars& scalars) {
    load_scalars(*this, scalars);
    load_scalars(world_, scalars);
    if (comm_.rank > 0) world_.ledger = {};
    load_scalars(record_, scalars);
    load_scalars(account_, scalars);
    verdict_.load(scalars);
    debris_.load(scalars);
  }

  void finish() {
    evaluate_field(world_);
    const Diagnostics sums = diagnose(world_);
    if (!verdict_.has_impact()) verdict_.look_at_pile(world_);
    ResultTable table;
    add_case(table);
    verdict_.add_to(table, scene_.binary);
    debris_.conclude(world_, phase().method == Method::potential, clock_.time, table);
    add_conservation(table, sums);
    const bool solves = std::ranges::any_of(
        scene_.phases, [](const Phase& one) { return one.method == Method::nonsmooth; });
    record_.add_to(table, clock_.step, solves);
    table.add("gravity", "evaluations", world_.kick.evaluations);
    const double total = MPI_Wtime() - seconds_at_start_ + seconds_before_;
    table.add("time", "total_s", comm_.max(total), "s");
    for (const auto& stage : stages)
      table.add("time", stage + "_s", comm_.max(world_.times[stage]), "s", "longest rank");
    table.add("time", "ranks", static_cast<std::int64_t>(comm_.size));
    progress_.say("\n" + table.text());
    write_results(comm_, folder_, table);
    snapshots_.write_index();
    series_.write_hdf5();
  }

  /// What tells the runs of a sweep apart.
  void add_case(ResultTable& table) {
    double cohesion = scene_.contact.cohesion;
    for (const Phase& phase : scene_.phases) {
      cohesion = phase.cohesion.value_or(cohesion);
      if (!phase.impactor) continue;
      table.add("case", "cohesion", cohesion, "N", "during the impact");
      table.add("case", "impactor_mass", phase.impactor->mass, "kg");
      table.add("case", "impactor_speed", phase.impactor->speed, "m/s");
    }
  }

  void add_conservation(ResultTable& table, const Diagnostics& sums) {
    const bool free = scene_.planes.empty() && scene_.uniform_gravity.isZero(0) &&
                      std::none_of(scene_.groups.begin(), scene_.groups.end(),
                                   [](const Group& group) { return group.fixed; });
    // An impactor's own momentum is the measure of its impact.
    const double unit = verdict_.has_impact() ? verdict_.impactor_momentum() : 0;
    if (free) account_.add_drifts(table, unit, unit * verdict_.pile_radius());
    account_.add_energies(table, sums, world_.kick.potential);
  }

  const Comm& comm_;
  const Case& scene_;
  std::string folder_;
  DebrisLog debris_;
  Progress progress_;
  Progress::State shown_;
  Clock clock_;
  Series series_;
  SnapshotWriter snapshots_;
  World world_;
  Record record_;
  Account account_;
  Verdict verdict_;
  double cohesion_before_ = 0;  // N
  bool has_moved_ = false;
  double seconds_before_ = 0, seconds_at_start_, last_restart_;
};

}  // namespace

bool run_case(const Comm& comm, const Case& scene, const std::string& folder) {
  return Run(comm, with_stored_bodies(scene), folder, nullptr).go();
}

bool resume_case(const Comm& comm, const std::string& file, const std::string& folder,
                 const std::vector<std::string>& overrides) {
  const RestartState state = read_restart(comm, file);
  std::vector<std::string> all = state.overrides;
  all.insert(all.end(), overrides.begin(), overrides.end());
  Case scene = parse_case(state.case_text, state.case_file, all);
  std::string own = std::filesystem::path(file).parent_path().string();
  if (own.empty()) own = ".";
  // Away from its case a run still has the copy beside its restart file.
  const std::string copy = own + "/reference.toml";
  if (!std::filesystem::is_regular_file(scene.reference))
    scene.reference = std::filesystem::is_regular_file(copy) ? copy : "";
  return Run(comm, scene, folder.empty() ? own : folder, &state).go();
}

}  // namespace spall
