// What every method works on: the packed problem, its product over ranks, its residual.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "spall/solver/contact_blocks.hpp"
#include "spall/solver/kernels.hpp"

namespace spall {

/// The natural map's residual of some impulses; see SolverReport.
struct Residual {
  double relative = 0;
  double relative_prox = 0;
  double max = 0;  ///< m/s
  double rms = 0;  ///< m/s
};

/// Impulses with their velocity changes (ghost rows current) and their residual.
template <int dimension>
struct Candidate {
  Impulses<dimension> impulse;
  Rows<dimension> velocity;
  Residual residual;
};

template <int dimension>
struct ContactSystem {
  const Ghosts& ghosts;
  FrictionModel friction;
  ContactBlocks<dimension> contacts;
  Impulses<dimension> centre;  ///< p_c of the proximal problem
  double prox = 0;             ///< its eps; 0: none
  double scale = 1;            ///< sqrt(sum R^T S^-1 R) at zero impulses
  std::int64_t count = 0;      ///< contacts over all ranks

  Rows<dimension> zero_rows() const { return Rows<dimension>(contacts.rows); }
  BlockRange boundary() const { return {0, contacts.boundary}; }
  BlockRange interior() const { return {contacts.boundary, contacts.blocks.size()}; }

  void gather_begin(Rows<dimension>& rows) const {
    ghosts.gather_begin(rows.data()->at, Row<dimension>::width);
  }
  void gather_end(Rows<dimension>& rows) const {
    ghosts.gather_end(rows.data()->at, Row<dimension>::width);
  }

  /// Sums of the impulses on owned rows, in impulse form; rows of other kinds hold anything.
  Rows<dimension> impulse_rows(const Impulses<dimension>& impulse) const;

  /// Velocities from sums of impulses; all rows current. Collective.
  Rows<dimension> velocity_rows(const Rows<dimension>& impulse_rows) const;

  /// Residual of impulses whose velocities are given. Collective.
  Residual residual(const Impulses<dimension>& impulse, const Rows<dimension>& velocity) const;
};

/// Minimises from `start` until the (proximal) residual falls to the tolerance, with one product
/// an iteration; gives back the best iterate seen. Collective.
template <int dimension>
Candidate<dimension> accelerated_gradient(const ContactSystem<dimension>& system,
                                          const SolverSettings& settings,
                                          Candidate<dimension> start, SolverReport& report);

/// Calls f with the friction model as a compile-time constant.
template <class F>
auto with_friction(FrictionModel model, F&& f) {
  return model == FrictionModel::coulomb
             ? f(std::integral_constant<FrictionModel, FrictionModel::coulomb>{})
             : f(std::integral_constant<FrictionModel, FrictionModel::convex>{});
}

}  // namespace spall
