// Drift h/2, forces, kick h, drift h/2; where nothing is asked for in between, the drifts of two
// steps, each rounded as if alone, follow on the kick while the body is in the cache.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/motion/penalty_step.hpp"

#include <algorithm>
#include <cmath>

#include "flight.hpp"
#include "spall/base/require.hpp"
#include "spall/force/penalty_walls.hpp"
#include "spall/motion/gravity_kick.hpp"

namespace spall {
namespace {

/// Of all bodies, and of what stands still where there are walls.
Box velocities_with_walls(const World& world) {
  Box box = velocities_of(world.bodies);
  if (world.walls().size() > 0) box.add(Vec3(Vec3::Zero()));
  return box;
}

/// m, that two bodies have come nearer at most since the pairs were found: twice the radius of the
/// displacements about the centre of their box. A common motion counts for nothing, but to walls.
/// (Not place by place, as pair potentials have it: images and giants meet from afar.)
double displacement(const World& world) {
  const auto& found_at = world.touch.found_at;
  const auto moved = [&](std::size_t b) -> Vec3 { return world.bodies.position[b] - found_at[b]; };
  Box box;
  for (std::size_t b = 0; b < found_at.size(); ++b) box.add(moved(b));
  const Vec3 centre = box.united(world.comm).centre();
  double furthest = 0;
  for (std::size_t b = 0; b < found_at.size(); ++b) {
    furthest = std::max(furthest, 4 * (moved(b) - centre).squaredNorm());
    if (world.walls().size() > 0) furthest = std::max(furthest, moved(b).squaredNorm());
  }
  return std::sqrt(world.comm.max(furthest));
}

/// m: of all bodies, and of those that are searched by their size: not more than a few times as
/// large as the mean. Collective.
struct Radii {
  double largest = 0, ordinary = 0;
};
Radii radii_of(const World& world) {
  constexpr double few = 4;
  const Bodies& bodies = world.bodies;
  double sum = 0;
  for (Index b = 0; b < bodies.owned; ++b) sum += bodies.radius[b];
  const double mean = world.comm.sum(sum) / world.comm.sum(static_cast<double>(bodies.owned));
  Radii radii;
  for (Index b = 0; b < bodies.owned; ++b) {
    const double r = bodies.radius[b];
    radii.largest = std::max(radii.largest, r);
    if (r <= few * mean) radii.ordinary = std::max(radii.ordinary, r);
  }
  return {world.comm.max(radii.largest), world.comm.max(radii.ordinary)};
}

/// Makes pairs and ghosts current for forces at the present positions.
void update_pairs(World& world, const PenaltyLaw& law) {
  StageTimer timer(world.times, "neighbours");
  Bodies& bodies = world.bodies;
  TouchPairs& touch = world.touch;
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
  const Radii radii = radii_of(world);
  const SkinRange skins{.length = 2 * radii.ordinary,
                        .first = 0.1,
                        .least = 0.02,
                        .step = 0.02,
                        .most = 1,
                        .search = 60};
  world.loads = std::vector<ForceRow>();  // a search needs the memory
  search_touch_pairs(world.comm, bodies, world.walls(), world.period,
                     {.gap = widest_gap(law, radii.largest),
                      .skin = best_skin(world.comm, bodies, touch, skins),
                      .ordinary = radii.ordinary,
                      .rolling = law.friction > 0 && law.rolling_friction > 0},
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
  require(bodies.has.angular_velocity && bodies.has.heat,
          "steps of penalty contact need fields that the bodies were made without");
  const SmoothReport report = begin_smooth_steps(world, h, most_steps);

  const PenaltyLaw law = penalty_law(world.penalty, world.law);
  Box velocities = velocities_with_walls(world);
  book_motion(world.comm, velocities, h / 2, world.touch);
  for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] += h / 2 * bodies.velocity[b];
  for (int step = 1; step <= report.steps; ++step) {
    const auto searches = world.touch.searches;
    update_pairs(world, law);
    const int drifts = step < report.steps ? 2 : 1;
    velocities = kick_and_drift(world, law, h, drifts);
    if (world.walls().size() > 0) velocities.add(Vec3(Vec3::Zero()));
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

double largest_relative_speed(const World& world) {
  return velocities_of(world.bodies).united(world.comm).diagonal();
}

}  // namespace spall
