// Steps of solids with a stress a body: leapfrog as drift, kick, drift.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solid/engine.hpp"

namespace spall {

/// Advances the world as `smooth_steps` does. Collective.
StepReport solid_steps(World& world, Elastoplastic& engine, const StepRequest& request);

}  // namespace spall
