// Nesterov's gradient method in the block-Jacobi metric, with one product an iteration.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <utility>

#include "spall/base/require.hpp"
#include "spall/solver/contact_system.hpp"

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

constexpr int forced_restart = 100;  // without it true Coulomb friction stalls
constexpr int longest_unchecked = 50;

/// Momentum of FISTA (Beck & Teboulle 2009), capped at what a problem of strong convexity `eps`
/// wants.
class Momentum {
 public:
  explicit Momentum(double eps) : eps_(eps) {}

  double next(bool restart, double lipschitz) {
    ++since_restart_;
    if (restart || since_restart_ >= forced_restart) {
      since_restart_ = 0;
      t_ = 1;
      return 0;
    }
    const double t = (1 + std::sqrt(1 + 4 * t_ * t_)) / 2;
    const double fista = (t_ - 1) / t;
    t_ = t;
    const double q = std::sqrt((lipschitz + eps_) / eps_);  // infinite without a proximal term
    return eps_ > 0 ? std::min(fista, (q - 1) / (q + 1)) : fista;
  }

 private:
  double eps_;
  double t_ = 1;
  int since_restart_ = 0;
};

}  // namespace

template <int dimension>
Candidate<dimension> accelerated_gradient(const ContactSystem<dimension>& system,
                                          const SolverSettings& settings,
                                          Candidate<dimension> start, SolverReport& report) {
  const ContactBlocks<dimension>& contacts = system.contacts;
  const double eps = system.prox;
  const double tolerance = settings.tolerance;
  Candidate<dimension> best = std::move(start);
  if (best.residual.relative_prox <= tolerance) return best;

  // Two iterates, the sums of their impulses on bodies, and the velocities of the point y between.
  Impulses<dimension> iterate = best.impulse, before = best.impulse;
  Rows<dimension> sums = system.impulse_rows(iterate), sums_before = system.zero_rows();
  Rows<dimension> velocity = best.velocity;

  Momentum momentum(eps);
  DelayedSum late(system.ghosts.comm().raw);
  double lipschitz = 2;  // of the Delassus operator in the metric: 3.4–4 in piles, at least 1
  double beta = 0;
  double calibration = 1;  // of the running estimate of the residual by the residual
  int unchecked = 0;

  while (report.iterations < settings.max_iterations) {
    const GradientStep step{beta, lipschitz / (lipschitz + eps), 1 / (lipschitz + eps)};
    StepSums local;
    with_friction(system.friction, [&](auto model) {
      // The ghosts' velocities fly while interior contacts are treated.
      system.gather_begin(velocity);
      step_contacts<model(), false>(contacts, system.interior(), step, velocity.data(),
                                    iterate.data(), before.data(), sums_before.data(), local);
      system.gather_end(velocity);
      step_contacts<model(), true>(contacts, system.boundary(), step, velocity.data(),
                                   iterate.data(), before.data(), sums_before.data(), local);
    });
    std::swap(iterate, before);
    std::swap(sums, sums_before);

    // Scalars of the iteration before this one: their sum had a whole pass to arrive.
    const auto [curvature, length2, progress] = late.wait();
    if (length2 > 0) {
      const double ratio = curvature / length2;
      lipschitz = ratio > lipschitz ? 1.02 * ratio : 0.98 * lipschitz;
    }
    const double estimate = (lipschitz + eps) * std::sqrt(length2) / system.scale;
    beta = momentum.next(progress < 0, lipschitz);
    const double own_curvature =
        extrapolate_rows(contacts, beta, sums.data(), sums_before.data(), velocity.data());
    late.start({own_curvature, local.length2, local.progress});

    ++report.iterations;
    ++report.products;
    ++unchecked;
    const bool promising = unchecked < report.iterations && estimate * calibration <= tolerance;
    if (!promising && unchecked < longest_unchecked && report.iterations < settings.max_iterations)
      continue;

    unchecked = 0;
    Rows<dimension> changes = system.velocity_rows(sums);
    const Residual residual = system.residual(iterate, changes);
    ++report.products;
    calibration = residual.relative_prox / estimate / 0.9;
    if (residual.relative_prox < best.residual.relative_prox)
      best = {iterate, std::move(changes), residual};
    if (best.residual.relative_prox <= tolerance) break;
  }
  return best;
}

template Candidate<1> accelerated_gradient(const ContactSystem<1>&, const SolverSettings&,
                                           Candidate<1>, SolverReport&);
template Candidate<3> accelerated_gradient(const ContactSystem<3>&, const SolverSettings&,
                                           Candidate<3>, SolverReport&);

}  // namespace spall
