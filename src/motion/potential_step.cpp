// Drift h/2, forces, kick h, drift h/2; where nothing is asked for in between, the drifts of two
// steps, each rounded as if alone, follow on the kick while the body is in the cache.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/motion/potential_step.hpp"

#include <algorithm>
#include <cmath>

#ifdef __FMA__
#include <immintrin.h>
#endif

#include "flight.hpp"
#include "spall/base/require.hpp"
#include "spall/force/pair_laws.hpp"
#include "spall/motion/gravity_kick.hpp"

namespace spall {
namespace {

/// Rounded once, whatever stands around it: a compiler may fuse a product and a sum or not.
void drift(PairRow& row, const RowHalf& velocity, double h) {
  const RowHalf v{velocity[0], velocity[1], velocity[2], 0};
#ifdef __FMA__
  row.place = _mm256_fmadd_pd(RowHalf{} + h, v, row.place);
#else
  row.place += h * v;
#endif
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

/// m, up to which two bodies may act on each other.
double reach_of(const PairPotential& p) {
  return p.embedding.bulk_modulus > 0 ? std::max(p.cutoff, crowding_reach * p.distance) : p.cutoff;
}

/// Makes pairs and ghosts current for forces at the present positions.
void update_pairs(World& world, bool velocities) {
  StageTimer timer(world.times, "neighbours");
  NearPairs& near = world.near;
  if (near.skin > 0 && near.moved > near.skin) {
    std::vector<Vec3> displacement(near.found_at.size());
    for (std::size_t b = 0; b < displacement.size(); ++b)
      displacement[b] = vector_of(world.rows[b].place) - near.found_at[b];
    near.moved = near.cells.approach(world.comm, near.reach + near.skin, displacement);
  }
  if (near.skin == 0 || near.moved > near.skin) {
    const PairPotential& p = world.potential;
    const SkinRange skins{.length = world.potential.distance,
                          .first = 0.3,
                          .least = 0.1,
                          .step = 0.05,
                          .most = 1.5,
                          .search = 120};
    const double skin = best_skin(world.comm, world.bodies, near, skins);
    take_rows(world);
    search_near_pairs(world.comm, world.bodies, reach_of(p), skin,
                      p.breaking_strain > 0 ? p.cutoff : 0, near);
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
  require(world.bodies.has.heat && world.bodies.has.kick,
          "damping needs fields that the bodies were made without");
  double lightest = infinity;
  for (Index b = 0; b < world.bodies.owned; ++b)
    lightest = std::min(lightest, world.bodies.mass[b]);
  return {p.distance, p.damping * std::sqrt(2 * stiffness(p) * world.comm.min(lightest))};
}

/// The crowding of the owned bodies at the present positions.
void measure_crowding(World& world, const EmbeddingLaw& law) {
  world.crowding.assign(world.bodies.size(), 0.0);
  sweep_crowding(world.near.windows, law.weight(), world.rows.data(), world.crowding.data());
}

/// What bodies press with at the present positions; ghosts learn it from their ranks.
void update_pushes(World& world, const EmbeddingLaw& law) {
  StageTimer timer(world.times, "forces");
  measure_crowding(world, law);
  const Bodies& bodies = world.bodies;
  world.pushes.resize(bodies.size());
  const bool damped = world.potential.damping > 0;  // or heat's work would not be booked
  for (Index b = 0; b < bodies.owned; ++b) {
    const double volume = law.volume(bodies.mass[b]);
    const double heat = damped ? bodies.heat[b] / volume : 0;
    const auto [all, hot] = law.push(world.crowding[b], heat);
    world.pushes[b] = {volume * all, volume * hot};
  }
  world.near.ghosts.gather(reinterpret_cast<double*>(world.pushes.data()), doubles_a_push);
}

/// Forces at the present positions, the kick by them over `h`, and `drifts` drifts over h/2.
Box kick_and_drift(World& world, const PairDamping& damping, const PairEmbedding& embedding,
                   double h, int drifts) {
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
    auto& windows = world.near.windows;
    const double cutoff = world.potential.cutoff;
    const auto sweep = [&]<bool damped, bool embedded>() {
      sweep_pairs<damped, embedded>(windows, law, cutoff, damping, embedding, v, rows, finish);
    };
    if (embedding.pushes)
      damping.c > 0 ? sweep.template operator()<true, true>()
                    : sweep.template operator()<false, true>();
    else
      damping.c > 0 ? sweep.template operator()<true, false>()
                    : sweep.template operator()<false, false>();
  });
  world.ledger.dissipated += taken;
  return box;
}

}  // namespace

SmoothReport potential_steps(World& world, double h, int most_steps) {
  Bodies& bodies = world.bodies;
  const SmoothReport report = begin_smooth_steps(world, h, most_steps);

  const PairDamping damping = damping_of(world);
  std::optional<EmbeddingLaw> law;
  if (world.potential.embedding.bulk_modulus > 0) law.emplace(world.potential);
  book_motion(world.comm, velocities_of(bodies), h / 2, world.near);
  fill_rows(world);
  for (Index b = 0; b < bodies.owned; ++b)
    drift(world.rows[b], half_row(bodies.velocity[b], 0), h / 2);
  for (int step = 1; step <= report.steps; ++step) {
    update_pairs(world, damping.c > 0);
    if (law) update_pushes(world, *law);
    const int drifts = step < report.steps ? 2 : 1;
    const PairEmbedding embedding{CrowdingWeight(crowding_reach * world.potential.distance),
                                  law ? world.pushes.data() : nullptr};
    const Box velocities = kick_and_drift(world, damping, embedding, h, drifts);
    book_motion(world.comm, velocities, drifts * h / 2, world.near);
  }
  take_rows(world);
  end_smooth_steps(world, report.steps);
  return report;
}

double potential_energy(World& world) {
  fill_rows(world);
  update_pairs(world, false);
  double energy = with_law(world.potential, [&](const auto& law) {
    return sweep_energy(world.near.windows, law, world.potential.cutoff, world.rows.data(),
                        world.bodies.owned);
  });
  if (world.potential.embedding.bulk_modulus > 0) {
    const EmbeddingLaw law(world.potential);
    measure_crowding(world, law);
    for (Index b = 0; b < world.bodies.owned; ++b)
      energy += law.volume(world.bodies.mass[b]) * law.energy(world.crowding[b]);
  }
  return world.comm.sum(energy);
}

void for_each_near_pair(World& world, double distance,
                        const std::function<void(Index, Index, bool)>& f) {
  fill_rows(world);
  update_pairs(world, false);
  const auto& windows = world.near.windows;
  for_each_pair(windows, [&](std::size_t w, std::size_t slot, std::size_t l, Index i, Index j) {
    const RowHalf x = world.rows[j].place - world.rows[i].place;
    if (vector_of(x).norm() < distance)
      f(i, j, !world.near.bonds_break || windows[w].bound[slot] >> l & 1);
  });
}

double closing_speed(const World& world) {
  const Bodies& bodies = world.bodies;
  const auto owned = [&](const std::vector<Vec3>& field) {
    return std::span(field.data(), bodies.owned);
  };
  const MotionCells cells(world.comm, owned(bodies.position),
                          motion_cell * reach_of(world.potential));
  return cells.closing_speed(world.comm, owned(bodies.position), owned(bodies.velocity));
}

}  // namespace spall
