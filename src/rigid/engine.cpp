// What is asked of resting and moving contacts between steps.
// SPDX-License-Identifier: BSD-3-Clause
#include "rigid/engine.hpp"

#include <algorithm>

#include "domain/halo.hpp"
#include "rigid/narrow_phase.hpp"
#include "rigid/step.hpp"

namespace spall {
double energy_of_bonds(const World& world, const Contacts& contacts) {
  double energy = 0;
  for (Index c = 0; c < contacts.size(); ++c) {
    if (contacts.i[c] >= world.bodies.owned) continue;
    energy += energy_of_bond(law_of(world, contacts, c), contacts.gap[c]);
  }
  return energy;
}

StepReport Rigid::advance(World& world, const StepRequest& request) {
  return nonsmooth_step(world, *this, request);
}

SolverReport Rigid::close_kick(World& world, double h) {
  return close_nonsmooth_kick(world, *this, h);
}

namespace {

/// Contacts and pairs within the range of cohesion as bodies are now. They are found anew, in a
/// copy with ghosts of its own, so that no body changes its rank.
struct Found {
  World world;
  Ghosts ghosts;
  Contacts contacts;

  explicit Found(const World& from) : world(from) {
    Bodies& bodies = world.bodies;
    resize(bodies, bodies.owned);
    // Gaps up to `near_contact` of the smaller radius are contacts, too.
    std::vector<double> reach(bodies.owned);
    for (Index b = 0; b < bodies.owned; ++b)
      reach[b] = std::max(near_contact * bodies.radius[b], longest_range(world.contact) / 2);
    ghosts = make_halo(world.comm, bodies, reach);
    contacts = find_contacts(bodies, world.shapes, world.planes,
                             find_pairs(bodies, reach, world.planes), 0, world.contact);
  }
};

}  // namespace

double Rigid::energy(const World& world) const {
  if (longest_range(world.contact) == 0) return 0;
  const Found found(world);
  return world.comm.sum(energy_of_bonds(found.world, found.contacts));
}

PairMemory Rigid::remember(const World& world) const {
  return {.contacts = spall::remember(world.bodies, neighbours, false), .bonds = {}};
}

void Rigid::restart_pairs(World& world, PairMemory memory) {
  resize(world.bodies, world.bodies.owned);
  neighbours = {};
  neighbours.carried = std::move(memory.contacts);
}

std::optional<FoundPairs> Rigid::found_pairs(const World& world) const {
  if (!neighbours.valid) return {};
  const Bodies& bodies = world.bodies;
  const Pairs& pairs = neighbours.pairs;
  FoundPairs found{.search = &neighbours,
                   .reach = neighbours.reach,
                   .work = work_of(bodies, pairs),
                   .pairs = {}};
  found.reach.resize(bodies.owned);
  for (Index p = 0; p < pairs.size(); ++p) {
    if (pairs.j[p] == ground) continue;
    found.pairs.i.push_back(pairs.i[p]);
    found.pairs.j.push_back(pairs.j[p]);
  }
  return found;
}

LinkedBodies Rigid::links(const World& world) const {
  Found found(world);
  LinkedBodies linked{std::move(found.world.bodies), std::move(found.ghosts), {}};
  const Contacts& contacts = found.contacts;
  for (Index c = 0; c < contacts.size(); ++c) {
    if (contacts.j[c] == ground) continue;
    // Several spheres of a pair may touch: their contacts follow each other.
    if (c > 0 && contacts.pair[c] == contacts.pair[c - 1]) continue;
    linked.links.i.push_back(contacts.i[c]);
    linked.links.j.push_back(contacts.j[c]);
  }
  return linked;
}

}  // namespace spall
