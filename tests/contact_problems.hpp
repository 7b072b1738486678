// Contact problems for tests: made whole on every rank, cut into pieces at will.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <random>

#include "solver/problem.hpp"
#include "solver/settings.hpp"
#include "testing.hpp"

namespace spall {

/// Spheres and their contacts, the same on every rank.
struct WholeProblem {
  int dimension = 3;
  std::vector<double> inverse_mass;
  std::vector<Index> i, j;
  std::vector<Vec3> normal;
  std::vector<double> kappa;
  std::vector<Vec3> free_velocity;
  std::vector<double> friction, cohesive_impulse;

  Index bodies() const { return static_cast<Index>(inverse_mass.size()); }
  Index contacts() const { return static_cast<Index>(i.size()); }

  void add(Index a, Index b, Vec3 n, Vec3 u, double mu = 0, double s = 0, double k = 1) {
    i.push_back(a);
    j.push_back(b);
    normal.push_back(n);
    kappa.push_back(k);
    free_velocity.push_back(u);
    friction.push_back(mu);
    cohesive_impulse.push_back(s);
  }
};

/// This rank's piece of a whole problem, and the way back.
struct Piece {
  std::vector<Index> body;     ///< of the whole problem, a row
  std::vector<Index> contact;  ///< of the whole problem, a contact
  Index owned = 0;
  WholeProblem own;
  Index boundary = 0;
  Ghosts ghosts;

  /// Body b belongs to rank owner[b].
  Piece(const WholeProblem& whole, const Comm& comm, const std::vector<int>& owner) {
    std::map<Index, Index> row;
    for (Index b = 0; b < whole.bodies(); ++b)
      if (owner[b] == comm.rank) {
        row[b] = static_cast<Index>(body.size());
        body.push_back(b);
      }
    owned = static_cast<Index>(body.size());
    std::vector<Index> row_at_owner(whole.bodies()), rows_of(comm.size);
    for (Index b = 0; b < whole.bodies(); ++b) row_at_owner[b] = rows_of[owner[b]]++;

    std::vector<Origin> origins;
    const auto find_row = [&](Index b) {
      if (b == ground) return ground;
      const auto [it, is_new] = row.try_emplace(b, static_cast<Index>(body.size()));
      if (is_new) {
        body.push_back(b);
        origins.push_back({owner[b], row_at_owner[b]});
      }
      return it->second;
    };
    own.dimension = whole.dimension;
    for (bool want_boundary : {true, false}) {
      for (Index c = 0; c < whole.contacts(); ++c) {
        const Index a = whole.i[c], b = whole.j[c];
        const bool has_i = owner[a] == comm.rank, has_j = b == ground || owner[b] == comm.rank;
        const bool mine = has_i || (b != ground && has_j);
        if (!mine || want_boundary == (has_i && has_j)) continue;
        contact.push_back(c);
        own.add(find_row(a), find_row(b), whole.normal[c], whole.free_velocity[c],
                whole.friction[c], whole.cohesive_impulse[c], whole.kappa[c]);
      }
      if (want_boundary) boundary = own.contacts();
    }
    for (Index b : body) own.inverse_mass.push_back(whole.inverse_mass[b]);
    ghosts = Ghosts(comm, owned, origins);
  }

