// Drift h/2, forces, kick h, drift h/2; where nothing is asked for in between, the drifts of two
// steps, each rounded as if alone, follow on the kick while the body is in the cache.
// SPDX-License-Identifier: BSD-3-Clause
#include "penalty/step.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "base/kernels.hpp"
#include "base/let_go.hpp"
#include "engine/free_turn.hpp"
#include "engine/prescribed.hpp"
#include "engine/split_turn.hpp"
#include "pairs/flight.hpp"
#include "penalty/walls.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// m: of all bodies that meet, and of those that make up the crowd: not more than a few times as
/// large as the mean. Collective.
struct Radii {
  double largest = 0, ordinary = 0;
};
Radii radii_of(const Comm& comm, const Bodies& bodies) {
  constexpr double few = 4;
  std::array<double, 2> sums{0, static_cast<double>(bodies.owned)};
  for (Index b = 0; b < bodies.owned; ++b) sums[0] += bodies.radius[b];
  comm.sum(sums);
  const double mean = sums[0] / sums[1];
  std::array<double, 2> most{};
  for (Index b = 0; b < bodies.owned; ++b) {
    const double r = bodies.radius[b];
    most[0] = std::max(most[0], r);
    if (r <= few * mean) most[1] = std::max(most[1], r);
  }
  comm.max(most);
  return {most[0], most[1]};
}

/// Makes pairs and ghosts current for forces at the present positions.
void update_pairs(World& world, Penalty& engine, const ByPair<PenaltyLaw>& laws) {
  StageTimer timer(world.stages, "neighbours");
  Members& members = engine.members;
  if (!world.shapes.empty() && members.bodies.size() == 0)
    members = members_of(world);
  else if (!world.shapes.empty())
    follow_bodies(world, members);
  Bodies& bodies = meeting(world, members);
  TouchPairs& touch = engine.touch;
  touch.cut = world.cut;
  if (touch.skin > 0 && touch.moved > touch.skin)
    touch.moved = approach_from(world, bodies, touch.found_at);
  if (touch.skin > 0 && touch.moved <= touch.skin) {
    ++touch.steps;
    touch.ghosts.gather({{flat(bodies.position), 3},
                         {flat(bodies.velocity), 3},
                         {flat(bodies.angular_velocity), 3}});
    if (world.period.any())
      for (Index g = 0; g < touch.ghosts.ghosts(); ++g)
        bodies.position[bodies.owned + g] += touch.shifts[g];
    return;
  }
  const Radii radii = radii_of(world.comm, bodies);
  const Crowd crowd = crowd_of(world.comm, bodies, radii.ordinary);
  const double gap = widest_gap(laws, radii.largest);
  const SkinRange skins{.length = crowd.diameter,
                        .first = 0.1,
                        .least = 0.02,
                        .step = 0.02,
                        .most = 1,
                        .search = 150};
  let_go(engine.loads);  // a search needs the memory
  wrap_bodies(world);
  search_touch_pairs(world,
                     {.gap = gap,
                      .skin = best_skin(world.comm, bodies, touch, crowd, gap, skins),
                      .rolling = resists_rolling(laws),
                      .members = members_a_body(world.shapes)},
                     members, touch);
  engine.loads.assign(bodies.size(), ForceRow{});
}

/// These rows of clumps turn on for `t` (s), eight at once; lanes that are left hold one again.
void turn_clumps(const BodyShapes& shapes, Bodies& bodies, std::span<const Index> rows, double t) {
  SplitTurn<Lanes> turn;
  Triple<Lanes> inertia;
  for (std::size_t l = 0; l < lane_count; ++l) {
    const Index b = rows[std::min(l, rows.size() - 1)];
    const Vec3& principal = shape_of(shapes, bodies, b).inertia;
    for (int k = 0; k < 3; ++k) inertia[k][l] = principal[k];
    for (int k = 0; k < 3; ++k) turn.spin[k][l] = bodies.angular_velocity[b][k];
    for (int k = 0; k < 4; ++k) turn.orientation[k][l] = bodies.orientation[b].coeffs()[k];
  }
  turn = split_turn(inertia, turn, t);
  for (std::size_t l = 0; l < rows.size(); ++l) {
    for (int k = 0; k < 3; ++k) bodies.angular_velocity[rows[l]][k] = turn.spin[k][l];
    for (int k = 0; k < 4; ++k) bodies.orientation[rows[l]].coeffs()[k] = turn.orientation[k][l];
  }
}

/// All bodies of a world with shapes turn on for `t` (s): spheres and held bodies as they spin,
/// clumps by their own angular momentum.
void turn_bodies(World& world, double t) {
  Bodies& bodies = world.bodies;
  std::array<Index, lane_count> clumps;
  std::size_t count = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.shape[b] == 0 || is_held(bodies, b))
      bodies.orientation[b] = turned_by(t * bodies.angular_velocity[b], bodies.orientation[b]);
    else
      clumps[count++] = b;
    if (count < clumps.size()) continue;
    turn_clumps(world.shapes, bodies, clumps, t);
    count = 0;
  }
  if (count > 0) turn_clumps(world.shapes, bodies, {clumps.data(), count}, t);
}

