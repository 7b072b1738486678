// Drift h/2, forces, kick h, drift h/2; where nothing is asked for in between, the drifts of two
// steps, each rounded as if alone, follow on the kick while the body is in the cache.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/motion/penalty_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "spall/base/require.hpp"
#include "spall/force/penalty_walls.hpp"
#include "spall/motion/gravity_kick.hpp"

namespace spall {
namespace {

/// The box that holds some vectors; the origin too, where walls stand still.
struct Box {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  void add(const Vec3& v) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  /// Of the boxes of all ranks. Collective.
  Box united(const Comm& comm) const {
    std::array<double, 6> ends{-low[0], -low[1], -low[2], high[0], high[1], high[2]};
    comm.max(ends);
    return {-Vec3(ends[0], ends[1], ends[2]), Vec3(ends[3], ends[4], ends[5])};
  }
  Vec3 centre() const { return (low + high) / 2; }
  double diagonal() const { return (high - low).norm(); }
};

/// Of all bodies, and of what stands still where there are walls.
Box velocities_of(const World& world) {
  Box box;
  if (world.walls().size() > 0) box.add(Vec3::Zero());
  for (Index b = 0; b < world.bodies.owned; ++b) box.add(world.bodies.velocity[b]);
  return box;
}

/// Bodies have flown at these velocities for `h`: no two came nearer by more than the diagonal.
void book_motion(const Comm& comm, const Box& velocities, double h, TouchPairs& touch) {
  touch.moved += h * velocities.united(comm).diagonal();
  require(std::isfinite(touch.moved), "velocities are no longer finite: the step is too long");
}

/// m, that two bodies, or a body and a wall, have come nearer at most since the pairs were found.
double displacement(const World& world) {
  const Bodies& bodies = world.bodies;
  const auto moved = [&](Index b) -> Vec3 { return bodies.position[b] - world.touch.found_at[b]; };
  Box box;
  for (Index b = 0; b < bodies.owned; ++b) box.add(moved(b));
  const Vec3 centre = box.united(world.comm).centre();
  double furthest = 0, from_walls = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    furthest = std::max(furthest, (moved(b) - centre).squaredNorm());
    if (world.walls().size() > 0) from_walls = std::max(from_walls, moved(b).squaredNorm());
  }
  return std::sqrt(world.comm.max(std::max(4 * furthest, from_walls)));
}

/// m, beyond the reach of forces, up to which pairs are listed: that for which a step costs least
/// if bodies move on as since the last search. A sweep costs as much as there are pairs, range^3; a
/// search, shared by the steps until the skin is used up, as much as `search` pairs a body.
/// Counted, not timed, so that a run gives the same bits again.
double best_skin(const World& world, double diameter) {
  constexpr double search = 60, first = 0.1, least = 0.02, most = 1;  // skins: of the diameter
  const TouchPairs& touch = world.touch;
  if (touch.skin == 0) return first * diameter;
  const double bodies = world.comm.sum(static_cast<double>(world.bodies.owned));
  const double motion = touch.moved / (touch.steps + 1);  // a step
  const double reach = diameter + touch.gap;
  const double density = touch.pairs / bodies / std::pow(reach + touch.skin, 3);
  const auto cost = [&](double skin) {
    return density * std::pow(reach + skin, 3) + search * motion / skin;
  };
  double best = least * diameter;
  for (double skin = best; skin <= most * diameter; skin += 0.02 * diameter)
    if (cost(skin) < cost(best)) best = skin;
  return best;
}

/// Makes pairs and ghosts current for forces at the present positions.
void update_pairs(World& world, const PenaltyLaw& law) {
  StageTimer timer(world.times, "neighbours");
  Bodies& bodies = world.bodies;
  TouchPairs& touch = world.touch;
  double largest = 0;
  if (touch.skin > 0 && touch.moved > touch.skin) touch.moved = displacement(world);
  if (touch.skin > 0 && touch.moved <= touch.skin) {
    ++touch.steps;
    for (auto* field : {&bodies.position, &bodies.velocity, &bodies.angular_velocity})
      touch.ghosts.gather_begin(flat(*field), 3);
    for (auto* field : {&bodies.position, &bodies.velocity, &bodies.angular_velocity})
      touch.ghosts.gather_end(flat(*field), 3);
    if (world.period.any())
      for (Index g = 0; g < touch.ghosts.ghosts(); ++g)
        bodies.position[bodies.owned + g] += touch.shifts[g];
    return;
  }
  for (Index b = 0; b < bodies.owned; ++b) largest = std::max(largest, bodies.radius[b]);
  largest = world.comm.max(largest);
  world.loads = {};  // a search needs the memory
  search_touch_pairs(world.comm, bodies, world.walls(), world.period,
                     {.gap = widest_gap(law, largest),
                      .skin = best_skin(world, 2 * largest),
                      .rolling = law.rolling_friction > 0},
                     touch);
  world.loads.assign(bodies.size(), ForceRow{});
}

/// Forces at the present positions, the kick by them over `h`, and `drifts` drifts over h/2.
Box kick_and_drift(World& world, const PenaltyLaw& law, double h, int drifts) {
  StageTimer timer(world.times, "forces");
  Bodies& bodies = world.bodies;
  ForceRow* const rows = world.loads.data();
  Box box;
  double taken = 0;
  const auto finish = [&](Index b) {
    ForceRow& row = rows[b];
    const double scale = h / bodies.mass[b], r = bodies.radius[b];
    const double turn = scale / (0.4 * r * r);
    bodies.velocity[b] += scale * Vec3(row.force[0], row.force[1], row.force[2]);
    bodies.angular_velocity[b] += turn * Vec3(row.torque[0], row.torque[1], row.torque[2]);
    for (int k = 0; k < drifts; ++k) bodies.position[b] += h / 2 * bodies.velocity[b];
    box.add(bodies.velocity[b]);
    bodies.heat[b] += h * row.force[3];
    taken += h * row.force[3];
    row = ForceRow{};
  };
  with_contact_model(law, h, [&](const auto& model) {
    sweep_walls(bodies, world.walls(), model, world.touch.walls, rows);
    const TouchPairs& touch = world.touch;
    if (touch.equal)
      sweep_contacts<true>(bodies, model, touch.gap, touch.windows, world.touch.springs, rows,
                           finish);
    else
      sweep_contacts<false>(bodies, model, touch.gap, touch.windows, world.touch.springs, rows,
                            finish);
  });
  // Nobody reads a ghost's force, but its row belongs to another body after the next search.
  world.ledger.dissipated += taken;
  return box;
}

}  // namespace

