// What a case asks of the solver: apart from the problem, which most of the solver is about.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "base/choice.hpp"
#include "solver/friction_model.hpp"

namespace spall {

/// apgd and barzilai_borwein minimise: convex friction only. See solver/methods.hpp.
enum class SolverMethod { accelerated, apgd, barzilai_borwein, sor };
inline constexpr Choice<SolverMethod> solver_methods[] = {
    {"accelerated", SolverMethod::accelerated},
    {"apgd", SolverMethod::apgd},
    {"bb", SolverMethod::barzilai_borwein},
    {"sor", SolverMethod::sor}};
/// Methods that minimise an energy know no exact Coulomb friction.
constexpr bool needs_convex(SolverMethod method) {
  return method == SolverMethod::apgd || method == SolverMethod::barzilai_borwein;
}
inline constexpr Choice<FrictionModel> friction_models[] = {{"coulomb", FrictionModel::coulomb},
                                                            {"convex", FrictionModel::convex}};

struct SolverSettings {
  SolverMethod method = SolverMethod::accelerated;
  FrictionModel friction = FrictionModel::coulomb;
  double tolerance = 1e-2;     ///< on E (on E_eps where `prox` > 0): relative to impulses all zero
  double speed_tolerance = 0;  ///< m/s, on every |R_c| too; 0: `tolerance` of the fastest closing
                               ///< speed where no impulses of an earlier step serve
  int max_iterations = 1000;
  int max_products = std::numeric_limits<int>::max();  ///< checks between iterations go beyond it
  double prox = 4e-3;  ///< of `accelerated`: weight eps of staying near the warm start; 0: none
  double relaxation = 1.0;  ///< of `sor`
  bool impact = true;       ///< something may have met: if no given impulses serve, something has
  double least_scale = 0;   ///< sqrt(J), E is relative to no less
};

}  // namespace spall
