// A pair law as a type: soft spheres, U = D (1 - r^2/d^2)^2 below d. Compiled by the tests.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace spall {

/// `Number` is a double, or a vector of them: the formulas are the same.
struct SoftSpheres {
  double depth;  ///< J, D
  double d;      ///< m; from there on there is no force

  /// N/m, of the repulsion -dU/dr over r.
  template <class Number>
  Number force_over_distance(const Number& r2) const {
    return (4 * depth / (d * d)) * (1.0 - r2 * (1 / (d * d)));
  }
  /// J.
  template <class Number>
  Number energy(const Number& r2) const {
    const Number left = 1.0 - r2 * (1 / (d * d));
    return depth * left * left;
  }
};

}  // namespace spall
