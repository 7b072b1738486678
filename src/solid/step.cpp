// Drift h/2; strain since the last kick, stress; forces, kick h; drift h/2. Stress is brought to
// where bodies are at the end of the last step too, so that all belongs to one instant there.
// Bodies that may go by longer steps act once a stride of several parts: docs/physics/solid.md.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "base/kernels.hpp"
#include "engine/prescribed.hpp"
#include "solid/bodies_step.hpp"
#include "solid/part_lengths.hpp"
#include "solid/piece_pairs.hpp"

namespace spall {
namespace {

/// The sums of the shapes of `which` bodies, those of these pairs, at the present places. Those of
/// others mean nothing from then on. Returns the fastest neighbours' v^2/R^2 (1/s^2).
double find_shapes(Elastoplastic& engine, std::span<const Index> which, const PiecePairs& pairs,
                   const std::vector<MotionRow>& rows) {
  for (const Index b : which) engine.shapes[b] = ShapeRow{};
  return sweep_shapes(pairs, engine.reach.data(), rows.data(), engine.shapes.data());
}
/// Pairs whose inner list holds at the present places.
const PiecePairs& with_inner(const Elastoplastic& engine, PiecePairs& pairs) {
  const NearPairs& near = engine.near;
  if (near.moved - pairs.inner_at > near.skin / inner_lists) {
    find_inner(pairs, engine.reach.data(), near.skin / inner_lists, engine.rows.data());
    pairs.inner_at = near.moved;
  }
  return pairs;
}
const PiecePairs& pairs_of_brisk(Elastoplastic& engine) {
  return with_inner(engine, engine.strides.lasts > 0 ? engine.strides.brisk_pairs : engine.pairs);
}

/// Forces of brisk bodies, or of `all`, at the present places, the kick by them in a part of `h`,
/// and drifts over two times.
RowBox kick_and_drift(World& world, Elastoplastic& engine, bool all, double h, double first,
                      double second) {
  StageTimer timer(world.stages, "forces");
  Bodies& bodies = world.bodies;
  const RowHalf field = half_row(world.steady_gravity(), 0);
  Strides& strides = engine.strides;
  const bool waits = !all && world.own_forces.empty();
  RowBox box = all ? RowBox{} : strides.slow_box, slow_box;
  const auto none = [](const RowHalf& v) {
    return v[0] == 0 && v[1] == 0 && v[2] == 0 && v[3] == 0;
  };
  double taken = 0;
  // To be inlined: GCC drops calls that do nothing but ask.
  const auto ask = [&](Index b) __attribute__((always_inline)) {
    __builtin_prefetch(&engine.rows[b]);  // that slow bodies only have where one is brisk
    __builtin_prefetch(&engine.impulses[b]);
    if (waits && strides.is_slow[b]) return;
    for (const auto* numbers : {&bodies.mass, &bodies.compression, &bodies.damage, &bodies.pressure,
                                &bodies.heat, &bodies.internal_energy, &engine.rest_volume})
      __builtin_prefetch(numbers->data() + b);
    for (const auto* vectors : {&bodies.velocity, &bodies.kick})
      __builtin_prefetch(vectors->data() + b);
  };
  const auto finish = [&](Index b) {
    MotionRow& row = engine.rows[b];
    const RowHalf impulse = engine.impulses[b];
    if (waits && strides.is_slow[b] && none(impulse)) {
      RowHalf v = row.motion;
      v[3] = 0;
      row.place = multiply_add(first, v, row.place);
      row.place = multiply_add(second, v, row.place);
      return;
    }
    ResponseRow& response = engine.responses[b];
    engine.impulses[b] = RowHalf{};
    const double time = response.time();
    RowHalf kick{};
    if (std::isfinite(bodies.mass[b]))
      kick = (1 / bodies.mass[b]) * impulse + time * field;
    else
      book_held(world, b, vector_of(row.place), vector_of(impulse), Vec3::Zero());
    const RowHalf v = half_row(bodies.velocity[b], 0) + half_row(vector_of(kick), 0);
    bodies.velocity[b] = vector_of(v);
    // Each half of a row is written at once: one that is read whole would wait for a part of it.
    RowHalf place = row.place, motion = v;
    motion[3] = row.motion[3];
    if (response.acts()) {
      // A brisk body beside slow ones gets another kick when all act than in between.
      if (strides.long_kicks && !strides.is_slow[b])
        strides.kick_by_slow[b] = vector_of(kick) - bodies.kick[b];
      else if (time >= h)
        bodies.kick[b] = h / time * vector_of(kick);
      place[3] = engine.rest_volume[b] / std::max(1.0, bodies.compression[b]);
      motion[3] = bodies.damage[b] >= 1 ? infinity : bodies.pressure[b];
      response.rest();
      for (int k = 0; k < 3; ++k) response.half_kick(k) = 0;
    }
    row.motion = motion;
    place = multiply_add(first, v, place);
    row.place = second != 0 ? multiply_add(second, v, place) : place;
    (strides.is_slow[b] ? slow_box : box).add(v);
    bodies.heat[b] += impulse[3];
    bodies.internal_energy[b] += impulse[3];
    taken += impulse[3];
  };
  push_by_contacts(world, engine.laws, engine.contacts, h, engine.rows.data(),
                   engine.responses.data(), engine.impulses.data());
  sweep_forces(with_inner(engine, all ? engine.pairs : strides.brisk_pairs), engine.reach.data(),
               engine.rows.data(), engine.responses.data(), engine.impulses.data(), ask, finish);
  world.ledger.dissipated += taken;
  if (all) strides.slow_box = {};
  strides.slow_box.add(slow_box);
  box.add(strides.slow_box);
  return box;
}

/// The next part of a time that is left (s), of at most `longest` (s). The last parts are even, so
/// that none is a splinter.
struct Part {
  double h;
  bool last;
};
Part next_part(double left, double longest) {
  constexpr double even = 8, round_off = 1e-9;
  const double parts = std::ceil(left / longest - round_off);
  return {parts <= even ? left / parts : longest, parts <= 1};
}

/// The longest part grows by no more than this share from one part to the next, since error of
/// second order comes from each change. It becomes shorter at once.
constexpr double growth = 0.05;

/// Of one of them to the next look whether a stride is worth it, where none is.
constexpr int parts_between_looks = 8;

/// What `smooth_steps` asks of forces.
class Motion {
 public:
  Motion(World& world, Elastoplastic& engine)
      : world_(world), engine_(engine), dissipated_(world.ledger.dissipated) {}

