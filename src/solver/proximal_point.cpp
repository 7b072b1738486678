// The proximal-point method (Rockafellar 1976): the centre of the proximal term follows the
// impulses, and with it its error goes away.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "spall/solver/methods.hpp"

namespace spall {
namespace {

/// Each problem in between is solved to this part of the residual that it begins with: what it
/// leaves is small against what the next centre changes.
double inner_part = 0.2;

}  // namespace

template <int dimension>
Candidate<dimension> proximal_point(ContactSystem<dimension>& system,
                                    const SolverSettings& settings, Candidate<dimension> start,
                                    SolverReport& report) {
  Candidate<dimension> best = start, now = std::move(start);
  if (const char* s = getenv("SPALL_PART")) inner_part = atof(s);
  while (best.residual.relative > settings.tolerance && !used_up(settings, report)) {
    SolverSettings inner = settings;
    inner.tolerance = std::max(inner_part * now.residual.relative, settings.tolerance / 2);
    const double before = now.residual.relative_prox;
    now = accelerated_gradient(system, inner, std::move(now), report);
    if (now.residual.relative < best.residual.relative) best = now;
    if (now.residual.relative_prox == before) break;  // at the limit of round-off
    system.move_centre(now.impulse);
    now.residual.relative_prox = now.residual.relative;
  }
  best.residual.relative_prox = best.residual.relative;
  return best;
}

template Candidate<1> proximal_point(ContactSystem<1>&, const SolverSettings&, Candidate<1>,
                                     SolverReport&);
template Candidate<3> proximal_point(ContactSystem<3>&, const SolverSettings&, Candidate<3>,
                                     SolverReport&);

}  // namespace spall
