// One product an iteration: a quadratic's values along a direction need no second one.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <deque>
#include <utility>

#include "solver/methods.hpp"

namespace spall {
namespace {

constexpr std::size_t memory = 10;      // values that a new one may not exceed all of
constexpr double sufficient = 1e-4;     // part of the predicted decrease
constexpr int iterations_a_check = 10;  // fresh product and residual

template <class Blocks>
void add_scaled(Blocks& to, double factor, const Blocks& what) {
  for (std::size_t at = 0; at < to.size(); ++at)
    for (std::size_t d = 0; d < std::size(to[at].at); ++d) to[at].at[d] += factor * what[at].at[d];
}

}  // namespace

template <int dimension>
Candidate<dimension> spectral_gradient(const ContactSystem<dimension>& system,
                                       const MethodSettings& settings, Candidate<dimension> start,
                                       SolverReport& report) {
  Candidate<dimension> best = std::move(start);
  Impulses<dimension, double> p = best.impulse;
  Impulses<dimension, double> gradient = system.gradient(best.velocity);
  std::deque<double> values{0};  // of the objective, from the start's
  double step = 1;

  while (!used_up(settings, report) && !met(best.residual, system, settings)) {
    Impulses<dimension, double> direction = p;
    add_scaled(direction, -step, gradient);
    for (std::size_t at = 0; at < p.size(); ++at) {
      Lanes to[components<dimension>];
      project<FrictionModel::convex>(system.contacts.blocks[at], direction[at].at, to);
      for (int d = 0; d < components<dimension>; ++d) direction[at].at[d] = to[d] - p[at].at[d];
    }
    const auto change = system.gradient_change(system.product(direction));
    const double slope = system.metric_product(direction, gradient);
    const double curvature = system.metric_product(direction, change);
    const double length2 = system.metric_product(direction, direction);
    const double change2 = system.metric_product(change, change);
    ++report.products;
    ++report.iterations;

    double part = 1;
    const double worst = *std::max_element(values.begin(), values.end());
    if (values.back() + slope + curvature / 2 > worst + sufficient * slope)
      part = std::min(1.0, -slope / curvature);
    values.push_back(values.back() + part * slope + part * part * curvature / 2);
    if (values.size() > memory) values.pop_front();
    add_scaled(p, part, direction);
    add_scaled(gradient, part, change);
    if (curvature > 0)
      step = report.iterations % 2 == 0 ? length2 / curvature : curvature / change2;

    if (report.iterations % iterations_a_check == 0 || used_up(settings, report)) {
      Candidate<dimension> now = system.evaluate(p);
      ++report.products;
      gradient = system.gradient(now.velocity);
      if (now.residual.relative < best.residual.relative) best = std::move(now);
    }
  }
  return best;
}

template Candidate<1> spectral_gradient(const ContactSystem<1>&, const MethodSettings&,
                                        Candidate<1>, SolverReport&);
template Candidate<3> spectral_gradient(const ContactSystem<3>&, const MethodSettings&,
                                        Candidate<3>, SolverReport&);
template Candidate<levers> spectral_gradient(const ContactSystem<levers>&, const MethodSettings&,
                                             Candidate<levers>, SolverReport&);

}  // namespace spall
