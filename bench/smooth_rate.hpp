// Measures steps of smooth forces and prints what scripts compare: speed, time of stages, memory.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>
#include <sys/resource.h>

#include "lab.hpp"

namespace spall {

/// s that this rank's processor has worked: on a machine that others use too, wall time says less.
inline double processor_seconds() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_utime.tv_sec) +
         1e-6 * static_cast<double>(usage.ru_utime.tv_usec);
}

inline double peak_bytes() {
  rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * static_cast<double>(usage.ru_maxrss);
}

/// Prints a line a repetition; `make_steps(count)` steps the world, whose pairs are `near`;
/// `program` are the bytes before there were bodies. Collective.
template <class MakeSteps>
void measure_rate(Lab& world, const NearPairs& near, int steps, int repetitions, double program,
                  MakeSteps&& make_steps) {
  const Comm& comm = world.comm;
  const double count = comm.sum(static_cast<double>(world.bodies.owned));
  for (int r = 0; r < repetitions; ++r) {
    world.stages = {};
    const auto searches = near.searches;
    MPI_Barrier(comm.raw);
    const double begin = MPI_Wtime(), worked = processor_seconds();
    make_steps(steps);
    const double seconds = comm.max(MPI_Wtime() - begin);
    const double busy = comm.max(processor_seconds() - worked);
    double slots = 0;
    for (const NearWindow& window : near.windows)
      slots += static_cast<double>(window.partners.size());
    slots = comm.sum(slots);
    const double bytes = comm.sum(peak_bytes()), before = comm.sum(program);
    if (comm.rank == 0)
      fmt::print(
          "bodies {} ranks {} Msteps/s {:.4g} by cpu {:.4g} searches {} neighbours_s {:.3g} "
          "forces_s {:.3g} partners {:.3g} bytes {:.4g} of the program {:.4g}\n",
          count, comm.size, 1e-6 * count * steps / seconds, 1e-6 * count * steps / busy,
          near.searches - searches, world.stages["neighbours"].seconds,
          world.stages["forces"].seconds, slots / count, bytes / count, before / count);
  }
}

}  // namespace spall