  ContactProblem problem() const {
    return {.dimension = own.dimension,
            .boundary = boundary,
            .inverse_mass = own.inverse_mass,
            .i = own.i,
            .j = own.j,
            .normal = own.normal,
            .kappa = own.kappa,
            .free_velocity = own.free_velocity,
            .friction = own.friction,
            .cohesive_impulse = own.cohesive_impulse};
  }
};

/// Everything a solve gave, collected on every rank in the whole problem's order.
struct Solved {
  std::vector<Vec3> impulse;
  std::vector<Vec3> linear, angular;  ///< dv, ds
  SolverReport report;
  bool same_on_both_ranks = true;  ///< bit for bit, of impulses and ghost rows
};

inline Solved solve_whole(const WholeProblem& whole, const SolverSettings& settings,
                          std::vector<int> owner = {}, std::vector<Vec3> start = {}) {
  const Comm comm = testing_world();
  if (owner.empty()) owner.assign(whole.bodies(), 0);
  if (start.empty()) start.assign(whole.contacts(), Vec3::Zero());
  const Piece piece(whole, comm, owner);
  std::vector<Vec3> impulse;
  for (Index c : piece.contact) impulse.push_back(start[c]);
  const SolverResult result = solve(piece.problem(), piece.ghosts, settings, impulse);

  Solved all;
  all.report = result.report;
  const auto collect = [&](Index size, auto&& own_value, Index own_size, const auto& place,
                           auto&& is_mine) {
    std::vector<Vec3> values(size, Vec3::Zero());
    for (Index k = 0; k < own_size; ++k)
      if (is_mine(k)) values[place[k]] = own_value(k);
    if (size > 0) comm.sum(std::span<double>(values.data()->data(), 3 * size));
    for (Index k = 0; k < own_size; ++k)
      if (values[place[k]] != own_value(k)) all.same_on_both_ranks = false;
    return values;
  };
  const Index rows = static_cast<Index>(piece.body.size());
  all.impulse = collect(
      whole.contacts(), [&](Index c) { return impulse[c]; }, piece.own.contacts(), piece.contact,
      [&](Index c) { return piece.own.i[c] < piece.owned; });
  all.linear = collect(
      whole.bodies(), [&](Index b) { return Vec3(result.change[b].linear); }, rows, piece.body,
      [&](Index b) { return b < piece.owned; });
  all.angular = collect(
      whole.bodies(), [&](Index b) { return Vec3(result.change[b].angular); }, rows, piece.body,
      [&](Index b) { return b < piece.owned; });
  all.same_on_both_ranks = !comm.any(!all.same_on_both_ranks);
  return all;
}

/// Bodies dealt out at random: the worst of all partitions, and all ranks but the last get some.
inline std::vector<int> random_owners(Index bodies, int ranks) {
  std::mt19937_64 random(7);
  std::vector<int> owner(bodies);
  for (int& r : owner) r = static_cast<int>(random() % ranks);
  return owner;
}

/// A shaken block of n^3 spheres under gravity on the ground, its kappas and normals those of its
/// positions. Positions and radii are given back where asked for.
inline WholeProblem shaken_block(int n, double mu, double s, std::vector<Vec3>* positions = nullptr,
                                 std::vector<double>* radii = nullptr) {
  WholeProblem whole;
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<Vec3> x;
  std::vector<double> r;
  for (int c = 0; c < n; ++c)
    for (int b = 0; b < n; ++b)
      for (int a = 0; a < n; ++a) {
        x.emplace_back(a + 0.12 * uniform(random), b + 0.12 * uniform(random),
                       c + 0.12 * uniform(random));
        r.push_back(0.5 + 0.05 * uniform(random));
        whole.inverse_mass.push_back(1 / (r.back() * r.back() * r.back()));
      }
  const Index bodies = whole.bodies();
  for (Index a = 0; a < bodies; ++a) {
    for (Index b = a + 1; b < bodies; ++b) {
      const Vec3 d = x[b] - x[a];
      const double distance = d.norm(), reach = r[a] + r[b];
      if (distance > 1.15 * reach) continue;
      const Vec3 shake(uniform(random), uniform(random), uniform(random));
      whole.add(a, b, d / distance, 0.3 * shake, mu, s, distance / reach);
    }
    if (x[a].z() < 0.5) whole.add(a, ground, -Vec3::UnitZ(), Vec3(0, 0, 1), mu, s);
  }
  if (positions) *positions = x;
  if (radii) *radii = r;
  return whole;
}

/// Block (c, e) of the Delassus matrix: what a unit impulse of contact e does to u of contact c,
/// through every body that both touch.
inline Eigen::Matrix3d delassus_block(const WholeProblem& whole, Index c, Index e) {
  const auto lever = [&](Index k) {
    const Vec3 n = whole.kappa[k] * whole.normal[k];
    Eigen::Matrix3d m;  // kappa n x
    m << 0, -n[2], n[1], n[2], 0, -n[0], -n[1], n[0], 0;
    return m;
  };
  Eigen::Matrix3d block = Eigen::Matrix3d::Zero();
  for (const Index b : {whole.i[c], whole.j[c]}) {
    if (b == ground || (b != whole.i[e] && b != whole.j[e])) continue;
    const double sign = (b == whole.i[c]) == (b == whole.i[e]) ? 1 : -1;
    block += whole.inverse_mass[b] *
             (sign * Eigen::Matrix3d::Identity() + 2.5 * lever(c) * lever(e).transpose());
  }
  return block;
}

}  // namespace spall
