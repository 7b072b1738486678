// Drift h/2; strain since the last kick, stress; forces, kick h; drift h/2. Stress is brought to
// where bodies are at the end of the last step too, so that all belongs to one instant there.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "base/kernels.hpp"
#include "engine/prescribed.hpp"
#include "pairs/flight.hpp"
#include "solid/bodies_step.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Of impacts the energy that second order loses decides: with a fifth of a spacing a third of a
/// percent at 6.7 km/s, four times that in steps twice as long (cases/plate_solid).
constexpr double share_of_impacts = 4;

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
  engine.forces.assign(size, PushRow{});
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

/// Makes pairs and ghosts current at the present places.
void update_pairs(World& world, Elastoplastic& engine) {
  StageTimer timer(world.stages, "neighbours");
  NearPairs& near = engine.near;
  near.cut = world.cut;
  if (near.skin > 0 && near.moved > near.skin) {
    take_positions(world, engine);
    near.moved = approach_since_search(world, near);
  }
  if (near.skin == 0 || near.moved > near.skin) {
    const double skin = skin_of(world, near);
    take_positions(world, engine);
    wrap_bodies(world);
    search_near_pairs(world.comm, world.bodies, world.period, reach_of(world), skin, {}, near);
    engine.contacts = find_contacts(world, near.windows, near.skin);
    fill_rows(world, engine);
    engine.pairs = pairs_of_pieces(world.bodies, engine.reach.data(), near.windows);
  } else {
    ++near.steps;
  }
  near.ghosts.gather(doubles(engine.rows), doubles_a_row);
  if (world.period.any())
    for (Index g = 0; g < near.ghosts.ghosts(); ++g)
      engine.rows[world.bodies.owned + g].place += half_row(near.shifts[g], 0);
}

/// The sums of shapes at the present places, and the fastest neighbours.
void find_shapes(Elastoplastic& engine) {
  std::fill(engine.shapes.begin(), engine.shapes.end(), ShapeRow{});
  engine.fastest_pair2 =
      sweep_shapes(engine.pairs, engine.reach.data(), engine.rows.data(), engine.shapes.data());
}

/// Forces at the present places, the kick by them over `h`, and drifts over two times.
RowBox kick_and_drift(World& world, Elastoplastic& engine, double h, double first, double second) {
  StageTimer timer(world.stages, "forces");
  Bodies& bodies = world.bodies;
  const RowHalf fall = half_row(h * world.steady_gravity(), 0);
  RowBox box;
  double taken = 0;
  const auto finish = [&](Index b) {
    MotionRow& row = engine.rows[b];
    const RowHalf force = engine.forces[b];
    engine.forces[b] = RowHalf{};
    RowHalf kick{};
    if (std::isfinite(bodies.mass[b]))
      kick = (h / bodies.mass[b]) * force + fall;
    else
      book_held(world, b, vector_of(row.place), h * vector_of(force), Vec3::Zero());
    const RowHalf v = half_row(bodies.velocity[b], 0) + half_row(vector_of(kick), 0);
    bodies.velocity[b] = vector_of(v);
    bodies.kick[b] = vector_of(kick);
    for (int k = 0; k < 3; ++k) row.motion[k] = v[k];
    row.place = multiply_add(first, v, row.place);
    if (second != 0) row.place = multiply_add(second, v, row.place);
    box.add(v);
    bodies.heat[b] += h * force[3];
    bodies.internal_energy[b] += h * force[3];
    taken += h * force[3];
  };
  push_by_contacts(world, engine.laws, engine.contacts, h, engine.rows.data(),
                   engine.responses.data(), engine.forces.data());
  sweep_forces(engine.pairs, engine.reach.data(), engine.rows.data(), engine.responses.data(),
               engine.forces.data(), finish);
  world.ledger.dissipated += taken;
  return box;
}

double elastic_energy(const Bodies& bodies) {
  double energy = 0;
  for (Index b = 0; b < bodies.owned; ++b) energy += bodies.internal_energy[b] - bodies.heat[b];
  return energy;
}

/// 1/s: the largest share of its spacing that sound crosses in a body of this rank in a second,
/// with what compression and heat add where there are neighbours: else its pressure moves nothing.
double fastest_waves(const World& world, const Elastoplastic& engine) {
  const Bodies& bodies = world.bodies;
  const bool porous = bodies.has(Field::crushed);
  double fastest = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    const SolidLaw& law = engine.laws[bodies.material[b]];
    double c = law.sound_speed(), spacing = 2 * bodies.radius[b], shear = law.shear;
    const bool alone = engine.shapes[b].trace() == 0;
    if (const double x = bodies.compression[b]; !alone && (x > 1 || bodies.heat[b] > 0)) {
      const double matter = x * law.filled * (porous ? law.distension(bodies.crushed[b]) : 1);
      const double heat = bodies.heat[b] / (engine.rest_volume[b] * law.density);
      // (dP/d rho)_S of the heat's pressure Gamma rho e, Gamma rho constant from rest on.
      const double g = law.gruneisen, dense = std::max(1.0, matter);
      const double warmed = matter > 1 ? g * g / (dense * dense) : g * (1 + g);
      const double bulk2 = law.cold.at(dense).slope2 + warmed * heat;
      if (law.steinberg.known())
        shear *= std::max(1.0, law.stiffness(x, bodies.pressure[b], heat) / x);
      c = std::max(c, std::sqrt(bulk2 + 4 * shear / (3 * law.density)));
      spacing /= std::cbrt(std::max(1.0, x));
    }
    fastest = std::max(fastest, c / spacing);
  }
  return fastest;
}

