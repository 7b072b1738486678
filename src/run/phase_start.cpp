// Sums before and after, with gravity evaluated both times.
// SPDX-License-Identifier: BSD-3-Clause
#include "phase_start.hpp"

#include <utility>

#include "methods.hpp"
#include "spall/domain/pack.hpp"
#include "spall/motion/gravity_kick.hpp"
#include "spall/motion/penalty_step.hpp"

namespace spall {

std::optional<Aim> change_bodies(World& world, const Case& scene, const Phase& phase,
                                 Account& account, Verdict& verdict) {
  evaluate_field(world);
  const Diagnostics before = diagnose(world);
  const double potential_before = world.kick.potential;
  std::optional<Bonds> bonds = bonds_of(world.bodies, world.near);
  resize(world.bodies, world.bodies.owned);
  ContactMemory memory = contact_memory(world, phase.method);
  if (phase.remove_drift) {
    const Vec3 velocity = before.momentum / before.mass;
    for (Index b = 0; b < world.bodies.owned; ++b) {
      world.bodies.position[b] -= before.centre;
      world.bodies.velocity[b] -= velocity;
    }
  }
  std::optional<Aim> aim;
  if (phase.impactor) {
    verdict.look_at_pile(world);
    const auto id =
        static_cast<BodyId>(world.comm.sum(static_cast<std::int64_t>(world.bodies.owned)));
    aim = add_impactor(world.comm, scene, *phase.impactor, world.bodies);
    verdict.impactor_added(world, id, world.law.restitution);
  }
  forget_pairs(world, std::move(bonds));
  carried_memory(world, phase.method) = std::move(memory);
  world.kick.interval = 0;
  world.kick.evaluated = false;
  evaluate_field(world);
  account.book_event(before, potential_before, diagnose(world), world.kick.potential);
  return aim;
}

void book_springs(World& world, Method method, Method former, double cohesion_before,
                  double energy_before, Account& account) {
  const auto energy_at = [&](double cohesion) {
    const double kept = std::exchange(world.law.cohesion, cohesion);
    const double energy = contact_energy(world);
    world.law.cohesion = kept;
    return energy;
  };
  const double without = energy_at(0);
  if (method != Method::penalty)
    account.book_energy(-without);
  else
    account.book_energy(
        energy_at(world.law.cohesion) -
        (former == Method::penalty ? energy_before : energy_at(cohesion_before) - without));
}

}  // namespace spall
