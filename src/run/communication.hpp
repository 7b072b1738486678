// What ranks told each other in a run, by stage.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "output/results.hpp"
#include "state/world.hpp"

namespace spall {

/// Adds the section [communication]: of each stage messages, bytes and collective calls a step, of
/// the rank with most of them, over the `steps` that this program made; the `ghosts` that this rank
/// had after the last one. Collective.
void add_communication(const World& world, Index ghosts, std::int64_t steps, ResultTable& table);

}  // namespace spall
