// Plates of two metals that meet: the state between them beside hand calculation.
// SPDX-License-Identifier: BSD-3-Clause
#include "plate_impact.hpp"

#include <fmt/format.h>

#include <cstdlib>

#include "spall/error.hpp"

int main(int argc, char** argv) {
  using namespace spall;
  Session session;
  const Comm comm = session.world();
  try {
    require(argc == 7, "usage: bench_plate_impact MATERIALS FLYER TARGET SPEED SEED LENGTH");
    const PlateImpact impact{.flyer = argv[2],
                             .target = argv[3],
                             .speed = std::atof(argv[4]),
                             .seed = std::atoi(argv[5]),
                             .length = std::atof(argv[6])};
    const auto [measured, by_hand] = plate_impact(comm, impact, argv[1]);
    if (comm.rank == 0)
      fmt::print("{},{},{:g},{},{:g},{:.1f},{:.1f},{:.4g},{:.4g}\n", impact.flyer, impact.target,
                 impact.speed, impact.seed, impact.length, measured.velocity, by_hand.velocity,
                 measured.pressure, by_hand.pressure);
  } catch (const std::exception& error) {
    Session::abort_all(error.what());
  }
}