  void begin(double h) {
    longest_stride_ = h;
    velocities_ = velocities_with_walls(world_);
    fill_rows(world_, engine_);
    forget_slow(world_.bodies, engine_);
    wake_what_moves(world_, engine_);
  }
  void drift(double t) {
    for (Index b = 0; b < world_.bodies.owned; ++b) {
      MotionRow& row = engine_.rows[b];
      row.place = multiply_add(t, half_row(world_.bodies.velocity[b], 0), row.place);
    }
    move(t);
  }
  double energy() {
    update(since_ / 2);
    return elastic_energy(world_.bodies) +
           energy_of_contacts(world_, engine_.laws, engine_.contacts, engine_.rows.data()) +
           world_.ledger.dissipated - dissipated_;
  }
  void kick(double h, double first, double second) {
    update(since_ / 2);  // strains are of the motion before any kick
    for (const Index b : engine_.strides.brisk) act_for(b, h / 2, h / 2, h);
    push(h, first, second);
  }
  void end() {
    update(since_ / 2);
    StageTimer timer(world_.stages, "motion");
    take_positions(world_, engine_);
  }
  /// Stress and answers of where bodies are. New stresses of brisk bodies have worked for `late`
  /// (s) of the time since the last ones: in parts, which differ in length, half of the kick that
  /// follows, and none at an end of steps. Slow ones follow once a stride, and where `all` are to.
  void update(double late, bool all = true) {
    if (current_) return;
    update_pairs(world_, engine_);
    StageTimer timer(world_.stages, "forces");
    const Strides& strides = engine_.strides;
    all_act_ = strides.lasts == 0 || all || stride_ends();
    if (all_act_ && strides.lasts > 0) {
      find_shapes(engine_, strides.slow, with_inner(engine_, engine_.pairs), mean_motion());
      update(strides.slow, slow_since_, slow_late_);
    }
    engine_.fastest_pair2 =
        find_shapes(engine_, engine_.strides.brisk, pairs_of_brisk(engine_), engine_.rows);
    update(strides.brisk, since_, late);
    since_ = 0;
    current_ = true;
  }

  // Of parts alone:

