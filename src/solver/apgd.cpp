// The algorithm's symbols are the paper's: gamma, y, theta, L, t = 1/L.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <utility>

#include "solver/methods.hpp"

namespace spall {
namespace {

/// The nearest admissible impulses in the Euclidean metric of the paper.
inline void project_euclidean(const ContactBlock<1, double>& block, Lanes* p) {
  p[0] = larger(p[0], -block.cohesion);
}
inline void project_euclidean(const ContactBlock<3, double>& block, Lanes* p) {
  const Lanes* n = block.normal;
  const Lanes p_n = dot(p, n);
  const Lanes t[3] = {p[0] - p_n * n[0], p[1] - p_n * n[1], p[2] - p_n * n[2]};
  const auto to =
      project_cone(p_n, square_root(dot(t, t)), block.friction, block.cohesion, Lanes{} + 1);
  for (int d = 0; d < 3; ++d) p[d] = to.tangent_factor * t[d] + to.normal * n[d];
}

/// Unit impulses along the normals.
inline void set_normal(const ContactBlock<1, double>&, Lanes* p) {
  p[0] = Lanes{} + 1;
}
inline void set_normal(const ContactBlock<3, double>& block, Lanes* p) {
  std::copy_n(block.normal, 3, p);
}

/// S g: from impulse units to velocities.
inline void apply_metric(const ContactBlock<1, double>& block, Lanes* g) {
  g[0] *= convert<double>(block.a_n);
}
inline void apply_metric(const ContactBlock<3, double>& block, Lanes* g) {
  const Lanes a_t = convert<double>(block.a_t);
  const Lanes normal = (convert<double>(block.a_n) - a_t) * dot(g, block.normal);
  for (int d = 0; d < 3; ++d) g[d] = a_t * g[d] + normal * block.normal[d];
}

/// Differences and Euclidean products of impulses and velocities.
template <int dimension>
struct Euclidean {
  using Vector = Impulses<dimension, double>;
  const ContactSystem<dimension>& system;

  Vector velocity(const Rows<dimension, double>& rows) const {
    Vector u = system.gradient(rows);
    for (std::size_t at = 0; at < u.size(); ++at)
      apply_metric(system.contacts.blocks[at], u[at].at);
    return u;
  }

  /// (a - b) . (c - d) over all ranks.
  double difference_product(const Vector& a, const Vector& b, const Vector& c,
                            const Vector& d) const {
    Lanes total{};
    for (std::size_t at = 0; at < a.size(); ++at)
      for (int k = 0; k < components<dimension>; ++k)
        total += convert<double>(counted(system.contacts.blocks[at], system.contacts.owned)) *
                 (a[at].at[k] - b[at].at[k]) * (c[at].at[k] - d[at].at[k]);
    return system.ghosts.comm().sum(sum_of_lanes(total));
  }
};

}  // namespace

template <int dimension>
Candidate<dimension> apgd(const ContactSystem<dimension>& system, const MethodSettings& settings,
                          Candidate<dimension> start, SolverReport& report) {
  const Euclidean<dimension> space{system};
  const std::size_t blocks = system.contacts.blocks.size();
  const Impulses<dimension, double> zero(blocks);
  Candidate<dimension> best = std::move(start);
  Impulses<dimension, double> gamma = best.impulse, y = gamma;

  Impulses<dimension, double> ones(blocks);
  for (std::size_t at = 0; at < blocks; ++at) set_normal(system.contacts.blocks[at], ones[at].at);
  const Rows<dimension, double> still(system.contacts.rows);
  const auto n_ones = space.velocity(system.product(ones));
  const auto b = space.velocity(still);
  ++report.products;
  double lipschitz = std::sqrt(space.difference_product(n_ones, b, n_ones, b) /
                               space.difference_product(ones, zero, ones, zero));
  if (!(lipschitz > 0)) {  // they cancel, as of a ball in a slit: the search below finds the bound
    double largest = 0;
    for (const auto& block : system.contacts.blocks)
      largest = std::max(largest, largest_lane(convert<double>(block.a_n)));
    lipschitz = system.ghosts.comm().max(largest);
  }
  double theta = 1;

  while (!used_up(settings, report) && !met(best.residual, system, settings)) {
    const auto g = space.velocity(system.product(y));
    ++report.products;
    Candidate<dimension> next;
    while (true) {
      next.impulse = y;
      for (std::size_t at = 0; at < blocks; ++at) {
        for (int d = 0; d < components<dimension>; ++d)
          next.impulse[at].at[d] -= g[at].at[d] / lipschitz;
        project_euclidean(system.contacts.blocks[at], next.impulse[at].at);
      }
      next.velocity = system.product(next.impulse);
      ++report.products;
      // f(gamma) <= f(y) + g (gamma - y) + L/2 |gamma - y|^2, for a quadratic f.
      const auto u = space.velocity(next.velocity);
      if (!(space.difference_product(next.impulse, y, u, g) >
            lipschitz * space.difference_product(next.impulse, y, next.impulse, y)))
        break;
      lipschitz *= 2;
    }
    double next_theta = (-theta * theta + theta * std::sqrt(theta * theta + 4)) / 2;
    double beta = theta * (1 - theta) / (theta * theta + next_theta);
    if (space.difference_product(g, zero, next.impulse, gamma) > 0) {
      beta = 0;
      next_theta = 1;
    }
    for (std::size_t at = 0; at < blocks; ++at)
      for (int d = 0; d < components<dimension>; ++d)
        y[at].at[d] = next.impulse[at].at[d] + beta * (next.impulse[at].at[d] - gamma[at].at[d]);
    theta = next_theta;
    lipschitz *= 0.9;
    gamma = next.impulse;
    next.residual = system.residual(next.impulse, next.velocity);
    ++report.iterations;
    if (next.residual.relative < best.residual.relative) best = std::move(next);
  }
  return best;
}

template Candidate<1> apgd(const ContactSystem<1>&, const MethodSettings&, Candidate<1>,
                           SolverReport&);
template Candidate<3> apgd(const ContactSystem<3>&, const MethodSettings&, Candidate<3>,
                           SolverReport&);
template Candidate<levers> apgd(const ContactSystem<levers>&, const MethodSettings&,
                                Candidate<levers>, SolverReport&);

}  // namespace spall
