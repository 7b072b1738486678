// What a run that goes on can still be told.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "output/restart.hpp"
#include "scene/case.hpp"

namespace spall {

/// Throws Error where the change, "key.path=value", is of something that lies behind `state`: it
/// would stand in the results and change nothing. `before` is the case without it.
void check_change(const RestartState& state, const Case& before, const std::string& change);

/// The same of the cohesion that follows from a material's constants: a state keeps its own.
void check_cohesion_ahead(const Case& before, const Case& after);

/// The same of read-outs, in `after`, the case with all changes.
void check_read_outs_ahead(const RestartState& state, const Case& before, const Case& after);

/// The same where walls of `after` are others than those of `before`, or lie in bodies more deeply:
/// they would be pushed out at once. Collective.
void check_walls_ahead(const Comm& comm, const RestartState& state, const Case& before,
                       const Case& after);

/// Bodies of `before` are of the same materials in `after`. These are counted in the order of their
/// names, which one that is added changes.
void follow_materials(const Case& before, const Case& after, Bodies& bodies);

}  // namespace spall
