// What more ranks bring, scene by scene: seconds a contact and product, a step, or an evaluation.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "scenes.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

/// MB of all ranks, at their largest so far; Linux keeps it.
double peak_memory(const Comm& comm) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return comm.sum(std::stod(line.substr(6)) / 1000);
  return 0;
}

void print(const Comm& comm, const std::string& scene, std::int64_t bodies, std::int64_t contacts,
           double seconds, const std::string& unit, const std::string& error) {
  const double memory = peak_memory(comm);
  if (comm.rank == 0)
    fmt::print("{},{},{},{},{:.5g},{},{},{:.0f}\n", scene, comm.size, bodies, contacts, seconds,
               unit, error, memory);
  std::fflush(stdout);
}

std::int64_t count_bodies(const Comm& comm, const Bodies& bodies) {
  return comm.sum(static_cast<std::int64_t>(bodies.owned));
}

/// Seconds a product of the accelerated method, from solves of as many as `products`.
void measure_products(const Comm& comm, const std::string& name, const BenchScene& scene,
                      int products) {
  const State state = prepare(comm, scene);
  std::vector<double> seconds;
  std::int64_t contacts = 0;
  double residual = 0;
  for (int repeat = 0; repeat < 5; ++repeat) {
    Lab world = state.world(comm, false);
    const StepReport report =
        nonsmooth_step(world, scene.step,
                       {.tolerance = 1e-12, .max_products = products, .prox = scene.warm_prox}, 1);
    contacts = comm.sum(report.contacts);
    seconds.push_back(report.solver.seconds / report.solver.products);
    residual = report.solver.residual_prox;
  }
  print(comm, name, count_bodies(comm, state.bodies), contacts, median(seconds), "product",
        fmt::format("E_eps {:.1e}", residual));
}

/// Seconds a whole step of frictionless contacts at 50 iterations, the first ones left out.
void measure_plate(const Comm& comm, int across) {
  const BenchScene scene = plate(17, across, 0, true);
  const Case read = parse_case(scene.text, scene.name, {});
  Lab world = make_world(comm, read);
  world.bodies = make_bodies(read, comm);
  std::vector<double> seconds;
  StepReport report;
  std::int64_t contacts = 0;
  for (int step = 0; step < 12; ++step) {
    check_mpi(MPI_Barrier(comm.raw), "MPI_Barrier");
    const double start = MPI_Wtime();
    report = nonsmooth_step(world, scene.step, {.tolerance = 1e-4, .max_iterations = 50}, 1);
    if (step >= 3) seconds.push_back(comm.max(MPI_Wtime() - start));
    contacts = comm.sum(report.contacts);
  }
  print(comm, "thesis's plate: solving", count_bodies(comm, world.bodies), contacts,
        comm.max(world.stages["solver"].seconds) / 12, "step of 50 iterations", "");
  print(comm, "thesis's plate", count_bodies(comm, world.bodies), contacts, median(seconds),
        "step of 50 iterations",
        fmt::format("max {:.2g} % of the speed", 100 * report.solver.residual_max / 6700));
}

void measure_gravity(const Comm& comm, std::int64_t count) {
  // Equal masses all over a ball, each rank's an equal part of it; slow, as in a settled pile.
  std::mt19937_64 random(static_cast<std::uint64_t>(comm.rank) + 1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const auto in_ball = [&] {
    Vec3 x;
    do x = Vec3(uniform(random), uniform(random), uniform(random));
    while (x.squaredNorm() > 1);
    return x;
  };
  const auto own = static_cast<std::size_t>(part_begin(count, comm.rank + 1, comm.size) -
                                            part_begin(count, comm.rank, comm.size));
  const std::vector<double> mass(own, 1e5);
  std::vector<Vec3> position, velocity;
  for (std::size_t b = 0; b < own; ++b) {
    position.push_back(100 * in_ball());
    velocity.push_back(1e-4 * in_ball());
  }
  const GravitySettings gravity{.method = GravityMethod::tree};
  std::vector<double> seconds;
  for (int repeat = 0; repeat < 5; ++repeat) {
    check_mpi(MPI_Barrier(comm.raw), "MPI_Barrier");
    const double start = MPI_Wtime();
    evaluate_gravity(comm, gravity, mass, position, velocity);
    seconds.push_back(comm.max(MPI_Wtime() - start));
  }
  print(comm, "gravity", count, 0, median(seconds), "evaluation",
        fmt::format("rms asked {:.0e}", gravity.accuracy));
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const Comm comm = session.world();
  try {
    require(argc == 2, "usage: bench_scaling lattice|nucleus|plate|gravity");
    const std::string which = argv[1];
    if (which == "lattice") {
      BenchScene scene = plate(47, 47, 0.3, false);
      scene.most_steps = 3;
      measure_products(comm, "lattice", scene, 60);
    } else if (which == "nucleus") {
      measure_products(comm, "nucleus", nucleus(12428), 200);
    } else if (which == "plate") {
      measure_plate(comm, 60);
      measure_plate(comm, 204);
    } else if (which == "gravity") {
      measure_gravity(comm, 10307);
      measure_gravity(comm, 100000);
      measure_gravity(comm, 1000000);
    } else {
      throw Error(which + ": there is no such scene");
    }
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
