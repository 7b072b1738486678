// The methods: from a start to impulses whose residual meets the tolerance, or the best seen.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver/contact_system.hpp"

namespace spall {

/// What the methods heed of SolverSettings; apart from them, so that a changed default of a case
/// compiles no method anew.
struct MethodSettings {
  double tolerance;
  int max_iterations, max_products;
  double relaxation;
};

inline bool used_up(const MethodSettings& settings, const SolverReport& report) {
  return report.iterations >= settings.max_iterations || report.products >= settings.max_products;
}

/// Whether a residual is as small as asked.
template <int dimension>
bool met(const Residual& residual, const ContactSystem<dimension>& system,
         const MethodSettings& settings) {
  return residual.relative_prox <= settings.tolerance &&
         residual.max_prox <= system.speed_tolerance;
}

/// Nesterov's gradient method in the block-Jacobi metric with one product an iteration; the only
/// one that knows the proximal term. Exact Coulomb friction by its normal-first projection.
/// Collective, as all of these.
template <int dimension>
Candidate<dimension> accelerated_gradient(ContactSystem<dimension>& system,
                                          const MethodSettings& settings,
                                          Candidate<dimension> start, SolverReport& report);

/// APGD as published (Mazhar, Heyn, Negrut & Tasora, ACM Trans. Graph. 34 (2015) 32): scalar
/// metric, backtracking. Convex friction.
template <int dimension>
Candidate<dimension> apgd(const ContactSystem<dimension>& system, const MethodSettings& settings,
                          Candidate<dimension> start, SolverReport& report);

/// Spectral projected gradient with Barzilai–Borwein steps and a non-monotone search (Birgin,
/// Martinez & Raydan, SIAM J. Optim. 10 (2000) 1196), in the block-Jacobi metric. Convex friction.
template <int dimension>
Candidate<dimension> spectral_gradient(const ContactSystem<dimension>& system,
                                       const MethodSettings& settings, Candidate<dimension> start,
                                       SolverReport& report);

/// Projected Gauss–Seidel with relaxation: contact after contact inside a rank, all at once
/// between ranks.
template <int dimension>
Candidate<dimension> gauss_seidel(const ContactSystem<dimension>& system,
                                  const MethodSettings& settings, Candidate<dimension> start,
                                  SolverReport& report);

}  // namespace spall