SmoothReport penalty_steps(World& world, double h, int most_steps) {
  Bodies& bodies = world.bodies;
  const SmoothReport report = begin_smooth_steps(world, h, most_steps);

  const PenaltyLaw law = penalty_law(world.penalty, world.law);
  Box velocities = velocities_of(world);
  book_motion(world.comm, velocities, h / 2, world.touch);
  for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] += h / 2 * bodies.velocity[b];
  for (int step = 1; step <= report.steps; ++step) {
    const auto searches = world.touch.searches;
    update_pairs(world, law);
    const int drifts = step < report.steps ? 2 : 1;
    velocities = kick_and_drift(world, law, h, drifts);
    if (world.walls().size() > 0) velocities.add(Vec3::Zero());
    book_motion(world.comm, velocities, drifts * h / 2, world.touch);
    if (world.touch.searches != searches)
      check_penalty_step(world.comm, bodies, world.penalty, world.law, h,
                         velocities.united(world.comm).diagonal(), "bodies have become faster");
  }
  end_smooth_steps(world, report.steps);
  return report;
}

double contact_energy(World& world) {
  const PenaltyLaw law = penalty_law(world.penalty, world.law);
  if (world.touch.skin > 0 && widest_gap(law, 0) > world.touch.gap) world.touch.skin = 0;
  update_pairs(world, law);
  return world.comm.sum(with_contact_model(law, 1, [&](const auto& model) {
    const TouchPairs& touch = world.touch;
    return wall_energy(world.bodies, world.walls(), model, touch.walls) +
           sweep_contact_energy(world.bodies, model, touch.gap, touch.windows, touch.springs);
  }));
}

}  // namespace spall
