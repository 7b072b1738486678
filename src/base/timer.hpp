// Where the time goes: wall seconds and messages of a stage, on this rank.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>

#include "base/traffic.hpp"

namespace spall {

struct StageUse {
  double seconds = 0;
  Traffic traffic;
};
using StageUses = std::map<std::string, StageUse>;

/// Adds the seconds and messages of its own lifetime to a stage.
class StageTimer {
 public:
  StageTimer(StageUses& uses, const char* stage);
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageUse& use_;
  Traffic before_;
  double start_;
};

}  // namespace spall
