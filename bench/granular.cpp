// A dense random packing in penalty contact that LAMMPS runs beside it (run_granular.sh).
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <sys/resource.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "spall/base/require.hpp"
#include "spall/domain/pack.hpp"
#include "spall/motion/penalty_step.hpp"

namespace {

using namespace spall;

/// The material of bench/granular.in. LAMMPS damps by Tsuji's polynomial of e, with sqrt(m F/delta)
/// = sqrt(2/3 m S) for a unit; its tangential damping is the normal one.
PenaltySettings settings_of(const std::string& model) {
  PenaltySettings s{.young_modulus = 1e8, .poisson_ratio = 0.25};
  if (model == "jkr") s.adhesion = Adhesion::jkr;
  if (model == "dmt") s.adhesion = Adhesion::dmt;
  s.work_of_adhesion = s.adhesion == Adhesion::none ? 0 : 2 * 1000;
  return s;
}

/// Rows of 7 numbers of the section `name` of LAMMPS's file, as it stands there.
void skip_to(std::ifstream& in, const std::string& name) {
  for (std::string line; std::getline(in, line);)
    if (line.rfind(name, 0) == 0) return;
  throw Error("no section " + name);
}

/// Reads bodies and box of LAMMPS's data file; each rank keeps a contiguous share.
void read_data(const Comm& comm, const std::string& path, World& world) {
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
  for_each_field(bodies, [&](const char*, auto& field) { field.reserve(end - begin); });
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

double processor_seconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

double peak_bytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

}  // namespace

int main(int argc, char** argv) {
  Session session(argc, argv);
  const Comm comm = session.world();
  try {
    require(argc == 5, "usage: bench_granular data hertz|dmt|jkr steps repetitions");
    const int steps = std::atoi(argv[3]), repetitions = std::atoi(argv[4]);
    constexpr double h = 1e-3;
    World world;
    world.comm = comm;
    world.law = {.friction = 0.5, .restitution = 0.5};
    world.penalty = settings_of(argv[2]);
    const double program = peak_bytes();
    read_data(comm, argv[1], world);
    const auto count = comm.sum(static_cast<double>(world.bodies.owned));
    penalty_steps(world, h, 10);
    for (int r = 0; r < repetitions; ++r) {
      world.times = {};
      const auto searches = world.touch.searches;
      MPI_Barrier(comm.raw);
      const double begin = MPI_Wtime(), worked = processor_seconds();
      penalty_steps(world, h, steps);
      const double seconds = comm.max(MPI_Wtime() - begin);
      const double busy = comm.max(processor_seconds() - worked);
      double slots = 0;
      for (const NearWindow& window : world.touch.windows)
        slots += static_cast<double>(window.partners.size());
      slots = comm.sum(slots);
      const double contacts =
          2 * static_cast<double>(comm.sum(count_touching(world.bodies, world.touch))) / count;
      double kinetic = 0;
      for (Index b = 0; b < world.bodies.owned; ++b)
        kinetic += world.bodies.mass[b] / 2 * world.bodies.velocity[b].squaredNorm();
      kinetic = comm.sum(kinetic);
      const double bytes = comm.sum(peak_bytes()), before = comm.sum(program);
      if (comm.rank == 0)
        fmt::print(
            "bodies {} ranks {} Msteps/s {:.4g} by cpu {:.4g} searches {} neighbours_s {:.3g} "
            "forces_s {:.3g} partners {:.3g} Z {:.4g} kinetic {:.6g} bytes {:.4g} of the program "
            "{:.4g}\n",
            count, comm.size, 1e-6 * count * steps / seconds, 1e-6 * count * steps / busy,
            world.touch.searches - searches, world.times["neighbours"], world.times["forces"],
            slots / count, contacts, kinetic, bytes / count, before / count);
    }
  } catch (const std::exception& error) {
    fmt::print(stderr, "{}\n", error.what());
    Session::abort_all(1);
  }
}
