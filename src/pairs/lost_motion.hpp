// What steps throw where a body's motion is no number any more.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/error.hpp"

namespace spall {

/// All ranks throw it together, with velocities as the step left them: who catches it may find the
/// body by `first_lost_id`.
struct LostMotion : Error {
  using Error::Error;
};

}  // namespace spall
