// What every method works on: the packed problem, its product over ranks, its residual.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solver/contact_blocks.hpp"
#include "solver/kernels.hpp"

namespace spall {

/// The natural map's residual of some impulses; see SolverReport.
struct Residual {
  double relative = 0;
  double relative_prox = 0;
  double max = 0;       ///< m/s
  double max_prox = 0;  ///< m/s
  double rms = 0;       ///< m/s
  double norm = 0;      ///< |p|_S over the residual at zero impulses
};

/// Impulses with their velocity changes (ghost rows current) and their residual.
template <int dimension>
struct Candidate {
  Impulses<dimension, double> impulse;
  Rows<dimension, double> velocity;
  Residual residual;
};

template <int dimension>
struct ContactSystem {
  using DoubleRows = Rows<dimension, double>;
  using DoubleImpulses = Impulses<dimension, double>;

  const Ghosts& ghosts;
  FrictionModel friction;
  PackedUnits units;
  ContactBlocks<dimension, double> contacts;
  DoubleImpulses centre;                 ///< p_c of the proximal problem
  std::vector<std::uint8_t> fresh = {};  ///< a bit a contact of each block: p_c follows the iterate
  bool none_holds = true;  ///< all of them follow: no impulses of an earlier step serve this one
  double speed_tolerance = 0;  ///< m/s, on |R_c| of the proximal problem
  double prox = 0;             ///< its eps; 0: none
  double scale = 1;            ///< sqrt(sum R^T S^-1 R) at zero impulses, packed units
  std::int64_t count = 0;      ///< contacts over all ranks

  BlockRange boundary() const { return {0, contacts.boundary}; }
  BlockRange interior() const { return {contacts.boundary, contacts.blocks.size()}; }

  /// Stays near `impulse` with weight `eps`. A contact that comes with no impulse has nothing to
  /// stay near: its centre follows. Where `none_holds` all of them follow. The free impulses get
  /// -eps p_c: the proximal problem then differs from the plain one by eps y in the gradient alone.
  void stay_near(const DoubleImpulses& impulse, double eps);

  /// Centres that follow become `iterate`.
  void follow(const DoubleImpulses& iterate);

  /// Impulses with their velocities and residual. Collective.
  Candidate<dimension> evaluate(DoubleImpulses impulse) const;

  /// Velocities of all rows by impulses: the product with the Delassus operator, but for its last
  /// step. Collective.
  DoubleRows product(const DoubleImpulses& impulse) const;

  /// The last step: S^-1 D^T velocity, with S^-1 b (the gradient) or without.
  DoubleImpulses gradient(const DoubleRows& velocity) const;
  DoubleImpulses gradient_change(const DoubleRows& velocity) const;

  /// a . S b over all contacts and ranks. Collective.
  double metric_product(const DoubleImpulses& a, const DoubleImpulses& b) const;

  /// Residual of impulses whose velocities are given: no product. Collective.
  Residual residual(const DoubleImpulses& impulse, const DoubleRows& velocity) const;
};

/// Starts or ends the exchange of ghost rows.
template <int dimension, class Real>
void gather_begin(const Ghosts& ghosts, Rows<dimension, Real>& rows) {
  constexpr int width = sizeof(rows[0]) / sizeof(double);
  ghosts.gather_begin(reinterpret_cast<double*>(rows.data()), width);
}
template <int dimension, class Real>
void gather_end(const Ghosts& ghosts, Rows<dimension, Real>& rows) {
  constexpr int width = sizeof(rows[0]) / sizeof(double);
  ghosts.gather_end(reinterpret_cast<double*>(rows.data()), width);
}

/// Rows [-p 0 | 0] of owned contacts become [-p 0 | -W p 0]. Collective.
template <class Real>
void multiply(const MatrixRows<Real>& matrix, Rows<3, Real>& rows);

/// Completes rows of impulses by the matrix where there is one. Collective.
template <int dimension, class Real>
void complete_rows(const ContactBlocks<dimension, Real>& contacts, Rows<dimension, Real>& rows) {
  if constexpr (dimension == 3)
    if (contacts.matrix) multiply(contacts.matrix, rows);
}

/// Calls f with the friction model as a compile-time constant.
template <class F>
auto with_friction(FrictionModel model, F&& f) {
  return model == FrictionModel::coulomb
             ? f(std::integral_constant<FrictionModel, FrictionModel::coulomb>{})
             : f(std::integral_constant<FrictionModel, FrictionModel::convex>{});
}

/// Projects every impulse.
template <int dimension>
void make_admissible(const ContactSystem<dimension>& system, Impulses<dimension, double>& impulse) {
  with_friction(system.friction, [&](auto model) {
    for (std::size_t at = 0; at < impulse.size(); ++at) {
      Lanes p[components<dimension>];
      project<model()>(system.contacts.blocks[at], impulse[at].at, p);
      std::copy_n(p, components<dimension>, impulse[at].at);
    }
  });
}

}  // namespace spall
