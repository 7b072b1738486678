// One solve: check, pack, choose the start, run the method, unpack.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <cmath>

#include "base/kernels.hpp"
#include "base/let_go.hpp"
#include "solver/methods.hpp"
#include "solver/settings.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

void check_shapes(const ContactProblem& problem, const Ghosts& ghosts,
                  const SolverSettings& settings, const std::vector<Vec3>& impulse) {
  const std::size_t rows = static_cast<std::size_t>(ghosts.owned()) + ghosts.ghosts();
  require(problem.inverse_mass.size() == rows,
          "contact problem has {} inverse masses for {} bodies", problem.inverse_mass.size(), rows);
  const std::size_t n = problem.i.size();
  require(problem.j.size() == n && problem.normal.size() == n && problem.kappa.size() == n &&
              problem.free_velocity.size() == n && impulse.size() == n &&
              (problem.friction.empty() || problem.friction.size() == n) &&
              (problem.cohesive_impulse.empty() || problem.cohesive_impulse.size() == n),
          "contact problem's fields differ in length");
  require(!problem.matrix || (problem.dimension == 3 && n == rows &&
                              problem.matrix->owned == static_cast<Index>(rows)),
          "contact problem has {} contacts and {} rows for a matrix of {} contacts", n, rows,
          problem.matrix ? problem.matrix->owned : 0);
  require(!problem.has_arms() ||
              (problem.dimension == 3 && !problem.matrix && problem.turning.size() == rows &&
               problem.arm_i.size() == n && problem.arm_j.size() == n),
          "contact problem's lever arms need dimension 3, an arm a contact and a turning factor a "
          "body");
  require(!problem.has_arms() || settings.method != SolverMethod::sor,
          "solver method sor knows contacts of spheres alone: no lever arms");
  require(problem.dimension == 1 || problem.dimension == 3, "contact dimension is {}, not 1 or 3",
          problem.dimension);
  require(settings.tolerance > 0, "solver tolerance is {}, must be positive", settings.tolerance);
  require(settings.max_iterations >= 0, "solver's max_iterations is {}, must not be negative",
          settings.max_iterations);
  require(!needs_convex(settings.method) || problem.dimension == 1 ||
              settings.friction == FrictionModel::convex,
          "solver methods apgd and bb minimise: they need friction \"convex\"");
  require(settings.relaxation > 0 && settings.relaxation < 2,
          "solver's relaxation is {}, must lie between 0 and 2", settings.relaxation);
  require(settings.prox >= 0 && settings.prox < infinity, "solver's prox is {}, must be 0 or more",
          settings.prox);
}

/// Contacts of this rank with a number that is not one, or that is out of its range.
std::int64_t count_bad(const ContactProblem& problem, const std::vector<Vec3>& impulse) {
  std::int64_t bad = 0;
  for (double w : problem.inverse_mass) bad += !(w >= 0 && w < infinity);
  for (const Mat3& factor : problem.turning) bad += !factor.allFinite();
  for (const auto arms : {problem.arm_i, problem.arm_j})
    for (const Vec3& arm : arms) bad += !arm.allFinite();
  for (Index c = 0; c < problem.contacts(); ++c) {
    const double mu = problem.friction_of(c), s = problem.cohesion_of(c);
    bad += !(problem.normal[c].allFinite() && problem.free_velocity[c].allFinite() &&
             impulse[c].allFinite() && std::isfinite(problem.kappa[c]) && mu >= 0 &&
             mu < infinity && s >= 0 && s < infinity);
  }
  return bad;
}

template <int dimension>
Candidate<dimension> run_method(ContactSystem<dimension>& system, SolverMethod method,
                                const MethodSettings& settings, Candidate<dimension> start,
                                SolverReport& report) {
  switch (method) {
    case SolverMethod::accelerated:
      return accelerated_gradient(system, settings, std::move(start), report);
    case SolverMethod::apgd:
      return apgd(system, settings, std::move(start), report);
    case SolverMethod::barzilai_borwein:
      return spectral_gradient(system, settings, std::move(start), report);
    case SolverMethod::sor:
      if constexpr (dimension != levers)
        return gauss_seidel(system, settings, std::move(start), report);
  }
  throw Error("unknown solver method");
}

