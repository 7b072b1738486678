// Drift h/2, forces, kick h, drift h/2; where nothing is asked for in between, the drifts of two
// steps, each rounded as if alone, follow on the kick while the body is in the cache.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/motion/potential_step.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "spall/base/require.hpp"
#include "spall/force/pair_laws.hpp"
#include "spall/motion/gravity_kick.hpp"

namespace spall {
namespace {

RowHalf half_row(const Vec3& v, double w) {
  return RowHalf{v[0], v[1], v[2], w};
}
Vec3 vector_of(const RowHalf& half) {
  return {half[0], half[1], half[2]};
}

void drift(PairRow& row, const RowHalf& velocity, double h) {
  row.place += h * RowHalf{velocity[0], velocity[1], velocity[2], 0};
}

/// The box that holds some vectors.
struct Box {
  RowHalf low = RowHalf{} + infinity, high = RowHalf{} - infinity;
  void add(const RowHalf& v) {
    low = v < low ? v : low;
    high = v > high ? v : high;
  }
  void add(const Vec3& v) { add(half_row(v, 0)); }
  /// Of the boxes of all ranks. Collective.
  Box united(const Comm& comm) const {
    std::array<double, 6> ends{-low[0], -low[1], -low[2], high[0], high[1], high[2]};
    comm.max(ends);
    Box all;
    all.low = RowHalf{-ends[0], -ends[1], -ends[2], 0};
    all.high = RowHalf{ends[3], ends[4], ends[5], 0};
    return all;
  }
  Vec3 centre() const { return vector_of((low + high) / 2); }
  double diagonal() const { return vector_of(high - low).norm(); }
};

Box velocities_of(const Bodies& bodies) {
  Box box;
  for (Index b = 0; b < bodies.owned; ++b) box.add(bodies.velocity[b]);
  return box;
}

/// Bodies have flown at these velocities for `h`: no two came nearer by more than the diagonal.
void book_motion(const Comm& comm, const Box& velocities, double h, NearPairs& near) {
  near.moved += h * velocities.united(comm).diagonal();
  require(std::isfinite(near.moved), "velocities are no longer finite: the step is too long");
}

/// m, that two bodies have come nearer at most since the pairs were found: twice the radius of the
/// displacements about the centre of their box. A common motion counts for nothing.
double displacement(const Comm& comm, const std::vector<PairRow>& rows,
                    const std::vector<Vec3>& found_at) {
  Box box;
  const auto moved = [&](std::size_t b) { return rows[b].place - half_row(found_at[b], 0); };
  for (std::size_t b = 0; b < found_at.size(); ++b) box.add(moved(b));
  const Vec3 centre = box.united(comm).centre();
  double furthest = 0;
  for (std::size_t b = 0; b < found_at.size(); ++b)
    furthest = std::max(furthest, (vector_of(moved(b)) - centre).squaredNorm());
  return 2 * std::sqrt(comm.max(furthest));
}

void fill_rows(World& world) {
  const Bodies& bodies = world.bodies;
  world.rows.resize(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b)
    world.rows[b] = {half_row(bodies.position[b], 1 / bodies.mass[b]), RowHalf{}};
  if (world.potential.damping == 0) return;
  world.ahead.resize(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b)
    world.ahead[b] = bodies.velocity[b] + bodies.kick[b] / 2;
}

void take_rows(World& world) {
  Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) bodies.position[b] = vector_of(world.rows[b].place);
  if (world.potential.damping == 0) return;
  for (Index b = 0; b < bodies.owned; ++b)
    bodies.kick[b] = 2 * (world.ahead[b] - bodies.velocity[b]);
}

/// m, beyond the cut-off, up to which pairs are listed: that for which a step costs least if the
/// bodies move on as since the last search. A sweep costs as much as there are pairs, range^3; a
/// search, shared by the steps until the skin is used up, as much as `search` pairs a body.
/// Counted, not timed, so that a run gives the same bits again.
double best_skin(const World& world) {
  constexpr double search = 120, first = 0.3, least = 0.1, most = 1.5;  // skins: of the distance
  const NearPairs& near = world.near;
  const double d = world.potential.distance, cutoff = world.potential.cutoff;
  if (near.range == 0) return first * d;
  const double bodies = world.comm.sum(static_cast<double>(world.bodies.owned));
  const double motion = near.moved / (near.steps + 1);  // a step
  const double density = near.pairs / bodies / std::pow(near.range, 3);
  const auto cost = [&](double skin) {
    return density * std::pow(cutoff + skin, 3) + search * motion / skin;
  };
  double best = least * d;
  for (double skin = best; skin <= most * d; skin += 0.05 * d)
    if (cost(skin) < cost(best)) best = skin;
  return best;
}

/// Makes pairs and ghosts current for forces at the present positions.
void update_pairs(World& world, bool velocities) {
  StageTimer timer(world.times, "neighbours");
  NearPairs& near = world.near;
  const double skin = near.range - world.potential.cutoff;
  if (near.range > 0 && near.moved > skin)
    near.moved = displacement(world.comm, world.rows, near.found_at);
  if (near.range == 0 || near.moved > skin) {
    const double range = world.potential.cutoff + best_skin(world);
    take_rows(world);
    search_near_pairs(world.comm, world.bodies, range, near);
    fill_rows(world);
    return;
  }
  ++near.steps;
  // Forces are zero between sweeps, and so those of ghosts become zero again.
  double* const rows = reinterpret_cast<double*>(world.rows.data());
  near.ghosts.gather_begin(rows, doubles_a_row);
  if (velocities) near.ghosts.gather(flat(world.ahead), 3);
  near.ghosts.gather_end(rows, doubles_a_row);
}

PairDamping damping_of(const World& world) {
  const PairPotential& p = world.potential;
  if (p.damping == 0) return {};
  double lightest = infinity;
  for (Index b = 0; b < world.bodies.owned; ++b)
    lightest = std::min(lightest, world.bodies.mass[b]);
  return {p.distance, p.damping * std::sqrt(2 * stiffness(p) * world.comm.min(lightest))};
}

/// Forces at the present positions, the kick by them over `h`, and `drifts` drifts over h/2.
Box kick_and_drift(World& world, const PairDamping& damping, double h, int drifts) {
  StageTimer timer(world.times, "forces");
  PairRow* const rows = world.rows.data();
  Vec3* const velocity = world.bodies.velocity.data();
  Vec3* const ahead = world.ahead.data();
  double* const heat = world.bodies.heat.data();
  Box box;
  double taken = 0;
  const auto finish = [&, damped = damping.c > 0](Index b) {
    PairRow& row = rows[b];
    const RowHalf kick = (h * row.place[3]) * row.force;
    const RowHalf v = half_row(velocity[b], 0) + kick;
    velocity[b] = vector_of(v);
    for (int k = 0; k < drifts; ++k) drift(row, v, h / 2);
    box.add(v);
    if (damped) {
      ahead[b] = vector_of(v + 0.5 * kick);
      heat[b] += h * row.force[3];
      taken += h * row.force[3];
    }
    row.force = RowHalf{};
  };
  with_law(world.potential, [&](const auto& law) {
    const double* v = damping.c > 0 ? ahead->data() : velocity->data();
    const auto& windows = world.near.windows;
    const double cutoff = world.potential.cutoff;
    if (damping.c > 0)
      sweep_pairs<true>(windows, law, cutoff, damping, v, rows, finish);
    else
      sweep_pairs<false>(windows, law, cutoff, damping, v, rows, finish);
  });
  world.ledger.dissipated += taken;
  return box;
}

}  // namespace