/// Forces at the present positions, the kick by them over `h`, and drifts over two times, of which
/// the second may be none.
RowBox kick_and_drift(World& world, Penalty& engine, const ByPair<PenaltyLaw>& laws, double h,
                      double first, double second) {
  StageTimer timer(world.stages, "forces");
  Bodies& bodies = world.bodies;
  const bool clumps = !world.shapes.empty();
  const Vec3 fall = h * world.steady_gravity();
  RowBox box;
  double taken = 0;
  const auto finish = [&](Index b, ForceRow& row) {
    const double scale = h / bodies.mass[b], r = bodies.radius[b];
    const Vec3 torque(row.torque[0], row.torque[1], row.torque[2]);
    if (is_held(bodies, b))
      book_held(world, b, bodies.position[b], h * Vec3(row.force[0], row.force[1], row.force[2]),
                h * torque);
    bodies.velocity[b] += scale * Vec3(row.force[0], row.force[1], row.force[2]);
    if (scale > 0) bodies.velocity[b] += fall;
    if (clumps && bodies.shape[b] != 0)
      bodies.angular_velocity[b] +=
          scale / (r * r) * (inverse_inertia_factor(world.shapes, bodies, b) * torque);
    else
      bodies.angular_velocity[b] += scale / (sphere_inertia * r * r) * torque;
    bodies.position[b] += first * bodies.velocity[b];
    if (second != 0) bodies.position[b] += second * bodies.velocity[b];
    if (clumps)
      box.add(bodies.velocity[b], turning_speed(world.shapes, bodies, b));
    else
      box.add(bodies.velocity[b]);
    bodies.heat[b] += h * row.force[3];
    taken += h * row.force[3];
    row = ForceRow{};
  };
  Bodies& met = meeting(world, engine.members);
  ForceRow* const rows = engine.loads.data();
  with_contact_model(laws, h, [&](const auto& model) {
    TouchPairs& touch = engine.touch;
    const double at_walls =
        sweep_walls(met, world.walls(), model, h, touch.walls, rows, world.reactions.of_walls);
    const double of_pairs = sweep_contacts(met, model, touch.gap, touch.windows, touch.equal,
                                           touch.springs, rows, [&](Index b) {
                                             if (!clumps) finish(b, rows[b]);
                                           });
    engine.overlap = std::max({engine.overlap, at_walls, of_pairs});
  });
  if (clumps) {
    add_up_loads(world, engine.loads, engine.members);
    for (Index b = 0; b < bodies.owned; ++b) finish(b, engine.members.loads[b]);
    turn_bodies(world, first);
    if (second != 0) turn_bodies(world, second);
  }
  world.ledger.dissipated += taken;
  return box;
}

}  // namespace

/// J on this rank, with pairs and ghosts as they are.
SPALL_KERNEL(double, energy_of_contacts,
             (const Bodies& met, const Walls& walls, const ByPair<PenaltyLaw>& laws,
              const TouchPairs& touch),
             (met, walls, laws, touch)) {
  return with_contact_model(laws, 1, [&](const auto& model) {
    return wall_energy(met, walls, model, touch.walls) +
           sweep_contact_energy(met, model, touch.gap, touch.windows, touch.springs);
  });
}

namespace {

/// What `smooth_steps` asks of forces.
class Motion {
 public:
  Motion(World& world, Penalty& engine)
      : world_(world),
        engine_(engine),
        laws_(penalty_laws(world, engine.settings)),
        searches_(engine.touch.searches) {}

  void begin(double h) {
    h_ = h;
    velocities_ = velocities_with_walls(world_);
  }
  void drift(double t) {
    Bodies& bodies = world_.bodies;
    for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] += t * bodies.velocity[b];
    if (!world_.shapes.empty()) turn_bodies(world_, t);
    move(t);
  }
  double energy() {
    update_pairs(world_, engine_, laws_);
    return energy_of_contacts(meeting(world_, engine_.members), world_.walls(), laws_,
                              engine_.touch);
  }
  void kick(double h, double first, double second) {
    kick_by_own_forces(world_, h);
    set_prescribed_velocities(world_, world_.time - h_ / 2, h_);
    update_pairs(world_, engine_, laws_);
    velocities_ = kick_and_drift(world_, engine_, laws_, h, first, second);
    StageTimer timer(world_.stages, "motion");
    if (world_.walls().size() > 0) velocities_.add(Vec3(Vec3::Zero()));
    move(first + second);
    if (std::exchange(searches_, engine_.touch.searches) != engine_.touch.searches)
      check_penalty_step(world_, engine_.settings, h_, largest_meeting_speed(world_, h_),
                         "bodies have become faster");
  }
  void end() {}

 private:
  /// Others have moved by `t`: bodies of moving groups go where they must.
  void move(double t) {
    for (const auto& [row, position] : advance_prescribed(world_, t, velocities_))
      world_.bodies.position[row] = position;
    book_motion(world_.comm, velocities_, t, engine_.touch);
  }