/// Where less of the impulses than this serves, most of them belong to another state of motion.
constexpr double least_part_to_hold = 0.5;

/// The part of the given impulses that serves best: p scaled to minimise p N p / 2 + p b, between
/// none and all of it. What belongs to another state of motion (the step after an impact) scales to
/// nothing: it would be neither where to start nor what to stay near. E is no such test: a few fast
/// collisions make it equal for good and bad impulses of all other contacts. `part` is the scale.
template <int dimension>
Candidate<dimension> warm_start(const ContactSystem<dimension>& system,
                                Impulses<dimension, double> impulse, double& part) {
  Candidate<dimension> warm{std::move(impulse), {}, {}};
  make_admissible(system, warm.impulse);
  warm.velocity = system.product(warm.impulse);
  Lanes curvature{}, slope{};
  for (std::size_t at = 0; at < warm.impulse.size(); ++at) {
    const auto& block = system.contacts.blocks[at];
    const Lanes* p = warm.impulse[at].at;
    const Lanes weight = convert<double>(counted(block, system.contacts.owned));
    Lanes change[components<dimension>];
    scaled_velocity(block, warm.velocity.data(), change);
    curvature += weight * metric_product(block, p, change);
    slope += weight * metric_product(block, p, block.free_impulse);
  }
  double sums[2] = {sum_of_lanes(curvature), sum_of_lanes(slope)};
  system.ghosts.comm().sum(sums);
  part = sums[0] > 0 ? std::clamp(-sums[1] / sums[0], 0.0, 1.0) : 0;
  for (auto& block : warm.impulse)
    for (auto& p : block.at) p *= part;
  for (auto& row : warm.velocity) row.at *= part;
  warm.residual = system.residual(warm.impulse, warm.velocity);
  return warm;
}

/// The packed problem, and as a candidate no impulses at all, whose residual is its scale.
template <int dimension>
std::pair<ContactSystem<dimension>, Candidate<dimension>> pose(const ContactProblem& problem,
                                                               const Ghosts& ghosts,
                                                               FrictionModel friction,
                                                               std::int64_t count) {
  const PackedUnits units = choose_units(problem, ghosts.comm());
  ContactSystem<dimension> system{.ghosts = ghosts,
                                  .friction = friction,
                                  .units = units,
                                  .contacts = pack<dimension>(problem, units, ghosts.owned()),
                                  .centre = {},
                                  .count = count};
  system.centre.resize(system.contacts.blocks.size());
  Candidate<dimension> none{system.centre, Rows<dimension, double>(system.contacts.rows), {}};
  none.residual = system.residual(none.impulse, none.velocity);
  if (none.residual.relative > 0) {
    system.scale = none.residual.relative;
    none.residual.relative = none.residual.relative_prox = 1;
  }
  return {std::move(system), std::move(none)};
}

void report_residual(const Residual& residual, SolverReport& report) {
  report.residual = residual.relative;
  report.residual_prox = residual.relative_prox;
  report.residual_max = residual.max;
  report.residual_rms = residual.rms;
}

template <int dimension>
SolverReport evaluate_packed(const ContactProblem& problem, const Ghosts& ghosts,
                             FrictionModel friction, std::int64_t count,
                             const std::vector<Vec3>& impulse) {
  SolverReport report;
  const auto [system, none] = pose<dimension>(problem, ghosts, friction, count);
  auto packed = pack_impulses<dimension>(problem, system.units, impulse);
  make_admissible(system, packed);
  report_residual(system.evaluate(std::move(packed)).residual, report);
  report.products = 1;
  return report;
}

