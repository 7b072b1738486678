// Drift h/2; strain since the last kick, stress; forces, kick h; drift h/2. Stress is brought to
// where bodies are at the end of the last step too, so that all belongs to one instant there.
// Bodies that may go by longer steps act once a stride of several parts: docs/physics/solid.md.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <span>

#include "base/kernels.hpp"
#include "engine/prescribed.hpp"
#include "pairs/flight.hpp"
#include "solid/bodies_step.hpp"
#include "solid/part_lengths.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

double* doubles(auto& rows) {
  return reinterpret_cast<double*>(rows.data());
}

void fill_rows(const World& world, Elastoplastic& engine) {
  const Bodies& bodies = world.bodies;
  const auto size = static_cast<std::size_t>(bodies.size());
  engine.rest_volume = rest_volumes(bodies, engine.laws);
  engine.reach.resize(size);
  engine.rows.resize(size);
  engine.shapes.resize(size);
  engine.responses.resize(size);
  engine.impulses.assign(size, PushRow{});
  engine.waves.resize(bodies.owned);
  for (Index b = 0; b < bodies.size(); ++b) {
    engine.reach[b] = neighbour_reach * 2 * bodies.radius[b];
    engine.rows[b] = {
        half_row(bodies.position[b], engine.rest_volume[b] / std::max(1.0, bodies.compression[b])),
        half_row(bodies.velocity[b], bodies.damage[b] >= 1 ? infinity : bodies.pressure[b])};
  }
}

void take_positions(World& world, const Elastoplastic& engine) {
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.position[b] = vector_of(engine.rows[b].place);
}

/// m. Collective.
double widest_spacing(const World& world) {
  double radius = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) radius = std::max(radius, world.bodies.radius[b]);
  return 2 * world.comm.max(radius);
}

/// How far bodies may act: neighbours of a piece by their spacing, those of two by the sum of their
/// radii.
PairReach reach_of(const World& world) {
  return {.most = neighbour_reach * widest_spacing(world), .radii = neighbour_reach};
}

/// The skin of the next search. A body in a lattice of the spacing d has as many partners as
/// (1.7 + skin/d)^3, whatever d.
double skin_of(const World& world, const NearPairs& near) {
  std::array<double, 4> sums{};  // of the powers of 1/d
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const double inverse = 1 / (2 * world.bodies.radius[b]);
    const std::array<double, 4> powers{1, inverse, inverse * inverse, inverse * inverse * inverse};
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += powers[k];
  }
  world.comm.sum(sums);
  const double R = neighbour_reach;
  const Crowd crowd{R * sums[2] / sums[3], R * R * sums[1] / sums[3],
                    R * R * R * sums[0] / sums[3]};
  return best_skin(world.comm, world.bodies, near, crowd, 0, skins_of_lattice(sums[0] / sums[1]));
}

/// All owned bodies are brisk.
void forget_slow(const Bodies& bodies, Strides& strides) {
  strides.lasts = 0;
  strides.work = 1;
  strides.is_slow.assign(bodies.size(), 0);
  strides.slow.clear();
  strides.brisk.resize(bodies.owned);
  std::iota(strides.brisk.begin(), strides.brisk.end(), 0);
}

/// Tells ghosts which bodies are slow.
void tell_slow(const Bodies& bodies, Elastoplastic& engine) {
  std::vector<double> is_slow(bodies.size());
  for (const Index b : engine.strides.slow) is_slow[b] = 1;
  engine.near.ghosts.gather(is_slow.data(), 1);
  engine.strides.is_slow.assign(is_slow.begin(), is_slow.end());
}

/// Pairs and ghosts anew. Within a stride the domain is not cut: bodies stay where they are.
void search_pairs(World& world, Elastoplastic& engine) {
  NearPairs& near = engine.near;
  Strides& strides = engine.strides;
  const double skin = skin_of(world, near);
  const bool within_stride = strides.lasts > 0;
  if (within_stride)
    for (Index b = 0; b < world.bodies.owned; ++b) strides.from[b] -= engine.rows[b].place;
  take_positions(world, engine);
  wrap_bodies(world);
  if (within_stride)
    find_near_pairs(world.comm, world.bodies, world.period, reach_of(world), skin, {}, {}, near);
  else
    search_near_pairs(world.comm, world.bodies, world.period, reach_of(world), skin, {}, near);
  engine.contacts = find_contacts(world, near.windows, near.skin);
  fill_rows(world, engine);
  if (within_stride) {
    for (Index b = 0; b < world.bodies.owned; ++b) strides.from[b] += engine.rows[b].place;
    tell_slow(world.bodies, engine);
  } else {
    forget_slow(world.bodies, strides);
  }
  engine.pairs = pairs_of_pieces(world.bodies, engine.reach.data(), near.windows, strides.is_slow);
  note_paces(strides.is_slow, engine.pairs);
  strides.served = 0;
  strides.cut_waits = within_stride && world.comm.size > 1;
}

