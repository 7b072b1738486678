// One solve: check, pack, choose the start, run the method, unpack.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "spall/base/require.hpp"
#include "spall/solver/contact_system.hpp"

namespace spall {
namespace {

void check_shapes(const ContactProblem& problem, const Ghosts& ghosts,
                  const SolverSettings& settings, const std::vector<Vec3>& impulse) {
  const std::size_t rows = static_cast<std::size_t>(ghosts.owned()) + ghosts.ghosts();
  require(problem.inverse_mass.size() == rows,
          "contact problem has {} inverse masses for {} bodies", problem.inverse_mass.size(), rows);
  const std::size_t n = problem.i.size();
  require(problem.j.size() == n && problem.normal.size() == n && problem.kappa.size() == n &&
              problem.free_velocity.size() == n && problem.friction.size() == n &&
              problem.cohesive_impulse.size() == n && impulse.size() == n,
          "contact problem's fields differ in length");
  require(problem.dimension == 1 || problem.dimension == 3, "contact dimension is {}, not 1 or 3",
          problem.dimension);
  require(settings.tolerance > 0, "solver tolerance is {}, must be positive", settings.tolerance);
  require(settings.max_iterations >= 0, "solver's max_iterations is {}, must not be negative",
          settings.max_iterations);
  require(settings.prox >= 0 && settings.prox < infinity, "solver's prox is {}, must be 0 or more",
          settings.prox);
}

/// Contacts of this rank with a number that is not one, or that is out of its range.
std::int64_t count_bad(const ContactProblem& problem, const std::vector<Vec3>& impulse) {
  std::int64_t bad = 0;
  for (double w : problem.inverse_mass) bad += !(w >= 0 && w < infinity);
  for (Index c = 0; c < problem.contacts(); ++c) {
    const double mu = problem.friction[c], s = problem.cohesive_impulse[c];
    bad += !(problem.normal[c].allFinite() && problem.free_velocity[c].allFinite() &&
             impulse[c].allFinite() && std::isfinite(problem.kappa[c]) && mu >= 0 &&
             mu < infinity && s >= 0 && s < infinity);
  }
  return bad;
}

template <int dimension>
Candidate<dimension> run_method(const ContactSystem<dimension>& system,
                                const SolverSettings& settings, Candidate<dimension> start,
                                SolverReport& report) {
  switch (settings.method) {
    case SolverMethod::accelerated:
      return accelerated_gradient(system, settings, std::move(start), report);
    default:
      throw Error("solver method not available");
  }
}

template <int dimension>
SolverResult solve_packed(const ContactProblem& problem, const Ghosts& ghosts,
                          const SolverSettings& settings, std::int64_t count,
                          std::vector<Vec3>& impulse) {
  SolverResult result;
  SolverReport& report = result.report;
  ContactSystem<dimension> system{.ghosts = ghosts,
                                  .friction = settings.friction,
                                  .contacts = pack<dimension>(problem, ghosts.owned()),
                                  .centre = {},
                                  .count = count};
  system.centre.resize(system.contacts.blocks.size());

  Candidate<dimension> start{
      Impulses<dimension>(system.contacts.blocks.size()), system.zero_rows(), {}};
  start.residual = system.residual(start.impulse, start.velocity);
  if (start.residual.relative > 0) {
    system.scale = start.residual.relative;
    start.residual = system.residual(start.impulse, start.velocity);

    // A warm start that is worse than none belongs to another state of motion: neither where to
    // start nor what to stay near.
    Candidate<dimension> warm{pack_impulses<dimension>(problem, impulse), {}, {}};
    warm.velocity = system.velocity_rows(system.impulse_rows(warm.impulse));
    warm.residual = system.residual(warm.impulse, warm.velocity);
    ++report.products;
    if (warm.residual.relative <= 1) start = std::move(warm);

    if (settings.method == SolverMethod::accelerated) {
      system.prox = settings.prox;
      system.centre = start.impulse;
      add_centre(system.contacts, system.centre, system.prox);
    }
    start = run_method(system, settings, std::move(start), report);
  }

  report.residual = start.residual.relative;
  report.residual_prox = start.residual.relative_prox;
  report.residual_max = start.residual.max;
  report.residual_rms = start.residual.rms;
  report.converged = start.residual.relative_prox <= settings.tolerance;

  unpack_impulses(problem, start.impulse, impulse);
  result.change.resize(problem.inverse_mass.size());
  for (std::size_t b = 0; b < result.change.size(); ++b)
    std::copy_n(start.velocity[b].at, 3, result.change[b].linear);
  if constexpr (dimension == 3)
    for (std::size_t b = 0; b < result.change.size(); ++b)
      std::copy_n(start.velocity[b].at + 4, 3, result.change[b].angular);
  return result;
}

}  // namespace

SolverResult solve(const ContactProblem& problem, const Ghosts& ghosts,
                   const SolverSettings& settings, std::vector<Vec3>& impulse) {
  const double began = MPI_Wtime();
  const Comm& comm = ghosts.comm();
  check_shapes(problem, ghosts, settings, impulse);
  const std::int64_t bad = comm.sum(count_bad(problem, impulse));
  require(bad == 0, "contact problem has {} entries that are not finite or out of range", bad);
  std::int64_t own = 0;
  for (Index i : problem.i) own += i < ghosts.owned();
  const std::int64_t count = comm.sum(own);

  SolverResult result;
  if (count == 0)
    result.change.resize(problem.inverse_mass.size());
  else if (problem.dimension == 1)
    result = solve_packed<1>(problem, ghosts, settings, count, impulse);
  else
    result = solve_packed<3>(problem, ghosts, settings, count, impulse);
  result.report.seconds = comm.max(MPI_Wtime() - began);
  return result;
}

}  // namespace spall
