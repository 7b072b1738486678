// The engines that there are.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "engine/type.hpp"

namespace spall {

/// In the order in which their keys are listed; the first is what phases without a method have.
std::span<const EngineType* const> all_engines();

/// Bytes a body at the peak of a step in which a body has `contacts`, as measured (within a third).
/// Neighbours that do not touch are counted in.
double bytes_a_body(const EngineType& engine, const Surroundings& around, double contacts);

}  // namespace spall