  /// s, that a part may last from here, where pairs and shapes are current: of brisk bodies' waves
  /// and of all that meet. Bodies come no nearer meanwhile than by half of the gap in which those
  /// that meet are seen and do not touch yet. Collective.
  double longest() {
    StageTimer timer(world_.stages, "forces");
    if (bounds_.narrowest == 0) bounds_ = part_bounds(world_, engine_);
    std::array<double, 2> most{0, fastest_meeting(world_, engine_)};
    const auto look = [&](Index b) { most[0] = std::max(most[0], engine_.waves[b]); };
    std::ranges::for_each(engine_.strides.brisk, look);
    if (all_act_) std::ranges::for_each(engine_.strides.slow, look);
    world_.comm.max(most);
    longest_ =
        std::min(longest_part(engine_, bounds_, most[0], most[1]), bounds_.seen / 2 / spread());
    return longest_;
  }
  double first_longest() {
    update_pairs(world_, engine_);
    engine_.fastest_pair2 =
        find_shapes(engine_, engine_.strides.brisk, pairs_of_brisk(engine_), engine_.rows);
    find_waves(world_, engine_, engine_.strides.brisk);
    return longest();
  }
  /// The kick of a part of `h`, in which the bodies act that were updated. Where all were, a stride
  /// may begin, of parts that last `next` and end no later than `left` (s) from here.
  void kick_part(double h, double next, double left) {
    Strides& strides = engine_.strides;
    strides.long_kicks = false;
    if (all_act_ && (strides.lasts > 0 || (left > 0 && strides.parts_to_look-- <= 0))) {
      begin_stride(h, next, left);
    } else {
      for (const Index b : strides.brisk) act_for(b, h / 2, h / 2, h);
    }
    push(h, h / 2, next / 2);
  }

 private:
  void move(double t) {
    world_.time += t;
    book_motion(world_.comm, velocities_, t, engine_.near);
    since_ += t;
    slow_since_ += t;
    slow_late_ += t;
    current_ = current_ && t == 0;
  }
  void update(std::span<const Index> which, double since, double late) {
    world_.ledger.dissipated +=
        update_bodies(world_.bodies, engine_.laws, engine_.rest_volume, which, since, late,
                      engine_.shapes.data(), engine_.rows.data(), engine_.responses.data());
    if (engine_.courant > 0) find_waves(world_, engine_, which);
  }
  /// Its time is over, or bodies have become faster than it allows.
  bool stride_ends() const {
    const Strides& strides = engine_.strides;
    return slow_since_ + since_ / 2 >= strides.lasts || longest_ < strides.least_limit;
  }
  /// Rows with the velocities that have brought bodies to where they are since all acted.
  std::vector<MotionRow> mean_motion() const {
    std::vector<MotionRow> rows = engine_.rows;
    const auto owned = static_cast<std::size_t>(world_.bodies.owned);
    for (std::size_t b = 0; b < owned; ++b) {
      const RowHalf mean = (1 / slow_since_) * (rows[b].place - engine_.strides.from[b]);
      for (int k = 0; k < 3; ++k) rows[b].motion[k] = mean[k];
    }
    engine_.near.ghosts.gather(doubles(rows), doubles_a_row);
    for (std::size_t g = owned; g < rows.size(); ++g) rows[g].place = engine_.rows[g].place;
    return rows;
  }
  /// A body's forces act for these times before and after a part of `h` is half over.
  void act_for(Index b, double before, double after, double h) {
    ResponseRow& response = engine_.responses[b];
    response.act(before, after);
    const double share = (before + after) / h;
    for (int k = 0; k < 3; ++k) response.half_kick(k) = 0.5 * share * world_.bodies.kick[b][k];
  }
  void push(double h, double first, double second) {
    engine_.near.ghosts.gather(doubles(engine_.responses), response_width);
    if (!world_.own_forces.empty()) {
      take_positions(world_, engine_);
      kick_by_own_forces(world_, h);
    }
    ++engine_.parts;
    const Strides& strides = engine_.strides;
    engine_.acts += std::ssize(strides.brisk) + (all_act_ ? std::ssize(strides.slow) : 0);
    velocities_ = kick_and_drift(world_, engine_, all_act_, h, first, second);
    StageTimer timer(world_.stages, "motion");
    if (world_.walls().size() > 0 || !engine_.rests.empty()) velocities_.add(Vec3(Vec3::Zero()));
    move(first + second);
  }
  /// m/s: no two bodies are faster against each other. Collective.
  double spread() const { return velocities_.united(world_.comm).diagonal(); }
  /// Where all act in a part of `h`, a stride may begin, of parts that last `next` and end within
  /// `left` (s).
  void begin_stride(double h, double next, double left) {
    StageTimer timer(world_.stages, "forces");
    Strides& strides = engine_.strides;
    Stride stride;
    std::vector<double> limit;
    if (next > 0 && left >= 2 * next) {
      std::vector<double> meeting2(world_.bodies.size());
      sweep_meetings(with_inner(engine_, engine_.pairs), engine_.reach.data(), engine_.rows.data(),
                     meeting2.data());
      limit = longest_parts(world_, engine_, bounds_, meeting2);
      // Who is not seen to meet now does not touch before all act again.
      const double most = std::min({left, longest_stride_, bounds_.seen / spread()}) / next;
      stride = cheapest_stride(world_.comm, limit, next, most);
    }
    const int parts = stride.parts;
    const double lasts = parts * next;
    const auto goes_slow = [&](Index b) { return parts > 1 && limit[b] >= lasts; };
    const auto after = [&](Index b) { return (goes_slow(b) ? lasts : h) / 2; };
    const bool had_slow = strides.lasts > 0;
    for (const Index b : strides.brisk) {
      act_for(b, h / 2, after(b), h);
      if (!had_slow) continue;
      for (int k = 0; k < 3; ++k)
        engine_.responses[b].half_kick(k) += 0.5 * strides.kick_by_slow[b][k];
    }
    for (const Index b : strides.slow) act_for(b, slow_late_, after(b), h);
    strides.long_kicks = had_slow || parts > 1;
    strides.kick_by_slow.resize(world_.bodies.owned);
    forget_slow(world_.bodies, engine_);
    strides.parts_to_look = parts_between_looks;
    if (parts == 1) return;
    strides.lasts = lasts;
    strides.work = stride.work;
    strides.least_limit = longest_ / 2;
    std::vector<Index> brisk;
    for (const Index b : strides.brisk) (goes_slow(b) ? strides.slow : brisk).push_back(b);
    strides.brisk = std::move(brisk);
    strides.from.resize(world_.bodies.owned);
    for (Index b = 0; b < world_.bodies.owned; ++b) strides.from[b] = engine_.rows[b].place;
    slow_since_ = 0;
    slow_late_ = -lasts / 2;
    tell_slow(world_.bodies, engine_);
  }

