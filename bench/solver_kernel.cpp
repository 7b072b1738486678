// Seconds a contact and iteration of the accelerated method's kernels, on a disordered lattice.
// SPDX-License-Identifier: BSD-3-Clause
#include <benchmark/benchmark.h>

#include <random>

#include "solver/contact_system.hpp"
#include "spall/comm.hpp"

namespace spall {
namespace {

/// A simple-cubic block of bodies with up to 3 later neighbours each, normals disordered, in
/// natural order: as many contacts a body and as good an order as a sorted pile.
struct Block {
  std::vector<double> inverse_mass;
  std::vector<Index> i, j;
  std::vector<Vec3> normal, free_velocity;
  std::vector<double> kappa, friction, cohesive_impulse;

  explicit Block(Index contacts) {
    const Index n = static_cast<Index>(std::cbrt(contacts / 3.0));
    inverse_mass.assign(n * n * n, 1);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(-0.2, 0.2);
    const auto add = [&](Index a, Index b, Vec3 axis) {
      i.push_back(a);
      j.push_back(b);
      const Vec3 disorder(uniform(random), uniform(random), uniform(random));
      normal.push_back((axis + disorder).normalized());
      free_velocity.emplace_back(uniform(random), uniform(random), uniform(random));
    };
    for (Index z = 0; z < n; ++z)
      for (Index y = 0; y < n; ++y)
        for (Index x = 0; x < n; ++x) {
          const Index at = (z * n + y) * n + x;
          if (x + 1 < n) add(at, at + 1, Vec3::UnitX());
          if (y + 1 < n) add(at, at + n, Vec3::UnitY());
          if (z + 1 < n) add(at, at + n * n, Vec3::UnitZ());
        }
    kappa.assign(i.size(), 1);
    friction.assign(i.size(), 0.5);
    cohesive_impulse.assign(i.size(), 0);
  }

  ContactProblem problem(int dimension) const {
    return {.dimension = dimension,
            .inverse_mass = inverse_mass,
            .i = i,
            .j = j,
            .normal = normal,
            .kappa = kappa,
            .free_velocity = free_velocity,
            .friction = friction,
            .cohesive_impulse = cohesive_impulse};
  }
};

template <class Real, int dimension, FrictionModel model>
void iteration(benchmark::State& state) {
  const Block block(static_cast<Index>(state.range(0)));
  const ContactProblem problem = block.problem(dimension);
  const auto exact = pack<dimension>(problem, {}, static_cast<Index>(block.inverse_mass.size()));
  const auto contacts = [&] {
    if constexpr (std::is_same_v<Real, float>)
      return round(exact);
    else
      return exact;
  }();
  Impulses<dimension, Real> iterate(contacts.blocks.size()), before = iterate;
  Rows<dimension, Real> sums(contacts.rows), sums_before = sums, velocity = sums;
  for (auto _ : state) {
    StepSums own;
    step_contacts<model, false>(contacts, {0, contacts.blocks.size()},
                                GradientStep<Real>{0.5, 0.99, 0.25}, velocity.data(),
                                iterate.data(), before.data(), sums_before.data(), own);
    std::swap(iterate, before);
    std::swap(sums, sums_before);
    double curvature =
        extrapolate_rows(contacts, Real(0.5), sums.data(), sums_before.data(), velocity.data());
    benchmark::DoNotOptimize(curvature);
    benchmark::DoNotOptimize(own);
  }
  state.counters["s_a_contact"] =
      benchmark::Counter(problem.contacts(), benchmark::Counter::kIsIterationInvariantRate |
                                                 benchmark::Counter::kInvert);
}

BENCHMARK(iteration<float, 3, FrictionModel::coulomb>)->Arg(30000)->Arg(300000)->Arg(3000000);
BENCHMARK(iteration<double, 3, FrictionModel::coulomb>)->Arg(30000)->Arg(300000)->Arg(3000000);
BENCHMARK(iteration<float, 3, FrictionModel::convex>)->Arg(30000)->Arg(300000)->Arg(3000000);
BENCHMARK(iteration<float, 1, FrictionModel::coulomb>)->Arg(30000)->Arg(300000)->Arg(3000000);
BENCHMARK(iteration<double, 1, FrictionModel::coulomb>)->Arg(30000)->Arg(300000)->Arg(3000000);

}  // namespace
}  // namespace spall

BENCHMARK_MAIN();
