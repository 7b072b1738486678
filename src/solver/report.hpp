// What a solve was: apart from the problem, so that steps can be reported without it.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// The residual is the natural map in velocity units, R_c = S_c (p_c - P_c(p_c - S_c^-1 u_c)).
struct SolverReport {
  int iterations = 0;
  int products = 0;     ///< with the Delassus operator
  double residual = 0;  ///< E = sqrt(sum R^T S^-1 R) / E(p = 0), of the problem as asked, no prox
  double residual_prox = 0;     ///< E_eps, of the proximal problem; equals `residual` without one
  double residual_max = 0;      ///< m/s, largest |R_c|
  double residual_rms = 0;      ///< m/s
  double scale = 0;             ///< sqrt(J), what E and E_eps are relative to
  bool converged = true;        ///< met its tolerances, by E_eps
  bool over_tolerance = false;  ///< E, of the problem as asked, missed them
  bool unsolved = false;        ///< nor is E_eps half of that without impulses
  bool relaxed = false;         ///< so convex friction was taken in place of Coulomb's
  double seconds = 0;           ///< of this rank
};

}  // namespace spall
