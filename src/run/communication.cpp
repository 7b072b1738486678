// The rank with most decides how long all take.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/communication.hpp"

#include <array>

#include "run/record.hpp"

namespace spall {

void add_communication(const World& world, Index ghosts, std::int64_t steps, ResultTable& table) {
  const Comm& comm = world.comm;
  const auto a_step = 1.0 / static_cast<double>(std::max<std::int64_t>(steps, 1));
  double sources = 0, gathered = 0;
  for (const auto& stage : stages) {
    const Traffic& own = world.stages.at(stage).traffic;
    std::array<double, 3> most{a_step * static_cast<double>(own.messages),
                               a_step * static_cast<double>(own.bytes),
                               a_step * static_cast<double>(own.collectives)};
    comm.max(most);
    sources = std::max(sources, static_cast<double>(own.sources));
    gathered += a_step * static_cast<double>(own.gathered);
    if (most[2] == 0 && most[0] == 0) continue;
    table.add("communication", stage + "_messages", most[0], "", "a step, the rank with most");
    table.add("communication", stage + "_bytes", most[1], "B", "sent in them");
    table.add("communication", stage + "_collectives", most[2], "", "a step");
  }
  const auto owned = static_cast<double>(world.bodies.owned);
  const double mean = comm.sum(owned) / comm.size;
  std::array<double, 4> most{sources, gathered, owned, static_cast<double>(ghosts)};
  comm.max(most);
  table.add("communication", "sources", static_cast<std::int64_t>(most[0]), "",
            "most ranks from which one received at once");
  table.add("communication", "gathered_bytes", most[1], "B", "a step, from all ranks");
  table.add("communication", "ghosts_a_body", most[3] / mean, "",
            "after the last step, the rank with most");
  table.add("communication", "imbalance", most[2] / mean, "", "of bodies: most over mean");
}

}  // namespace spall
