// The engines that there are.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "engine/type.hpp"

namespace spall {

/// In the order in which their keys are listed; the first is what phases without a method have.
std::span<const EngineType* const> all_engines();

}  // namespace spall
