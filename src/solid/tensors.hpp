// Tensors of some bodies at once: three by three lanes.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solid/rows.hpp"

namespace spall {

struct LaneTensor {
  PairLanes at[3][3];

  static LaneTensor diagonal(const PairLanes& d) {
    LaneTensor t{};
    for (int k = 0; k < 3; ++k) t.at[k][k] = d;
    return t;
  }
  PairLanes trace() const { return at[0][0] + at[1][1] + at[2][2]; }
  LaneTensor transposed() const {
    LaneTensor t;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) t.at[i][j] = at[j][i];
    return t;
  }

  friend LaneTensor operator+(LaneTensor a, const LaneTensor& b) {
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) a.at[i][j] += b.at[i][j];
    return a;
  }
  friend LaneTensor operator*(const PairLanes& factor, LaneTensor a) {
    for (auto& row : a.at)
      for (PairLanes& element : row) element *= factor;
    return a;
  }
  friend LaneTensor operator*(const LaneTensor& a, const LaneTensor& b) {
    LaneTensor c;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        c.at[i][j] = a.at[i][0] * b.at[0][j] + a.at[i][1] * b.at[1][j] + a.at[i][2] * b.at[2][j];
    return c;
  }
};

/// a : b.
inline PairLanes contracted(const LaneTensor& a, const LaneTensor& b) {
  PairLanes sum{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) sum += a.at[i][j] * b.at[i][j];
  return sum;
}

inline LaneTensor select(const PairMask& mask, LaneTensor a, const LaneTensor& b) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) a.at[i][j] = select(mask, a.at[i][j], b.at[i][j]);
  return a;
}

/// The adjugate: the inverse times the determinant.
inline LaneTensor adjugate(const LaneTensor& t) {
  LaneTensor c;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      c.at[j][i] = t.at[i1][j1] * t.at[i2][j2] - t.at[i1][j2] * t.at[i2][j1];
    }
  return c;
}
/// By a tensor's adjugate.
inline PairLanes determinant(const LaneTensor& t, const LaneTensor& adjugate) {
  return t.at[0][0] * adjugate.at[0][0] + t.at[0][1] * adjugate.at[1][0] +
         t.at[0][2] * adjugate.at[2][0];
}

inline LaneTensor symmetric_part(const LaneTensor& t) {
  return spread_pairs(0.5) * (t + t.transposed());
}

}  // namespace spall
