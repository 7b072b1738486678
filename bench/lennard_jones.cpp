// The impact of a Lennard-Jones solid on a plate that LAMMPS runs beside it (run_lennard_jones.sh).
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/os.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "smooth_rate.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

constexpr double well = 1.122462048;     // 2^(1/6) sigma: all in units of sigma, epsilon and m
constexpr double width = 174.5 * well;   // of the plate, 17 layers of bodies thick
constexpr double speed = 10, h = 0.002;  // of the ball, 40 sigma across

/// Calls `place(x, velocity)` for the bodies of the plate and the ball, on one fcc lattice of
/// density 1.
template <class Place>
void place_bodies(double scale, Place&& place) {
  const double half = std::cbrt(4.0) / 2, edge = scale * width;
  const int n = static_cast<int>(edge / half) + 1, low = static_cast<int>(-17 * well / half);
  for (int k = low; k * half < 42; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = (j + k) & 1; i < n; i += 2) {
        const Vec3 x(i * half, j * half, k * half);
        const bool ball = (x - Vec3(edge / 2, edge / 2, 21.5)).norm() < 20;
        if (x.x() < edge - 0.01 && x.y() < edge - 0.01 && (ball || x.z() < -0.01))
          place(x, ball ? -speed : 0.0);
      }
}

Bodies make_impact(const Comm& comm, double scale) {
  std::int64_t all = 0;
  place_bodies(scale, [&](const Vec3&, double) { ++all; });
  const BodyId first = all * comm.rank / comm.size, end = all * (comm.rank + 1) / comm.size;
  Bodies bodies;
  bodies.fields = {};
  bodies.owned = static_cast<Index>(end - first);
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(bodies.owned); });
  resize(bodies, bodies.owned);
  BodyId id = 0;
  place_bodies(scale, [&](const Vec3& x, double v) {
    if (id >= first && id < end) {
      const auto b = static_cast<Index>(id - first);
      bodies.id[b] = id;
      bodies.radius[b] = well / 2;
      bodies.mass[b] = 1;
      bodies.position[b] = x;
      bodies.velocity[b] = {0, 0, v};
    }
    ++id;
  });
  return bodies;
}

/// For LAMMPS's read_data.
void write_data(const std::string& path, double scale) {
  std::int64_t all = 0;
  place_bodies(scale, [&](const Vec3&, double) { ++all; });
  auto file = fmt::output_file(path);
  const double edge = scale * width;
  file.print(
      "the start of bench_lennard_jones\n\n{} atoms\n1 atom types\n{} {} xlo xhi\n{} {} ylo "
      "yhi\n-60 60 zlo zhi\n\nMasses\n\n1 1.0\n\nAtoms\n\n",
      all, -2.0, edge + 2, -2.0, edge + 2);
  std::int64_t id = 0;
  place_bodies(
      scale, [&](const Vec3& x, double) { file.print("{} 1 {} {} {}\n", ++id, x[0], x[1], x[2]); });
  file.print("\nVelocities\n\n");
  id = 0;
  place_bodies(scale, [&](const Vec3&, double v) { file.print("{} 0 0 {}\n", ++id, v); });
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    require(argc >= 4,
            "usage: bench_lennard_jones cutoff steps repetitions [scale [data file to write]]");
    const double cutoff = std::atof(argv[1]), scale = argc > 4 ? std::atof(argv[4]) : 1;
    const int steps = std::atoi(argv[2]), repetitions = std::atoi(argv[3]);
    if (argc > 5) {
      if (comm.rank == 0) write_data(argv[5], scale);
      return 0;
    }
    const double program = peak_bytes();
    Lab world;
    world.comm = comm;
    world.potential.law =
        PairPotential{.depth = 1, .distance = std::exp2(1.0 / 6), .cutoff = cutoff};
    world.bodies = make_impact(comm, scale);
    potential_steps(world, h, 60);
    measure_rate(world, world.potential.near, steps, repetitions, program,
                 [&](int count) { potential_steps(world, h, count); });
    const double count = comm.sum(static_cast<double>(world.bodies.owned));
    const double energy = potential_energy(world);
    double kinetic = 0;
    for (Index b = 0; b < world.bodies.owned; ++b)
      kinetic += world.bodies.velocity[b].squaredNorm() / 2;
    kinetic = comm.sum(kinetic);
    if (comm.rank == 0)
      fmt::print("potential {:.12g} kinetic {:.12g}\n", energy / count, kinetic / count);
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
