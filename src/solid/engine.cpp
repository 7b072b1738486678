// The engine of solids but for its steps.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/engine.hpp"

#include <algorithm>
#include <cmath>

#include "engine/prescribed.hpp"
#include "solid/bodies_step.hpp"
#include "solid/part_lengths.hpp"
#include "solid/piece_pairs.hpp"
#include "solid/step.hpp"
#include "spall/error.hpp"

namespace spall {

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
    find_near_pairs(world.comm, world.bodies, world.period, reach_of_pieces(world), 0, {}, {},
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
  rests = {};
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
