// Every sum runs over disjoint sets: clump, ejecta, impactor.
// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/deflection.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include "spall/error.hpp"

namespace spall {

namespace {

/// Half-apertures, in steps of 0.1 degrees, of the cones about `axis` with 50 and 90 % of sum m
/// |v|.
std::array<double, 2> cone_angles(const Comm& comm, std::span<const Vec3> velocity,
                                  std::span<const double> mass, const Vec3& axis) {
  constexpr int bins = 1800;
  std::vector<double> weight(bins, 0.0);
  for (std::size_t k = 0; k < velocity.size(); ++k) {
    // atan2 keeps small angles exact where acos would not.
    const double angle = std::atan2(velocity[k].cross(axis).norm(), velocity[k].dot(axis));
    const int bin = std::min(static_cast<int>(angle / pi * bins), bins - 1);
    weight[bin] += mass[k] * velocity[k].norm();
  }
  comm.sum(weight);
  double total = 0;
  for (double w : weight) total += w;
  const auto reached = [&](double part) {
    double sum = 0;
    int bin = 0;
    while (bin < bins && sum < part * total) sum += weight[bin++];
    return bin * 180.0 / bins;
  };
  return {reached(0.5), reached(0.9)};
}

constexpr std::array round_steps{1.0, 1.5, 2.0, 3.0, 5.0, 7.0};

/// m/s: the k-th of these times powers of ten; the 0th is 1.
double round_speed(int k) {
  constexpr int n = round_steps.size();
  const int decade = k >= 0 ? k / n : -((n - 1 - k) / n);
  const double digit = round_steps[static_cast<std::size_t>(k - n * decade)];
  // A quotient is the nearest double to its decimal, a product with 0.1 is not.
  return decade < 0 ? digit / std::pow(10.0, -decade) : digit * std::pow(10.0, decade);
}

std::vector<FasterThan> sum_by_speed(const Comm& comm, std::span<const double> speed,
                                     std::span<const double> mass, double fastest) {
  double slowest = infinity;
  for (double v : speed) slowest = std::min(slowest, v);
  slowest = comm.min(slowest);
  if (fastest == 0) return {};
  const double least = std::max(slowest, 1e-6 * fastest);
  int k = static_cast<int>(round_steps.size()) * static_cast<int>(std::floor(std::log10(least)));
  while (round_speed(k) >= least) --k;
  while (round_speed(k + 1) < least) ++k;
  std::vector<FasterThan> faster;
  std::vector<double> sums;
  for (; round_speed(k) < fastest; ++k) {
    faster.push_back({round_speed(k), 0, 0});
    double count = 0, above = 0;
    for (std::size_t b = 0; b < speed.size(); ++b) {
      if (speed[b] <= faster.back().speed) continue;
      count += 1;
      above += mass[b];
    }
    sums.insert(sums.end(), {count, above});
  }
  comm.sum(sums);
  for (std::size_t at = 0; at < faster.size(); ++at) {
    faster[at].count = sums[2 * at];
    faster[at].mass = sums[2 * at + 1];
  }
  return faster;
}

Ejecta measure_ejecta(const Comm& comm, std::span<const Vec3> velocity,
                      std::span<const double> mass, const Vec3& flight) {
  std::array<double, 7> sums{};
  std::vector<double> speed;
  double fastest = 0;
  for (std::size_t k = 0; k < velocity.size(); ++k) {
    const double back = std::max(0.0, -velocity[k].dot(flight));
    sums[0] += 1;
    sums[1] += mass[k];
    for (int d = 0; d < 3; ++d) sums[2 + d] += mass[k] * velocity[k][d];
    sums[5] += back;
    sums[6] += mass[k] * back;
    speed.push_back(velocity[k].norm());
    fastest = std::max(fastest, speed.back());
  }
  comm.sum(sums);
  Ejecta ejecta;
  ejecta.count = static_cast<std::int64_t>(sums[0]);
  ejecta.mass = sums[1];
  ejecta.momentum = {sums[2], sums[3], sums[4]};
  ejecta.v_ejecta = sums[5];
  ejecta.back_momentum = sums[6];
  ejecta.fastest = comm.max(fastest);
  ejecta.faster = sum_by_speed(comm, speed, mass, ejecta.fastest);
  const auto angles = cone_angles(comm, velocity, mass, ejecta.momentum.normalized());
  ejecta.cone_half = angles[0];
  ejecta.cone_most = angles[1];
  return ejecta;
}

/// From the rank that owns it, m/s.
Vec3 velocity_of_impactor(const Comm& comm, const Bodies& bodies, BodyId impactor) {
  std::array<double, 4> found{};
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.id[b] == impactor) {
      Eigen::Map<Vec3>(found.data()) = bodies.velocity[b];
      found[3] = 1;
    }
  comm.sum(found);
  require(found[3] == 1, "the impactor (body {}) is there {} times", impactor, found[3]);
  return Eigen::Map<Vec3>(found.data());
}

}  // namespace