template <int dimension>
SolverResult solve_packed(const ContactProblem& problem, const Ghosts& ghosts,
                          const SolverSettings& settings, std::int64_t count,
                          std::vector<Vec3>& impulse, const std::function<void()>& packed) {
  SolverResult result;
  SolverReport& report = result.report;
  auto [system, best] = pose<dimension>(problem, ghosts, settings.friction, count);
  if (packed) packed();
  const MethodSettings of_method{settings.tolerance, settings.max_iterations, settings.max_products,
                                 settings.relaxation};
  const PackedUnits& units = system.units;
  if (best.residual.relative > 0) {
    const double fastest = best.residual.max;
    const double unit = std::sqrt(units.impulse * units.velocity);  // sqrt(J)
    system.scale = std::max(system.scale, settings.least_scale / unit);
    report.scale = unit * system.scale;
    double part = 0;
    best = warm_start(system, pack_impulses<dimension>(problem, units, impulse), part);
    let_go(impulse);
    ++report.products;
    system.none_holds = settings.impact && part < least_part_to_hold;
    system.speed_tolerance = settings.speed_tolerance > 0 ? settings.speed_tolerance
                             : system.none_holds          ? settings.tolerance * fastest
                                                          : infinity;
    if (settings.method == SolverMethod::accelerated && settings.prox > 0)
      system.stay_near(best.impulse, settings.prox);
    best = run_method(system, settings.method, of_method, std::move(best), report);
  }

  report_residual(best.residual, report);
  report.converged = best.residual.relative == 0 || met(best.residual, system, of_method);
  constexpr double as_good_as_none = 0.5;  // of the residual without impulses
  report.unsolved = !report.converged && best.residual.relative_prox > as_good_as_none;

  report.over_tolerance = best.residual.relative > settings.tolerance;
  impulse.resize(problem.contacts());
  unpack_impulses(problem, units, best.impulse, impulse);
  result.change.resize(problem.inverse_mass.size());
  for (std::size_t b = 0; b < result.change.size(); ++b)
    for (int d = 0; d < 3; ++d) {
      result.change[b].linear[d] = units.velocity * best.velocity[b].at[d];
      if constexpr (dimension != 1)
        result.change[b].angular[d] = units.velocity * best.velocity[b].at[4 + d];
    }
  return result;
}

/// Contacts over all ranks, after all checks of the problem.
std::int64_t checked_count(const ContactProblem& problem, const Ghosts& ghosts,
                           const SolverSettings& settings, const std::vector<Vec3>& impulse) {
  check_shapes(problem, ghosts, settings, impulse);
  const Comm& comm = ghosts.comm();
  std::array<double, 2> counts{static_cast<double>(count_bad(problem, impulse)), 0};
  for (Index i : problem.i) counts[1] += i < ghosts.owned();
  comm.sum(counts);
  require(counts[0] == 0, "contact problem has {} entries that are not finite or out of range",
          counts[0]);
  return static_cast<std::int64_t>(counts[1]);
}

}  // namespace

SPALL_KERNEL(SolverReport, evaluate,
             (const ContactProblem& problem, const Ghosts& ghosts, FrictionModel friction,
              const std::vector<Vec3>& impulse),
             (problem, ghosts, friction, impulse)) {
  const std::int64_t count = checked_count(problem, ghosts, {.friction = friction}, impulse);
  if (count == 0) return {};
  if (problem.has_arms()) return evaluate_packed<levers>(problem, ghosts, friction, count, impulse);
  return problem.dimension == 1 ? evaluate_packed<1>(problem, ghosts, friction, count, impulse)
                                : evaluate_packed<3>(problem, ghosts, friction, count, impulse);
}

SPALL_KERNEL(SolverResult, solve,
             (const ContactProblem& problem, const Ghosts& ghosts, const SolverSettings& settings,
              std::vector<Vec3>& impulse, const std::function<void()>& packed),
             (problem, ghosts, settings, impulse, packed)) {
  const double began = MPI_Wtime();
  const std::int64_t count = checked_count(problem, ghosts, settings, impulse);

  SolverResult result;
  if (count == 0)
    result.change.resize(problem.inverse_mass.size());
  else if (problem.has_arms())
    result = solve_packed<levers>(problem, ghosts, settings, count, impulse, packed);
  else if (problem.dimension == 1)
    result = solve_packed<1>(problem, ghosts, settings, count, impulse, packed);
  else
    result = solve_packed<3>(problem, ghosts, settings, count, impulse, packed);
  result.report.seconds = MPI_Wtime() - began;
  return result;
}

}  // namespace spall
