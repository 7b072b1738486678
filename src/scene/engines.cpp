// One line an engine.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/engines.hpp"

#include <array>

#include "penalty/engine.hpp"
#include "potential/engine.hpp"
#include "rigid/engine.hpp"

namespace spall {

std::span<const EngineType* const> all_engines() {
  static constexpr std::array engines{
      &rigid_engine,
      &potential_engine,
      &penalty_engine,
  };
  return engines;
}

}  // namespace spall
