// Small worlds for tests: a handful of spheres in, the same spheres out on every rank.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "lab.hpp"

namespace spall {

struct Sphere {
  double radius = 1;  ///< m
  double mass = 1;    ///< kg
  Vec3 position = Vec3::Zero();
  Vec3 velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();
};

/// Sphere k is body k; each rank gets a contiguous share, which may be none.
inline Lab make_world(const Comm& comm, const std::vector<Sphere>& spheres, const ContactLaw& law) {
  Lab world;
  world.comm = comm;
  world.contact = law;
  const auto all = static_cast<BodyId>(spheres.size());
  const BodyId first = all * comm.rank / comm.size, end = all * (comm.rank + 1) / comm.size;
  Bodies& bodies = world.bodies;
  bodies.owned = static_cast<Index>(end - first);
  resize(bodies, bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b) {
    const Sphere& sphere = spheres[first + b];
    bodies.id[b] = first + b;
    bodies.group[b] = bodies.material[b] = 0;
    bodies.radius[b] = sphere.radius;
    bodies.mass[b] = sphere.mass;
    bodies.position[b] = sphere.position;
    bodies.velocity[b] = sphere.velocity;
    bodies.angular_velocity[b] = sphere.spin;
    bodies.acceleration[b].setZero();
    bodies.kick[b].setZero();
  }
  return world;
}

/// All spheres by id, on every rank. Collective.
inline std::vector<Sphere> spheres_of(const Lab& world) {
  const Bodies& bodies = world.bodies;
  std::vector<double> rows;
  for (Index b = 0; b < bodies.owned; ++b) {
    rows.insert(rows.end(), {static_cast<double>(bodies.id[b]), bodies.radius[b], bodies.mass[b]});
    for (const Vec3* v : {&bodies.position[b], &bodies.velocity[b], &bodies.angular_velocity[b]})
      rows.insert(rows.end(), v->data(), v->data() + 3);
  }
  constexpr std::size_t width = 12;
  const std::vector<double> all = world.comm.all_gather(rows);
  std::vector<Sphere> spheres(all.size() / width);
  for (std::size_t k = 0; k < all.size(); k += width) {
    const double* row = &all[k];
    spheres[static_cast<std::size_t>(row[0])] = {row[1], row[2], Vec3(row[3], row[4], row[5]),
                                                 Vec3(row[6], row[7], row[8]),
                                                 Vec3(row[9], row[10], row[11])};
  }
  return spheres;
}

/// Beyond what any test asks: what is left in its tolerance is then the step's own error.
inline SolverSettings solved_exactly() {
  return {.tolerance = 1e-10, .max_iterations = 20000, .prox = 0};
}

/// `steps` steps of `h`, with gravity's field evaluated in each.
inline void advance(Lab& world, double h, int steps,
                    const SolverSettings& solver = solved_exactly()) {
  for (int k = 0; k < steps; ++k) nonsmooth_step(world, h, solver, 1);
}

}  // namespace spall