double rigid_share(const BeforeImpact& before, double restitution) {
  const double ratio = before.struck_mass / before.impactor_mass;
  if (!std::isfinite(ratio)) return 0;
  return (1 + restitution) * (1 + restitution) * ratio / ((1 + ratio) * (1 + ratio));
}

BeforeImpact before_impact(const Comm& comm, const Bodies& bodies, BodyId impactor) {
  BeforeImpact before;
  before.impactor = impactor;
  std::array<double, 5> sums{};  // impactor's mass; target's mass and momentum
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.id[b] == impactor) {
      sums[0] += bodies.mass[b];
      continue;
    }
    if (!std::isfinite(bodies.mass[b])) continue;
    sums[1] += bodies.mass[b];
    for (int d = 0; d < 3; ++d) sums[2 + d] += bodies.mass[b] * bodies.velocity[b][d];
  }
  comm.sum(sums);
  before.impactor_mass = sums[0];
  before.target_mass = sums[1];
  before.target_velocity = Vec3(sums[2], sums[3], sums[4]) / sums[1];
  before.relative_velocity = velocity_of_impactor(comm, bodies, impactor) - before.target_velocity;
  return before;
}

/// The cosine of the angle from the flight beyond which a degree changes beta - 1 by 3 % and more.
constexpr double across = 0.5;
constexpr double round_off = 1e-9;  // of m U: no more has left

Deflection measure_deflection(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                              const Links& links, double gravity_constant,
                              const BeforeImpact& before) {
  Links within;  // the target
  for (std::size_t k = 0; k < links.i.size(); ++k)
    if (bodies.id[links.i[k]] != before.impactor && bodies.id[links.j[k]] != before.impactor) {
      within.i.push_back(links.i[k]);
      within.j.push_back(links.j[k]);
    }
  std::vector<BodyId> name = find_clumps(comm, ghosts, bodies, within);
  for (Index b = 0; b < bodies.owned; ++b)
    if (bodies.id[b] == before.impactor || !std::isfinite(bodies.mass[b])) name[b] = -1;

  Deflection result;
  const std::vector<Clump> heaviest = heaviest_clumps(comm, bodies, name, 1);
  require(!heaviest.empty(), "no target to measure: the impactor is alone");
  result.clump = add_bound_bodies(comm, bodies, gravity_constant, heaviest[0], name);

  bool lost = false;
  for (Index b = 0; b < bodies.owned; ++b)
    lost |= bodies.id[b] == before.struck && name[b] != result.clump.name;
  result.has_struck = !comm.any(lost);

  std::vector<Vec3> velocity;  // of the ejecta
  std::vector<double> mass;
  for (Index b = 0; b < bodies.owned; ++b)
    if (name[b] >= 0 && name[b] != result.clump.name) {
      velocity.push_back(bodies.velocity[b] - before.target_velocity);
      mass.push_back(bodies.mass[b]);
    }
  const Vec3 flight = before.direction();
  result.ejecta = measure_ejecta(comm, velocity, mass, flight);

  result.impactor_velocity =
      velocity_of_impactor(comm, bodies, before.impactor) - before.target_velocity;

  const double M = result.clump.mass, m = before.impactor_mass;
  const Vec3 U = before.relative_velocity, kept = m * result.impactor_velocity;
  result.dv_vector = result.clump.velocity - before.target_velocity;
  result.dv = result.dv_vector.dot(flight);
  result.beta_along = M * result.dv / (m * before.speed());
  const Vec3 left = kept + result.ejecta.momentum;
  const double share = left.norm() / (m * before.speed());
  if (share > round_off && std::abs(U.dot(left)) < across * U.norm() * left.norm())
    result.beta = std::numeric_limits<double>::quiet_NaN();
  else if (share > round_off)
    result.beta = M * result.dv_vector.dot(left) / (m * U.dot(left));
  result.dv_impactor = m * before.speed() / M;
  result.dv_rebound = -kept.dot(flight) / M;
  result.dv_ejecta = 0 - result.ejecta.momentum.dot(flight) / M;  // none is no -0
  result.closure = (M * result.dv_vector + left - m * U).norm() / (m * before.speed());
  return result;
}

}  // namespace spall
