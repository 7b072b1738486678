// Waves, and who meets whom how fast; what strides cost.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/part_lengths.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace spall {

PartBounds part_bounds(const World& world, const Elastoplastic& engine) {
  std::array<double, 2> most{0, -infinity};
  for (Index b = 0; b < world.bodies.owned; ++b) {
    most[0] = std::max(most[0], engine.laws[world.bodies.material[b]].slope);
    most[1] = std::max(most[1], -2 * world.bodies.radius[b]);
  }
  world.comm.max(most);
  return {most[0], -most[1], (neighbour_reach - 1) * -most[1]};
}

void find_waves(const World& world, Elastoplastic& engine, std::span<const Index> which) {
  const Bodies& bodies = world.bodies;
  const bool porous = bodies.has(Field::crushed);
  for (const Index b : which) {
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
    engine.waves[b] = c / spacing;
  }
}

namespace {

/// Calls `f(body, v/R)` (1/s) for owned bodies nearer than their reach to another piece or a wall.
template <class F>
void for_each_meeting(const World& world, const Elastoplastic& engine, F&& f) {
  const Bodies& bodies = world.bodies;
  for (const PieceContact& c : engine.contacts.pieces) {
    const MotionRow &i = engine.rows[c.i], &j = engine.rows[c.j];
    const double a = engine.reach[c.i], b = engine.reach[c.j], mean = (a + b) / 2;
    if (vector_of(j.place - i.place).squaredNorm() >= mean * mean) continue;
    const double rate = vector_of(j.motion - i.motion).norm() / std::min(a, b);
    for (const Index row : {c.i, c.j})
      if (row < bodies.owned) f(row, rate);
  }
  const Walls walls = world.walls();
  for (std::size_t w = 0; w < walls.size(); ++w)
    for (Index b = 0; b < bodies.owned; ++b) {
      const Face face = face_of(walls, w, vector_of(engine.rows[b].place));
      if (face.height + bodies.radius[b] < engine.reach[b])
        f(b, std::abs(face.normal.dot(bodies.velocity[b])) / engine.reach[b]);
    }
}

}  // namespace

double fastest_meeting(const World& world, const Elastoplastic& engine) {
  double fastest = std::sqrt(engine.fastest_pair2);
  for_each_meeting(world, engine, [&](Index, double rate) { fastest = std::max(fastest, rate); });
  return fastest;
}

double longest_part(const Elastoplastic& engine, const PartBounds& bounds, double waves,
                    double meeting) {
  return engine.courant / (waves + share_of_impacts * bounds.slope * neighbour_reach * meeting);
}

std::vector<double> longest_parts(const World& world, const Elastoplastic& engine,
                                  const PartBounds& bounds, std::vector<double> meeting2) {
  for_each_meeting(world, engine,
                   [&](Index b, double rate) { meeting2[b] = std::max(meeting2[b], rate * rate); });
  std::vector<double> limit(world.bodies.owned, infinity);
  for (const auto* bodies : {&engine.strides.brisk, &engine.strides.slow})
    for (const Index b : *bodies)
      limit[b] = longest_part(engine, bounds, engine.waves[b], std::sqrt(meeting2[b]));
  return limit;
}

Stride cheapest_stride(const Comm& comm, const std::vector<double>& limit, double part,
                       double most) {
  // Of a part in which all act: the one that begins a stride, which finds also who meets whom and
  // sweeps slow bodies by themselves; to move all in the others. Where less is saved than a sixth,
  // it is not worth the error of slow bodies.
  constexpr double begins = 1.4, moves = 0.1, worth = 5.0 / 6;
  constexpr int longest = 8;
  std::array<double, longest + 1> brisk{};  // by the parts of a stride; first all
  for (const double its : limit) {
    if (its < infinity) ++brisk[0];
    for (int parts = longest; parts > 1 && its < parts * part; --parts) ++brisk[parts];
  }
  comm.sum(brisk);
  Stride best;
  if (brisk[0] == 0) return best;
  double least = worth;
  for (int parts = 2; parts <= std::min<double>(most, longest); ++parts) {
    const double share = brisk[parts] / brisk[0];
    const double cost = (begins + (parts - 1) * (share + moves)) / parts;
    if (cost >= least) continue;
    least = cost;
    // A pair is swept if one of its two is brisk.
    best = {parts, std::min(1.0, (1 + (parts - 1) * 2 * share) / parts)};
  }
  return best;
}

}  // namespace spall
