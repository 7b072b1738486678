// Nesterov's gradient method in the block-Jacobi metric, with one product an iteration.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <utility>

#include "base/traffic.hpp"
#include "solver/methods.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// A sum over ranks under way; `wait` gives it. Never left behind pending.
class DelayedSum {
 public:
  explicit DelayedSum(MPI_Comm comm) : comm_(comm) {}
  ~DelayedSum() { MPI_Wait(&request_, MPI_STATUS_IGNORE); }
  DelayedSum(const DelayedSum&) = delete;
  DelayedSum& operator=(const DelayedSum&) = delete;

  void start(const std::array<double, 3>& values) {
    ++traffic().collectives;
    ++traffic().delayed;
    traffic().reduced += static_cast<std::int64_t>(sizeof(values));
    local_ = values;
    check_mpi(MPI_Iallreduce(local_.data(), global_.data(), static_cast<int>(local_.size()),
                             MPI_DOUBLE, MPI_SUM, comm_, &request_),
              "MPI_Iallreduce");
  }
  const std::array<double, 3>& wait() {
    check_mpi(MPI_Wait(&request_, MPI_STATUS_IGNORE), "MPI_Wait");
    return global_;
  }

 private:
  MPI_Comm comm_;
  MPI_Request request_ = MPI_REQUEST_NULL;
  std::array<double, 3> local_{}, global_{};
};

constexpr int patience = 100;
constexpr int longest_unchecked = 50;
constexpr int fewest_iterations = 12;  // or a resting pile keeps its warm start's error, and creeps
constexpr double first_lipschitz = 2;  // 1 at least, 3.4–4 in piles

// An impact is for good, while a later step mends what one at rest left. So where nothing of an
// earlier step holds, the residual falls on beyond the tolerance as long as that is cheap: a decade
// in so many iterations. Few contacts are then solved to all digits that matter.
constexpr int cheap_decade = 12;
constexpr double cheap_residual = 1e-8;

/// Momentum of FISTA (Beck & Teboulle 2009), capped at what a problem of strong convexity `eps`
/// wants. True Coulomb friction, which is no minimisation, stalls without forced restarts: one
/// after `patience` iterations in which the residual did not halve.
class Momentum {
 public:
  Momentum(double eps, bool forced) : eps_(eps), forced_(forced) {}

  /// The residual of the best iterate yet.
  void reached(double residual) {
    if (residual > mark_ / 2) return;
    mark_ = residual;
    since_progress_ = 0;
  }

  double next(bool restart, double lipschitz) {
    ++since_progress_;
    if (restart || (forced_ && since_progress_ >= patience)) {
      since_progress_ = 0;
      t_ = 1;
      return 0;
    }
    const double t = (1 + std::sqrt(1 + 4 * t_ * t_)) / 2;
    const double fista = (t_ - 1) / t;
    t_ = t;
    if (eps_ == 0) return fista;
    const double q = std::sqrt((lipschitz + eps_) / eps_);
    return std::min(fista, (q - 1) / (q + 1));
  }

 private:
  double eps_;
  bool forced_;
  double t_ = 1;
  int since_progress_ = 0;  // or since a restart
  double mark_ = 1;
};

/// Float iterates differ from exact ones by about this much of their norm.
constexpr double float_noise = 6e-8;

/// The system's centres, and the contacts that are iterated on.
template <class Real, int dimension>
void follow(ContactSystem<dimension>& system, const Impulses<dimension, double>& iterate,
            ContactBlocks<dimension, Real>& contacts) {
  system.follow(iterate);
  if constexpr (std::is_same_v<Real, float>) take_free_impulses(system.contacts, contacts);
}