/// Makes pairs and ghosts current at the present places.
void update_pairs(World& world, Elastoplastic& engine) {
  StageTimer timer(world.stages, "neighbours");
  NearPairs& near = engine.near;
  near.cut = world.cut;
  if (near.skin > 0 && near.moved > near.skin) {
    take_positions(world, engine);
    near.moved = approach_since_search(world, near);
  }
  // Where the last search could not cut the domain, the next step's first one does.
  const bool cut_waits = engine.strides.cut_waits && engine.strides.lasts == 0;
  if (near.skin == 0 || near.moved > near.skin || cut_waits)
    search_pairs(world, engine);
  else
    near.steps = static_cast<int>(engine.strides.served += engine.strides.work);
  near.ghosts.gather(doubles(engine.rows), doubles_a_row);
  if (world.period.any())
    for (Index g = 0; g < near.ghosts.ghosts(); ++g)
      engine.rows[world.bodies.owned + g].place += half_row(near.shifts[g], 0);
}

/// The sums of the shapes of bodies of this pace at the present places. Returns the fastest
/// neighbours' v^2/R^2 (1/s^2).
double find_shapes(Elastoplastic& engine, Pace pace, const std::vector<MotionRow>& rows) {
  const Strides& strides = engine.strides;
  if (strides.lasts == 0) {
    std::ranges::fill(engine.shapes, ShapeRow{});
  } else {
    for (const Index b : pace == Pace::slow ? strides.slow : strides.brisk)
      engine.shapes[b] = ShapeRow{};
  }
  // Where slow ones are swept, brisk ones follow, and tell who is fastest.
  const bool tells = pace == Pace::brisk && strides.lasts > 0;
  return sweep_shapes(engine.pairs, pace, tells ? strides.is_slow.data() : nullptr,
                      engine.reach.data(), rows.data(), engine.shapes.data());
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
    for (int k = 0; k < 3; ++k) row.motion[k] = v[k];
    if (response.acts()) {
      // A brisk body beside slow ones gets another kick when all act than in between.
      if (strides.long_kicks && !strides.is_slow[b])
        strides.kick_by_slow[b] = vector_of(kick) - bodies.kick[b];
      else if (time >= h)
        bodies.kick[b] = h / time * vector_of(kick);
      row.place[3] = engine.rest_volume[b] / std::max(1.0, bodies.compression[b]);
      row.motion[3] = bodies.damage[b] >= 1 ? infinity : bodies.pressure[b];
      response.rest();
      for (int k = 0; k < 3; ++k) response.half_kick(k) = 0;
    }
    row.place = multiply_add(first, v, row.place);
    if (second != 0) row.place = multiply_add(second, v, row.place);
    (strides.is_slow[b] ? slow_box : box).add(v);
    bodies.heat[b] += impulse[3];
    bodies.internal_energy[b] += impulse[3];
    taken += impulse[3];
  };
  push_by_contacts(world, engine.laws, engine.contacts, h, engine.rows.data(),
                   engine.responses.data(), engine.impulses.data());
  sweep_forces(engine.pairs, all ? Pace::brisk | Pace::slow : Pace::brisk, engine.reach.data(),
               engine.rows.data(), engine.responses.data(), engine.impulses.data(), finish);
  world.ledger.dissipated += taken;
  if (all) strides.slow_box = {};
  strides.slow_box.add(slow_box);
  box.add(strides.slow_box);
  return box;
}

