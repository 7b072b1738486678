// Reads [penalty] of a case.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "section.hpp"
#include "spall/scene/case.hpp"

namespace spall {

void read_penalty(Section& in, PenaltySettings& settings);

/// What phases of penalty contact need of the rest of the case.
void check_penalty(const Case& scene, const Phase& phase);

}  // namespace spall
