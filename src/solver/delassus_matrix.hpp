// A Delassus matrix given as it is: W in 3x3 blocks, for contact problems not made of spheres.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "domain/ghosts.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// S = diag(a_n, a_t, a_t), 1/kg: what stands for a contact's diagonal block in all methods.
struct ContactMetric {
  double a_n = 0, a_t = 0;
};

/// The metric S of a diagonal block B in the order n, t1, t2. Projections stay in closed form only
/// where S treats both tangents alike and apart from the normal. So it starts from diag(B_nn, b,
/// b), with b the larger eigenvalue of B's tangential part. That leaves out the coupling of normal
/// and tangents, which a factor of 1 to 2 makes up for: S is the smallest multiple that is nowhere
/// below B. A sphere's block is met exactly.
ContactMetric bounding_metric(const Eigen::Matrix3d& block);

/// The same in closed form, of a block D in the world's frame: S = (1 + rho) diag(D_nn, b, b) is
/// nowhere below D with rho = |D_nt| / sqrt(D_nn b), as 2 p_n |D_nt| |p_t| <= rho (D_nn p_n^2 + b
/// |p_t|^2). Not the smallest multiple, but at most twice it.
ContactMetric bound_of(const Mat3& block, const Vec3& normal);

/// One number of W, at its row and column of the whole matrix.
struct MatrixEntry {
  std::int64_t row, column;
  double value;
};

/// Contacts [begin, begin + owned) of all, W's rows of them in blocks.
struct DelassusMatrix {
  std::int64_t begin = 0;
  Index owned = 0;
  Ghosts contacts;                     ///< of other ranks, that blocks of own rows reach
  std::vector<std::int64_t> start{0};  ///< blocks [start[c], start[c + 1]) are row c's
  std::vector<Index> column;           ///< owned or ghost contacts
  std::vector<Eigen::Matrix3d> block;
  std::vector<ContactMetric> metric;  ///< of owned contacts
  std::vector<double> outside;  ///< sum of |S_c^-1/2 W_cd S_d^-1/2| over contacts d of other ranks

  /// From any rank's share of the numbers, rows and columns 3 a contact in the order n, t1, t2;
  /// numbers at one place add up. Ranks own equal parts in the order of contacts. Throws Error
  /// where W is not symmetric or its diagonal negative. Collective.
  static DelassusMatrix assemble(const Comm& comm, std::int64_t contacts,
                                 const std::vector<MatrixEntry>& entries);
};

/// W's rows packed for the kernels: columns of blocks, each a half pack [n t1 t2 0].
template <class Real>
struct MatrixRows {
  struct Block {
    HalfOf<Real> column[3];
  };
  const Ghosts* contacts = nullptr;  ///< null: no matrix, bodies are spheres
  std::vector<std::int64_t> start;
  std::vector<Index> column;
  std::vector<Block> blocks;
  std::vector<double> outside;

  explicit operator bool() const { return contacts; }
};

/// In units of `unit` 1/kg.
MatrixRows<double> pack(const DelassusMatrix& matrix, double unit);
/// The same in less precision.
MatrixRows<float> round(const MatrixRows<double>& matrix);

}  // namespace spall