/// 1/s: of its spacing, what a body of this rank moves by in a second against what is nearer than
/// its reach: another body, of any piece, or a wall.
double fastest_meeting(const World& world, const Elastoplastic& engine) {
  const Bodies& bodies = world.bodies;
  double fastest2 = engine.fastest_pair2;
  for (const PieceContact& c : engine.contacts.pieces) {
    const MotionRow &i = engine.rows[c.i], &j = engine.rows[c.j];
    const double a = engine.reach[c.i], b = engine.reach[c.j], mean = (a + b) / 2;
    if (vector_of(j.place - i.place).squaredNorm() >= mean * mean) continue;
    const double nearer = std::min(a, b);
    fastest2 = std::max(fastest2, vector_of(j.motion - i.motion).squaredNorm() / (nearer * nearer));
  }
  double fastest = neighbour_reach * std::sqrt(fastest2);
  const Walls walls = world.walls();
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (Index b = 0; b < bodies.owned; ++b) {
      const Face face = face_of(walls, w, vector_of(engine.rows[b].place));
      if (face.height + bodies.radius[b] < engine.reach[b])
        fastest = std::max(fastest,
                           std::abs(face.normal.dot(bodies.velocity[b])) / (2 * bodies.radius[b]));
    }
  return fastest;
}

/// s, that a part of a step may last by `longest_step`, with rows as they are. Bodies come no
/// nearer meanwhile than by half of the gap in which those that meet are seen and do not touch yet.
/// `velocities`: of this rank. Collective.
double longest_part(const World& world, const Elastoplastic& engine, const RowBox& velocities) {
  double slope = 0, narrowest = infinity;
  for (Index b = 0; b < world.bodies.owned; ++b) {
    slope = std::max(slope, engine.laws[world.bodies.material[b]].slope);
    narrowest = std::min(narrowest, 2 * world.bodies.radius[b]);
  }
  std::array<double, 4> most{fastest_waves(world, engine), fastest_meeting(world, engine), slope,
                             -narrowest};
  world.comm.max(most);
  const double seen = (neighbour_reach - 1) / 2 * -most[3];
  return std::min(engine.courant / (most[0] + share_of_impacts * most[2] * most[1]),
                  seen / velocities.united(world.comm).diagonal());
}

/// What `smooth_steps` asks of forces.
class Motion {
 public:
  Motion(World& world, Elastoplastic& engine)
      : world_(world), engine_(engine), dissipated_(world.ledger.dissipated) {}

  void begin(double) {
    velocities_ = velocities_with_walls(world_);
    fill_rows(world_, engine_);
  }
  void drift(double t) {
    for (Index b = 0; b < world_.bodies.owned; ++b) {
      MotionRow& row = engine_.rows[b];
      row.place = multiply_add(t, half_row(world_.bodies.velocity[b], 0), row.place);
    }
    move(t);
  }
  double energy() {
    update();
    return elastic_energy(world_.bodies) +
           energy_of_contacts(world_, engine_.laws, engine_.contacts, engine_.rows.data()) +
           world_.ledger.dissipated - dissipated_;
  }
  void kick(double h, double first, double second) {
    update();  // strains are of the motion before any kick
    if (!world_.own_forces.empty()) {
      take_positions(world_, engine_);
      kick_by_own_forces(world_, h);
    }
    ++engine_.parts;
    velocities_ = kick_and_drift(world_, engine_, h, first, second);
    StageTimer timer(world_.stages, "motion");
    if (world_.walls().size() > 0) velocities_.add(Vec3(Vec3::Zero()));
    move(first + second);
  }
  void end() {
    update();
    StageTimer timer(world_.stages, "motion");
    take_positions(world_, engine_);
  }
  /// s, that a part of a step may last from here, where pairs and shapes are current. Collective.
  double longest() const { return longest_part(world_, engine_, velocities_); }
  /// Stress and answers of where bodies are. New stresses have worked for `late` (s) of the time
  /// since the last ones, half of it if not told. Parts differ in length: there it is half of the
  /// kick that follows, and none at an end of steps.
  void update(std::optional<double> late = {}) {
    if (current_) return;
    update_pairs(world_, engine_);
    StageTimer timer(world_.stages, "forces");
    find_shapes(engine_);
    world_.ledger.dissipated += update_bodies(
        world_.bodies, engine_.laws, engine_.rest_volume, since_, late.value_or(since_ / 2),
        engine_.shapes.data(), engine_.rows.data(), engine_.responses.data());
    engine_.near.ghosts.gather(doubles(engine_.responses), response_width);
    since_ = 0;
    current_ = true;
  }

 private:
  void move(double t) {
    advance_prescribed(world_, t, velocities_);
    book_motion(world_.comm, velocities_, t, engine_.near);
    since_ += t;
    current_ = current_ && t == 0;
  }

  World& world_;
  Elastoplastic& engine_;
  double dissipated_, since_ = 0;
  bool current_ = false;
  RowBox velocities_;
};

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

/// Leapfrog as `smooth_steps` makes it, in parts of the steps that last as their bodies allow.
StepReport parted_steps(World& world, Motion&& motion, Elastoplastic& engine,
                        const StepRequest& request) {
  constexpr double most_parts = 100;  // signals wait no longer
  motion.begin(request.h);
  if (engine.next_part <= 0) {
    update_pairs(world, engine);
    find_shapes(engine);
    engine.next_part = motion.longest();
  }
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
    motion.update(part.h / 2);
    if (reads) report.energy = motion.energy();
    std::optional<HalfKick> half;
    if (reads) half.emplace(world);
    longest = std::min(motion.longest(), (1 + growth) * longest);
    now += part.h;
    const Part next = part.last ? Part{} : next_part(lasts - now, std::min(longest, request.h));
    motion.kick(part.h, part.h / 2, next.h / 2);
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