double elastic_energy(const Bodies& bodies) {
  double energy = 0;
  for (Index b = 0; b < bodies.owned; ++b) energy += bodies.internal_energy[b] - bodies.heat[b];
  return energy;
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
    forget_slow(world_.bodies, engine_.strides);
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
    for (Index b = 0; b < world_.bodies.owned; ++b) act_for(b, h / 2, h / 2, h);
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
      find_shapes(engine_, Pace::slow, mean_motion());
      update(strides.slow, slow_since_, slow_late_);
    }
    engine_.fastest_pair2 = find_shapes(engine_, Pace::brisk, engine_.rows);
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
    engine_.fastest_pair2 = find_shapes(engine_, Pace::brisk, engine_.rows);
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
    engine_.acts += all_act_ ? world_.bodies.owned : std::ssize(engine_.strides.brisk);
    velocities_ = kick_and_drift(world_, engine_, all_act_, h, first, second);
    StageTimer timer(world_.stages, "motion");
    if (world_.walls().size() > 0) velocities_.add(Vec3(Vec3::Zero()));
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
      sweep_meetings(engine_.pairs, engine_.reach.data(), engine_.rows.data(), meeting2.data());
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
    forget_slow(world_.bodies, strides);
    strides.parts_to_look = parts_between_looks;
    if (parts > 1) {
      strides.lasts = lasts;
      strides.work = stride.work;
      strides.least_limit = longest_ / 2;
      strides.brisk.clear();
      strides.from.resize(world_.bodies.owned);
      for (Index b = 0; b < world_.bodies.owned; ++b) {
        (goes_slow(b) ? strides.slow : strides.brisk).push_back(b);
        strides.from[b] = engine_.rows[b].place;
      }
      slow_since_ = 0;
      slow_late_ = -lasts / 2;
    }
    if (parts == 1 && !had_slow) return;
    tell_slow(world_.bodies, engine_);
    note_paces(strides.is_slow, engine_.pairs);
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

// --- the engine ---

double longest_step(const SolidLaw& law, double spacing, double speed, double courant) {
  return courant * spacing / (law.sound_speed() + share_of_impacts * law.slope * speed);
}

void Elastoplastic::check_steps(const World& world, const PlannedSteps& steps) const {
  const auto& [h, lasts, place] = steps;
  const double widest = widest_spacing(world);
  check_period(world.period, neighbour_reach * widest, place);
  const double speed = largest_meeting_speed(world, lasts);
  for (std::size_t m = 0; m < laws.size(); ++m) {
    double spacing = infinity;
    for (Index b = 0; b < world.bodies.owned; ++b)
      if (world.bodies.material[b] == static_cast<std::int32_t>(m))
        spacing = std::min(spacing, 2 * world.bodies.radius[b]);
    spacing = world.comm.min(spacing);
    if (!std::isfinite(spacing)) continue;
    require(laws[m].density > 0, "{}: material {} has no law of a solid", place, m);
    const double limit = longest_step(laws[m], spacing, speed);
    require(courant > 0 || h <= limit,
            "{}: step = {:g} s is too long for {}: a spacing of {:g} m, waves of {:.4g} m/s and "
            "speeds of {:.4g} m/s need at most {:.3g} s",
            place, h, world.materials[m].name, spacing, laws[m].sound_speed(), speed, limit);
  }
}

StepReport Elastoplastic::advance(World& world, const StepRequest& request) {
  return solid_steps(world, *this, request);
}

namespace {

/// Pairs as bodies are now, in a copy with ghosts of its own.
struct Found {
  World world;
  Elastoplastic engine;

  Found(const World& from, const Elastoplastic& of) : world(from), engine(of.laws) {
    resize(world.bodies, world.bodies.owned);
    find_near_pairs(world.comm, world.bodies, world.period, reach_of(world), 0, {}, {},
                    engine.near);
    engine.contacts = find_contacts(world, engine.near.windows, 0);
    fill_rows(world, engine);
  }
};

}  // namespace

double Elastoplastic::energy(const World& world) const {
  const Found found(world, *this);
  return world.comm.sum(
      elastic_energy(world.bodies) +
      energy_of_contacts(found.world, laws, found.engine.contacts, found.engine.rows.data()));
}

void Elastoplastic::restart_pairs(World& world, PairMemory) {
  resize(world.bodies, world.bodies.owned);
  near = {};
  strides = {};
  next_part = 0;
}

/// Whole neighbours of one piece hold together up to half the way to a lattice's second neighbours.
LinkedBodies Elastoplastic::links(const World& world) const {
  constexpr double nearer = 1.2;
  LinkedBodies linked;
  Found found(world, *this);
  const Bodies& bodies = found.world.bodies;
  for_each_pair(
      found.engine.near.windows, [&](std::size_t, std::size_t, std::size_t, Index i, Index j) {
        const double most = nearer * (bodies.radius[i] + bodies.radius[j]);
        if (bodies.group[i] != bodies.group[j] || bodies.damage[i] >= 1 || bodies.damage[j] >= 1 ||
            (bodies.position[j] - bodies.position[i]).norm() >= most)
          return;
        linked.links.i.push_back(i);
        linked.links.j.push_back(j);
      });
  linked.bodies = std::move(found.world.bodies);
  linked.ghosts = std::move(found.engine.near.ghosts);
  return linked;
}

}  // namespace spall