/// Iterates in one precision from `best` on, until it meets the tolerance, the iterations are used
/// up, or floats cannot resolve what is asked.
template <class Real, int dimension>
void descend(ContactSystem<dimension>& system, ContactBlocks<dimension, Real>& contacts,
             const MethodSettings& settings, Candidate<dimension>& best, SolverReport& report) {
  const double eps = system.prox;
  const double tolerance = settings.tolerance;
  const auto resolved = [&](const Residual& residual) {
    return !std::is_same_v<Real, float> || 10 * float_noise * residual.norm < tolerance;
  };
  const auto is_cheap = [&](double residual) {
    return system.none_holds && residual > cheap_residual &&
           -cheap_decade * std::log10(residual) > report.iterations;
  };
  const auto finished = [&] {
    const double residual = best.residual.relative_prox;
    return (met(best.residual, system, settings) && report.iterations >= fewest_iterations &&
            !is_cheap(residual)) ||
           residual == 0 || used_up(settings, report);
  };
  if (finished() || !resolved(best.residual)) return;
  if (eps > 0) follow(system, best.impulse, contacts);

  // Two iterates, the sums of their impulses on bodies, and the velocities of the point y between.
  auto iterate = convert_impulses<dimension, Real>(best.impulse), before = iterate;
  Rows<dimension, Real> sums(contacts.rows), sums_before(contacts.rows);
  add_contacts(contacts, iterate, sums.data());
  complete_rows(contacts, sums);
  Rows<dimension, Real> velocity = sums;
  become_velocities(contacts, velocity.data());
  velocity.back() = Row<dimension, Real>();

  Momentum momentum(eps, dimension != 1 && system.friction == FrictionModel::coulomb);
  DelayedSum late(system.ghosts.comm().raw);
  double lipschitz = first_lipschitz;
  double beta = 0;
  double calibration = 1;  // residual over its running estimate
  int unchecked = 0, iterations = 0;

  while (true) {
    const GradientStep<Real> step{static_cast<Real>(beta),
                                  static_cast<Real>(lipschitz / (lipschitz + eps)),
                                  static_cast<Real>(1 / (lipschitz + eps))};
    StepSums own;
    with_friction(system.friction, [&](auto model) {
      // The ghosts' velocities fly while interior contacts are treated.
      gather_begin(system.ghosts, velocity);
      step_contacts<model(), false>(contacts, system.interior(), step, velocity.data(),
                                    iterate.data(), before.data(), sums_before.data(), own);
      gather_end(system.ghosts, velocity);
      step_contacts<model(), true>(contacts, system.boundary(), step, velocity.data(),
                                   iterate.data(), before.data(), sums_before.data(), own);
    });
    std::swap(iterate, before);
    std::swap(sums, sums_before);
    complete_rows(contacts, sums);

    // Scalars of the iteration before this one: their sum had a whole pass to arrive.
    const auto [curvature, length2, progress] = late.wait();
    if (length2 > 0) {
      const double ratio = curvature / length2;
      lipschitz = ratio > lipschitz ? 1.05 * ratio : 0.9 * lipschitz;
    }
    const double estimate = (lipschitz + eps) * std::sqrt(length2) / system.scale;
    beta = momentum.next(progress < 0, lipschitz);
    const double own_curvature = extrapolate_rows(contacts, static_cast<Real>(beta), sums.data(),
                                                  sums_before.data(), velocity.data());
    late.start({own_curvature, own.length2, own.progress});

    ++iterations;
    ++unchecked;
    ++report.iterations;
    ++report.products;
    const bool promising = iterations > 1 && report.iterations >= fewest_iterations &&
                           estimate * calibration <= tolerance;
    const bool going_on = system.none_holds && met(best.residual, system, settings);
    const int longest = going_on ? cheap_decade : longest_unchecked;
    if ((!promising || going_on) && unchecked < longest && !used_up(settings, report)) continue;

    unchecked = 0;
    auto exact = convert_impulses<dimension, double>(iterate);
    make_admissible(system, exact);  // to a double's round-off
    if (eps > 0) follow(system, exact, contacts);
    Candidate<dimension> now = system.evaluate(std::move(exact));
    ++report.products;
    calibration = now.residual.relative_prox / estimate / 0.9;
    const bool fine_enough = resolved(now.residual);
    if (now.residual.relative_prox < best.residual.relative_prox) best = std::move(now);
    momentum.reached(best.residual.relative_prox);
    if (finished() || !fine_enough) return;
  }
}

}  // namespace

template <int dimension>
Candidate<dimension> accelerated_gradient(ContactSystem<dimension>& system,
                                          const MethodSettings& settings,
                                          Candidate<dimension> start, SolverReport& report) {
  // Floats halve the memory traffic that bounds an iteration; every residual is a double's.
  Candidate<dimension> best = std::move(start);
  {
    ContactBlocks<dimension, float> rounded = round(system.contacts);
    descend(system, rounded, settings, best, report);
  }
  descend(system, system.contacts, settings, best, report);
  return best;
}

template Candidate<1> accelerated_gradient(ContactSystem<1>&, const MethodSettings&, Candidate<1>,
                                           SolverReport&);
template Candidate<3> accelerated_gradient(ContactSystem<3>&, const MethodSettings&, Candidate<3>,
                                           SolverReport&);
template Candidate<levers> accelerated_gradient(ContactSystem<levers>&, const MethodSettings&,
                                                Candidate<levers>, SolverReport&);

}  // namespace spall
