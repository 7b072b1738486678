// A contact problem packed for the kernels: contacts in blocks of eight, bodies in rows.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "spall/solver/pack.hpp"
#include "spall/solver/problem.hpp"

namespace spall {

/// A body's vector in the kernels. Velocity form is [dv 0 | ds 0]; impulse form is
/// [sum of +-p, 0 | sum of kappa n x p, 0], so that velocity = [w, w, w, 0 | -2.5 w x 3, 0] times
/// it. Without friction (dimension 1) bodies have no second half.
template <int dimension>
struct alignas(dimension == 1 ? 32 : 64) Row {
  static constexpr int width = dimension == 1 ? 4 : 8;
  double at[width];
};
template <int dimension>
using Rows = std::vector<Row<dimension>>;

/// Impulses (or their like) of eight contacts: world frame (dimension 3), normal (dimension 1).
template <int dimension>
struct ImpulseBlock {
  Pack at[dimension];
};
template <int dimension>
using Impulses = std::vector<ImpulseBlock<dimension>>;

/// Eight contacts. The metric of the block-Jacobi step is S = diag(a_n, a_t, a_t), the diagonal
/// block of the Delassus operator, in float: any positive metric near it serves. All that a
/// solution depends on is double.
template <int dimension>
struct ContactBlock;

template <>
struct ContactBlock<1> {
  Pack normal[3];
  Pack velocity[1];  ///< S^-1 b - eps p_c: free velocity and proximal centre, as an impulse
  Pack cohesion;
  FloatPack a_n, inverse_a_n;
  Index i[lanes], j[lanes];
};

template <>
struct ContactBlock<3> {
  Pack normal[3];
  Pack kappa;
  Pack velocity[3];  ///< as above
  Pack cohesion;
  Pack friction;
  FloatPack a_n, a_t, inverse_a_n, inverse_a_t;
  Index i[lanes], j[lanes];
};

/// Boundary contacts first, then interior ones, each part filled up to whole blocks with contacts
/// of the zero row with itself. Rows: owned, ghosts, then one zero row that stands for `ground`.
template <int dimension>
struct ContactBlocks {
  std::vector<ContactBlock<dimension>> blocks;
  std::size_t boundary = 0;  ///< blocks
  Index owned = 0;
  Index rows = 0;                    ///< with the zero row
  std::vector<double> inverse_mass;  ///< of owned rows
};

template <int dimension>
ContactBlocks<dimension> pack(const ContactProblem& problem, Index owned);

/// Adds -eps p_c to the free velocities: the proximal problem then differs from the plain one by
/// eps y in the gradient alone.
template <int dimension>
void add_centre(ContactBlocks<dimension>& contacts, const Impulses<dimension>& centre, double prox);

template <int dimension>
Impulses<dimension> pack_impulses(const ContactProblem& problem, const std::vector<Vec3>& impulse);

template <int dimension>
void unpack_impulses(const ContactProblem& problem, const Impulses<dimension>& packed,
                     std::vector<Vec3>& impulse);

}  // namespace spall