  World& world_;
  Elastoplastic& engine_;
  double dissipated_, since_ = 0;
  double slow_since_ = 0, slow_late_ = 0;    // s, since slow bodies acted, and since they have for
  double longest_ = 0, longest_stride_ = 0;  // s, a part by what moves now; a step
  PartBounds bounds_;
  bool current_ = false, all_act_ = true;
  RowBox velocities_;
};

/// Leapfrog as `smooth_steps` makes it, in parts of the steps that last as their bodies allow.
StepReport parted_steps(World& world, Motion&& motion, Elastoplastic& engine,
                        const StepRequest& request) {
  constexpr double most_parts = 100;  // signals wait no longer
  motion.begin(request.h);
  if (engine.next_part <= 0) engine.next_part = motion.first_longest();
  double longest = engine.next_part;
  const double most =
      std::clamp(most_parts * longest / request.h, 1.0, static_cast<double>(request.most_steps));
  StepReport report = begin_smooth_steps(world, request.h, static_cast<int>(most));
  // A kick of gravity has changed velocities, those of the rows, too.
  motion.begin(request.h);
  const double lasts = report.steps * request.h;
  double now = 0;
  Part part = next_part(lasts, std::min(longest, request.h));
  motion.drift(part.h / 2);
  for (bool reads = request.energy;; reads = false) {
    motion.update(part.h / 2, part.last);
    if (reads) report.energy = motion.energy();
    std::optional<HalfKick> half;
    if (reads) half.emplace(world);
    longest = std::min(motion.longest(), (1 + growth) * longest);
    now += part.h;
    const Part next = part.last ? Part{} : next_part(lasts - now, std::min(longest, request.h));
    motion.kick_part(part.h, next.h, reads ? 0 : lasts - now);
    if (half) report.energy += half->energy(world, part.h);
    if (part.last) break;
    part = next;
  }
  engine.next_part = longest;
  motion.update(0);
  motion.end();
  end_smooth_steps(world, report.steps);
  return report;
}

}  // namespace

SPALL_KERNEL(StepReport, solid_steps,
             (World & world, Elastoplastic& engine, const StepRequest& request),
             (world, engine, request)) {
  if (engine.courant > 0) return parted_steps(world, Motion(world, engine), engine, request);
  return smooth_steps(world, Motion(world, engine), leapfrog, request);
}

}  // namespace spall
