// A contact problem packed for the kernels: contacts in blocks of eight, bodies in rows.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "solver/problem.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// What contacts are to the kernels: `dimension` is 1 (normals alone), 3 (two spheres with
/// friction) or this: any two bodies, with friction and lever arms.
inline constexpr int levers = 6;
/// Numbers of an impulse.
template <int dimension>
inline constexpr int components = dimension == 1 ? 1 : 3;

/// A body's vector in the kernels: [dv 0 | ds 0] in velocity form, and in impulse form
/// [sum of +-p, 0 | sum of kappa n x p, 0], so that velocity = w [1 1 1 1 | -2.5 x 4] impulse.
/// Without friction (dimension 1) bodies have no second half. With lever arms the second half is
/// the sum of +-a x p, of which the turning factor makes ds.
template <int dimension, class Real>
struct Row {
  using Vector = std::conditional_t<dimension == 1, HalfOf<Real>, LanesOf<Real>>;
  static constexpr int width = dimension == 1 ? 4 : 8;
  Vector at;
};
template <int dimension, class Real>
using Rows = std::vector<Row<dimension, Real>>;

/// Impulses (or their like) of eight contacts: world frame (dimension 3), normal (dimension 1).
template <int dimension, class Real>
struct ImpulseBlock {
  LanesOf<Real> at[components<dimension>];
};
template <int dimension, class Real>
using Impulses = std::vector<ImpulseBlock<dimension, Real>>;

/// Eight contacts. S = diag(a_n, a_t, a_t) is the metric of all methods: the diagonal block of the
/// Delassus operator, or with lever arms a bound of it. Float serves, as any positive metric near
/// it does.
template <int dimension, class Real>
struct ContactBlock;

template <class Real>
struct ContactBlock<1, Real> {
  LanesOf<Real> normal[3];
  LanesOf<Real> free_impulse[1];  ///< S^-1 b - eps p_c
  LanesOf<Real> cohesion;
  FloatLanes a_n, inverse_a_n;
  Index i[lane_count], j[lane_count];
};

template <class Real>
struct ContactBlock<3, Real> {
  LanesOf<Real> normal[3];
  LanesOf<Real> kappa;
  LanesOf<Real> free_impulse[3];  ///< S^-1 b - eps p_c
  LanesOf<Real> cohesion;
  LanesOf<Real> friction;
  FloatLanes a_n, a_t, inverse_a_n, inverse_a_t;
  Index i[lane_count], j[lane_count];
};

template <class Real>
struct ContactBlock<levers, Real> : ContactBlock<3, Real> {
  LanesOf<Real> arm_i[3], arm_j[3];  ///< over the radius
};

/// What a row is multiplied with, in the order of its numbers: the first half with one number, the
/// second with a symmetric matrix.
template <class Real>
struct RowMatrix {
  LanesOf<Real> diagonal;  ///< [c c c 0 | xx yy zz 0]
  LanesOf<Real> beside;    ///< [0 0 0 0 | xy yz zx 0]
};
/// How a body moves: [1/m | K] and its inverse, or zeros where it never does.
template <class Real>
struct Turning {
  RowMatrix<Real> factor, inverse;
};

/// Boundary contacts first, then interior ones, each part filled up to whole blocks with contacts
/// of the zero row with itself. Rows: owned, ghosts, then one zero row that stands for `ground`.
/// In units of powers of two, chosen so that squares fit into floats.
template <int dimension, class Real>
struct ContactBlocks {
  std::vector<ContactBlock<dimension, Real>> blocks;
  std::size_t boundary = 0;  ///< blocks
  Index owned = 0;
  Index rows = 0;                      ///< with the zero row
  std::vector<Real> inverse_mass;      ///< of owned rows
  std::vector<Turning<Real>> turning;  ///< of owned rows, with lever arms
  MatrixRows<Real> matrix;             ///< in place of masses
};

/// The units of packed numbers: impulses in `impulse` N s, velocities in `velocity` m/s. Powers of
/// two near what the problem holds, so that floats can hold squares and no bits depend on units.
struct PackedUnits {
  double impulse = 1;
  double velocity = 1;
};

/// Collective.
PackedUnits choose_units(const ContactProblem& problem, const Comm& comm);

template <int dimension>
ContactBlocks<dimension, double> pack(const ContactProblem& problem, const PackedUnits& units,
                                      Index owned);

/// The free impulses of `from`, rounded.
template <int dimension, class Real>
void take_free_impulses(const ContactBlocks<dimension, double>& from,
                        ContactBlocks<dimension, Real>& to) {
  for (std::size_t at = 0; at < to.blocks.size(); ++at)
    for (int d = 0; d < components<dimension>; ++d)
      to.blocks[at].free_impulse[d] = convert<Real>(from.blocks[at].free_impulse[d]);
}

/// The same in less precision.
template <int dimension>
ContactBlocks<dimension, float> round(const ContactBlocks<dimension, double>& contacts);

template <int dimension, class To, class From>
Impulses<dimension, To> convert_impulses(const Impulses<dimension, From>& from) {
  Impulses<dimension, To> to(from.size());
  for (std::size_t at = 0; at < from.size(); ++at)
    for (int d = 0; d < components<dimension>; ++d) to[at].at[d] = convert<To>(from[at].at[d]);
  return to;
}

/// Impulses of contacts between bodies that never move are taken as zero.
template <int dimension>
Impulses<dimension, double> pack_impulses(const ContactProblem& problem, const PackedUnits& units,
                                          const std::vector<Vec3>& impulse);

template <int dimension>
void unpack_impulses(const ContactProblem& problem, const PackedUnits& units,
                     const Impulses<dimension, double>& packed, std::vector<Vec3>& impulse);

}  // namespace spall