  World& world_;
  Penalty& engine_;
  ByPair<PenaltyLaw> laws_;
  std::int64_t searches_;  // after which the step was found short enough
  double h_ = 0;
  RowBox velocities_;
};

/// Pairs as bodies are now. They are found anew, in a copy with ghosts of its own, so that no body
/// changes its rank.
struct Found {
  World world;
  ByPair<PenaltyLaw> laws;
  Members members;
  TouchPairs touch;

  Found(const World& from, const Penalty& engine)
      : world(from), laws(penalty_laws(from, engine.settings)) {
    resize(world.bodies, world.bodies.owned);
    if (!world.shapes.empty()) members = members_of(world);
    Bodies& met = meeting(world, members);
    find_touch_pairs(world.comm, met, world.walls(), world.period,
                     {.gap = widest_gap(laws, radii_of(world.comm, met).largest),
                      .skin = 0,
                      .rolling = resists_rolling(laws),
                      .members = members_a_body(world.shapes)},
                     by_members(spall::remember(from, engine.members, engine.touch, false),
                                members_a_body(world.shapes)),
                     touch);
  }
};

}  // namespace

SPALL_KERNEL(StepReport, penalty_steps,
             (World & world, Penalty& engine, const StepRequest& request),
             (world, engine, request)) {
  require(world.bodies.has(Field::angular_velocity) && world.bodies.has(Field::heat),
          "steps of penalty contact need fields that the bodies were made without");
  return smooth_steps(world, Motion(world, engine), engine.integrator, request);
}

double contact_energy(World& world, Penalty& engine) {
  const ByPair<PenaltyLaw> laws = penalty_laws(world, engine.settings);
  if (engine.touch.skin > 0 && widest_gap(laws, 0) > engine.touch.gap) engine.touch.skin = 0;
  update_pairs(world, engine, laws);
  return world.comm.sum(
      energy_of_contacts(meeting(world, engine.members), world.walls(), laws, engine.touch));
}

void Penalty::check_steps(const World& world, const PlannedSteps& steps) const {
  const double largest = radii_of(world.comm, world.bodies).largest;
  check_period(world.period, 2 * largest + widest_gap(penalty_laws(world, settings), largest),
               steps.place);
  check_penalty_step(world, settings, steps.h, largest_meeting_speed(world, steps.lasts),
                     steps.place);
}

StepReport Penalty::advance(World& world, const StepRequest& request) {
  overlap = 0;
  StepReport report = penalty_steps(world, *this, request);
  report.overlap = overlap;
  report.contacts = count_touching(meeting(world, members), touch);
  return report;
}

double Penalty::energy(const World& world) const {
  const Found found(world, *this);
  return world.comm.sum(energy_of_contacts(meeting(found.world, found.members), found.world.walls(),
                                           found.laws, found.touch));
}

PairMemory Penalty::remember(const World& world) const {
  return {.contacts = spall::remember(world, members, touch, false), .bonds = {}};
}

void Penalty::restart_pairs(World& world, PairMemory memory) {
  resize(world.bodies, world.bodies.owned);
  members = {};
  touch = {};
  touch.carried = std::move(memory.contacts);
}

Index Penalty::ghosts(const World& world) const {
  const Bodies& rows = meeting(world, members);
  return rows.size() - rows.owned;
}

std::optional<FoundPairs> Penalty::found_pairs(const World& world) const {
  if (touch.skin == 0) return {};
  const Index rows = meeting(world, members).owned;
  FoundPairs found{.search = &touch,
                   .reach = std::vector<double>(rows, (touch.gap + touch.skin) / 2),
                   .work = work_of_bodies(world, members, touch),
                   .pairs = links_of(touch.windows)};
  if (world.shapes.empty()) return found;
  found.members = &members.bodies;
  found.whole = members.whole;
  found.bodies_at = members.found_at;
  return found;
}

LinkedBodies Penalty::links(const World& world) const {
  const ByPair<PenaltyLaw> laws = penalty_laws(world, settings);
  const double largest = radii_of(world.comm, world.bodies).largest;
  const double gap = widest_gap(laws, largest);
  LinkedBodies linked{world.bodies, {}, {}};
  Bodies& bodies = linked.bodies;
  resize(bodies, bodies.owned);
  Search search;
  std::vector<double> reach(bodies.owned, gap / 2);
  find_ghosts(world.comm, bodies, world.period, reach, search);
  std::vector<NearWindow> windows;
  find_near_pairs(bodies, {.common = gap / 2}, Grouping::by_partners, windows);
  for_each_pair(windows, [&](std::size_t, std::size_t, std::size_t, Index i, Index j) {
    const PenaltyLaw& law = laws(bodies.material[i], bodies.material[j]);
    if (gap_between(world.shapes, bodies, i, j) > widest_gap(law, largest)) return;
    linked.links.i.push_back(i);
    linked.links.j.push_back(j);
  });
  linked.ghosts = std::move(search.ghosts);
  return linked;
}

}  // namespace spall