SmoothReport potential_steps(World& world, double h, int most_steps) {
  Bodies& bodies = world.bodies;
  const SmoothReport report = begin_smooth_steps(world, h, most_steps);

  const PairDamping damping = damping_of(world);
  book_motion(world.comm, velocities_of(bodies), h / 2, world.near);
  fill_rows(world);
  for (Index b = 0; b < bodies.owned; ++b)
    drift(world.rows[b], half_row(bodies.velocity[b], 0), h / 2);
  for (int step = 1; step <= report.steps; ++step) {
    update_pairs(world, damping.c > 0);
    const int drifts = step < report.steps ? 2 : 1;
    const Box velocities = kick_and_drift(world, damping, h, drifts);
    book_motion(world.comm, velocities, drifts * h / 2, world.near);
  }
  take_rows(world);
  end_smooth_steps(world, report.steps);
  return report;
}

double potential_energy(World& world) {
  fill_rows(world);
  update_pairs(world, false);
  return world.comm.sum(with_law(world.potential, [&](const auto& law) {
    return sweep_energy(world.near.windows, law, world.potential.cutoff, world.rows.data(),
                        world.bodies.owned);
  }));
}

void for_each_near_pair(World& world, double distance, const std::function<void(Index, Index)>& f) {
  fill_rows(world);
  update_pairs(world, false);
  for (const NearWindow& window : world.near.windows) {
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = &window.rows[g * lane_count];
      for (Index s = 0; s < window.slots[g]; ++s, partners += lane_count)
        for (std::size_t l = 0; l < lane_count; ++l) {
          const Index i = own[l] / doubles_a_row, j = partners[l] / doubles_a_row;
          if (i == j) continue;
          const RowHalf x = world.rows[j].place - world.rows[i].place;
          if (vector_of(x).norm() < distance) f(i, j);
        }
    }
  }
}

double largest_relative_speed(const World& world) {
  return velocities_of(world.bodies).united(world.comm).diagonal();
}

}  // namespace spall
