// The table of the laws of adhesion of penalty contact.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "penalty/elastic.hpp"
#include "penalty/jkr.hpp"

namespace spall {

/// All of them: X(name in [penalty] adhesion, type). To add a law, include its header above and add
/// a line: keys, reference, constants, limits of the step and kernels follow. The types are
/// templates on a number: of one law for all lanes, or of one for each. The first is the default.
#define SPALL_ADHESIONS(X) \
  X(none, PlainHertzLanes) \
  X(dmt, DmtLanes)         \
  X(jkr, JkrLanes)

enum class Adhesion : int {
#define SPALL_ADHESION(name, Law) name,
  SPALL_ADHESIONS(SPALL_ADHESION)
#undef SPALL_ADHESION
};

/// Calls `f` with the type of the law as its template argument: `f.operator()<Law>()`.
template <class F>
auto with_adhesion(Adhesion adhesion, F&& f) {
  switch (adhesion) {
#define SPALL_ADHESION(name, Law) \
  case Adhesion::name:            \
    return f.template operator()<Law>();
    SPALL_ADHESIONS(SPALL_ADHESION)
#undef SPALL_ADHESION
  }
  __builtin_unreachable();
}

}  // namespace spall
