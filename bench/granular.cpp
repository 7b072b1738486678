// A dense random packing in penalty contact that LAMMPS runs beside it (run_granular.sh).
// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "penalty/sweep.hpp"
#include "smooth_rate.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

/// The material of bench/granular/lammps.in.
PenaltySettings settings_of(const std::string& model) {
  PenaltySettings s;
  if (model == "jkr") s.adhesion = Adhesion::jkr;
  if (model == "dmt") s.adhesion = Adhesion::dmt;
  s.adhesion_strength = s.adhesion == Adhesion::none ? 0 : 2 * 1000;
  return s;
}

/// To the line after the one that begins with `name`.
void skip_to(std::ifstream& in, const std::string& name) {
  for (std::string line; std::getline(in, line);)
    if (line.rfind(name, 0) == 0) return;
  throw Error("no section " + name);
}

/// Reads bodies and box of LAMMPS's data file; each rank keeps a contiguous share.
void read_data(const Comm& comm, const std::string& path, Lab& world) {
  std::ifstream in(path);
  require(in.good(), "{}: cannot be read", path);
  std::int64_t all = 0;
  std::string line;
  while (std::getline(in, line) && line.rfind("Atoms", 0) != 0) {
    std::istringstream words(line);
    double low, high;
    std::string first, second;
    if (line.find("atoms") != line.npos) words >> all;
    for (int k = 0; k < 3; ++k)
      if (line.find(std::string(1, "xyz"[k]) + "lo") != line.npos) {
        words >> low >> high;
        world.period.low[k] = low;
        world.period.size[k] = high - low;
      }
  }
  const BodyId begin = all * comm.rank / comm.size, end = all * (comm.rank + 1) / comm.size;
  Bodies& bodies = world.bodies;
  bodies.fields = {Field::angular_velocity, Field::heat};
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(end - begin); });
  for (std::int64_t k = 0; k < all; ++k) {
    double id, type, diameter, density, x, y, z;
    in >> id >> type >> diameter >> density >> x >> y >> z;
    if (k < begin || k >= end) continue;
    const Index b = append_row(bodies);
    bodies.id[b] = static_cast<BodyId>(id) - 1;
    bodies.radius[b] = diameter / 2;
    bodies.mass[b] = density * pi / 6 * diameter * diameter * diameter;
    bodies.position[b] = {x, y, z};
  }
  bodies.owned = bodies.size();
  skip_to(in, "Velocities");
  for (std::int64_t k = 0; k < all; ++k) {
    double id, v[3], w[3];
    in >> id >> v[0] >> v[1] >> v[2] >> w[0] >> w[1] >> w[2];
    if (k < begin || k >= end) continue;
    bodies.velocity[k - begin] = {v[0], v[1], v[2]};
    bodies.angular_velocity[k - begin] = {w[0], w[1], w[2]};
  }
}

/// LAMMPS damps by Tsuji's polynomial of e in units of sqrt(m F/delta) = sqrt(2/3 m S), and along
/// the contact as much as across.
PenaltyLaw law_of_lammps(const Lab& world) {
  PenaltyLaw law = penalty_laws(world, world.penalty.settings).common();
  const double e = world.contact.common().restitution;
  const double tsuji =
      1.2728 +
      e * (-4.2783 + e * (11.087 + e * (-22.348 + e * (27.467 + e * (-18.022 + e * 4.8218)))));
  law.damping = std::sqrt(2 / 3.0) * tsuji;
  law.tangential_damping = 1;
  return law;
}

/// Largest differences of forces and torques from those of LAMMPS's dump, whose velocities are half
/// a step ahead of those that its forces saw; springs are one step old.
void compare_forces(const Comm& comm, const std::string& dump, double h, Lab& world) {
  require(comm.size == 1, "forces are compared on one rank");
  Bodies& bodies = world.bodies;
  std::vector<Vec3> force(bodies.owned), torque(bodies.owned);
  std::ifstream in(dump);
  skip_to(in, "ITEM: ATOMS");
  for (Index k = 0; k < bodies.owned; ++k) {
    double id;
    Vec3 row[4];
    in >> id;
    for (Vec3& v : row) in >> v[0] >> v[1] >> v[2];
    bodies.position[k] = row[0];
    force[k] = row[2];
    torque[k] = row[3];
    bodies.velocity[k] = row[1] - h / 2 / bodies.mass[k] * force[k];
    bodies.angular_velocity[k].setZero();
  }
  require(in.good(), "{}: ends too soon", dump);
  const PenaltyLaw law = law_of_lammps(world);
  search_touch_pairs(world, {.gap = widest_gap(law, 0.5), .skin = 0.1}, world.penalty.members,
                     world.penalty.touch);
  std::vector<ForceRow> rows(bodies.size());
  double worst = 0, worst_torque = 0, largest = 0, largest_torque = 0;
  const auto compare = [&](const auto& model) {
    sweep_contacts(bodies, model, world.penalty.touch.gap, world.penalty.touch.windows,
                   world.penalty.touch.equal, world.penalty.touch.springs, rows.data(),
                   [&](Index b) {
                     const auto difference = [](const RowHalf& a, const Vec3& v) {
                       return (Vec3(a[0], a[1], a[2]) - v).norm();
                     };
                     const BodyId id = bodies.id[b];
                     worst = std::max(worst, difference(rows[b].force, force[id]));
                     worst_torque = std::max(worst_torque, difference(rows[b].torque, torque[id]));
                     largest = std::max(largest, force[id].norm());
                     largest_torque = std::max(largest_torque, torque[id].norm());
                   });
  };
  // Of the kernels' many models those of bench/granular alone.
  with_adhesion(law.adhesion, [&]<template <class> class Law>() {
    compare(ContactModel<true, false, Law, double>(law, false, h));
  });
  fmt::print("forces {:.3g} of {:.4g} N, torques {:.3g} of {:.4g} N m\n", worst / largest, largest,
             worst_torque / largest_torque, largest_torque);
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    require(argc == 5 || argc == 6,
            "usage: bench_granular data hertz|dmt|jkr steps repetitions [step], or forces dump");
    const double h = argc == 6 ? std::atof(argv[5]) : 1e-3;  // s
    Lab world;
    world.comm = comm;
    world.contact = ContactLaw{.friction = 0.5, .restitution = 0.5};
    world.materials = {{.name = "grain", .youngs_modulus = 1e8, .poisson_ratio = 0.25}};
    world.penalty.settings = settings_of(argv[2]);
    const double program = peak_bytes();
    read_data(comm, argv[1], world);
    if (argv[3] == std::string("forces")) {
      compare_forces(comm, argv[4], h, world);
      return 0;
    }
    const int steps = std::atoi(argv[3]), repetitions = std::atoi(argv[4]);
    penalty_steps(world, h, 10);
    measure_rate(world, world.penalty.touch, steps, repetitions, program,
                 [&](int count) { penalty_steps(world, h, count); });
    const double count = comm.sum(static_cast<double>(world.bodies.owned));
    const double contacts =
        2 * comm.sum(static_cast<double>(count_touching(world.bodies, world.penalty.touch))) /
        count;
    double kinetic = 0;
    for (Index b = 0; b < world.bodies.owned; ++b)
      kinetic += world.bodies.mass[b] / 2 * world.bodies.velocity[b].squaredNorm();
    kinetic = comm.sum(kinetic);
    if (comm.rank == 0) fmt::print("Z {:.4g} kinetic {:.6g}\n", contacts, kinetic);
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
