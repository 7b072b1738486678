// Eigenvalues and eigenvectors of some symmetric tensors at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solid/tensors.hpp"

namespace spall {

struct LaneEigen {
  PairLanes value[3];  ///< in no order
  LaneTensor vector;   ///< its columns, of length 1

  /// The symmetric tensors with these eigenvectors and other eigenvalues.
  LaneTensor with(const PairLanes (&values)[3]) const {
    LaneTensor t;
    for (int i = 0; i < 3; ++i)
      for (int j = i; j < 3; ++j) {
        PairLanes sum{};
        for (int e = 0; e < 3; ++e) sum += values[e] * vector.at[i][e] * vector.at[j][e];
        t.at[i][j] = t.at[j][i] = sum;
      }
    return t;
  }
};

/// By rotations of two axes after two, each of which makes one element off the diagonal vanish,
/// until round-off is left of them all: cyclic Jacobi, of second order (Golub & Van Loan, Matrix
/// Computations, 4th ed., 8.5). Relative error of the largest eigenvalue: some 1e-15.
inline LaneEigen eigen_of(LaneTensor a) {
  constexpr double round_off = 1e-15;
  constexpr int most_passes = 10;  // four or five do
  LaneEigen found;
  found.vector = LaneTensor::diagonal(spread_pairs(1));
  LaneTensor& v = found.vector;
  const PairLanes none{}, error = round_off * round_off * contracted(a, a);
  const auto rotate = [](LaneTensor& t, int row, int p, int q, const PairLanes& c,
                         const PairLanes& s) {
    const PairLanes old = t.at[row][p];
    t.at[row][p] = c * old - s * t.at[row][q];
    t.at[row][q] = s * old + c * t.at[row][q];
  };
  for (int pass = 0; pass < most_passes; ++pass) {
    const PairLanes x = a.at[1][2], y = a.at[0][2], z = a.at[0][1];
    if (!any_lane(x * x + y * y + z * z > error)) break;
    for (int r = 0; r < 3; ++r) {
      const int p = (r + 1) % 3, q = (r + 2) % 3;
      const PairLanes off = a.at[p][q], apart = a.at[q][q] - a.at[p][p];
      const PairLanes root = root_of(apart * apart + 4.0 * off * off);
      const PairLanes below = select(apart < 0.0, apart - root, apart + root);
      const PairLanes tangent = select(root > 0.0, 2.0 * off / below, none);
      const PairLanes c = inverse_sqrt(1.0 + tangent * tangent), s = tangent * c;
      a.at[p][p] -= tangent * off;
      a.at[q][q] += tangent * off;
      a.at[p][q] = a.at[q][p] = none;
      rotate(a, r, p, q, c, s);
      a.at[p][r] = a.at[r][p];
      a.at[q][r] = a.at[r][q];
      for (int row = 0; row < 3; ++row) rotate(v, row, p, q, c, s);
    }
  }
  for (int e = 0; e < 3; ++e) found.value[e] = a.at[e][e];
  return found;
}

}  // namespace spall
