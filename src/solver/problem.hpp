// One step's contact problem: what the solvers read, and what they give back.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "domain/ghosts.hpp"
#include "solver/delassus_matrix.hpp"
#include "solver/friction_model.hpp"
#include "solver/report.hpp"
#include "spall/types.hpp"

namespace spall {

struct SolverSettings;  // solver/settings.hpp

/// Find impulses p (world frame, on j, opposite on i) and velocity changes dv, ds (s = r omega):
///
///   dv_j += w_j p,  dv_i -= w_i p,  ds += -2.5 w kappa (n x p) on both bodies
///   u = free_velocity + dv_j - dv_i - kappa (ds_i + ds_j) x n
///   p_n >= -cohesive_impulse, |p_t| <= mu (p_n + cohesive_impulse), and complementarity with u
///
/// With lever arms a, over the radius, from both centres to one common point, and turning factors
/// K = r^2 J^-1, bodies may have any inertia:
///
///   ds_j += K_j (a_j x p),  ds_i -= K_i (a_i x p)
///   u = free_velocity + dv_j - dv_i + ds_j x a_j - ds_i x a_i
///
/// Rows [0, owned) of the bodies are this rank's, then ghosts as in `ghosts`; a contact's j may be
/// `ground`. Contacts [0, boundary) have a ghost row and are evaluated on both ranks; a contact
/// counts in sums on the rank that owns row i.
///
/// With a `matrix` W in place of spheres, u = free_velocity + W p in each contact's own frame
/// (n, t1, t2): row c is owned contact c, which is the one contact (c, ground) with normal
/// (1, 0, 0); its velocity change is -W p. Masses and kappas mean nothing then.
struct ContactProblem {
  int dimension = 3;  ///< 1: no friction anywhere, normals only, no spins
  Index boundary = 0;
  std::span<const double> inverse_mass;  ///< 1/kg, owned and ghost rows; 0: never moves
  std::span<const Index> i, j;
  std::span<const Vec3> normal;  ///< from i to j
  std::span<const double> kappa;
  std::span<const Vec3> arm_i = {};     ///< in place of kappa where arms are given; dimension 3
  std::span<const Vec3> arm_j = {};     ///< of 0 at the ground
  std::span<const Mat3> turning = {};   ///< 1/kg, K of owned and ghost rows, symmetric; beside arms
  std::span<const Vec3> free_velocity;  ///< m/s: D^T v_free, with the bias b added along n
  std::span<const double> friction = {};          ///< mu; empty: none anywhere
  std::span<const double> cohesive_impulse = {};  ///< N s, >= 0; empty: none anywhere
  const DelassusMatrix* matrix = nullptr;

  bool has_arms() const { return !turning.empty(); }
  Index contacts() const { return static_cast<Index>(i.size()); }
  double friction_of(Index c) const { return friction.empty() ? 0 : friction[c]; }
  double cohesion_of(Index c) const { return cohesive_impulse.empty() ? 0 : cohesive_impulse[c]; }
};

/// 1/kg: the contact's own block D of the Delassus operator with lever arms, u = D p in the world's
/// frame.
Mat3 delassus_block(const ContactProblem& problem, Index c);

/// Velocity changes of one body by the impulses: one cache line.
struct alignas(64) VelocityChange {
  double linear[4] = {0, 0, 0, 0};   ///< dv, m/s; the fourth is always 0
  double angular[4] = {0, 0, 0, 0};  ///< ds = r d(omega), m/s
};

struct SolverResult {
  std::vector<VelocityChange> change;  ///< owned and ghost rows, ghosts current
  SolverReport report;
};

/// Solves for `impulse` (one a contact: the warm start and proximal centre in, the solution out;
/// the same bits on both ranks of a boundary contact). The warm start is scaled, between none and
/// all of it, to serve best. Throws Error on numbers that are not finite or out of range, and on a
/// method that cannot do the friction asked for. From `packed` on it reads bodies, normals and
/// masses alone of the problem: who calls may need the memory of the rest. Collective.
SolverResult solve(const ContactProblem& problem, const Ghosts& ghosts,
                   const SolverSettings& settings, std::vector<Vec3>& impulse,
                   const std::function<void()>& packed = {});

/// The residual of given impulses, made admissible first. Collective.
SolverReport evaluate(const ContactProblem& problem, const Ghosts& ghosts, FrictionModel friction,
                      const std::vector<Vec3>& impulse);

}  // namespace spall
