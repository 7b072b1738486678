// The law of Johnson, Kendall and Roberts: adhesion that deforms the contact to a neck.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "penalty/normal_force.hpp"
#include "spall/types.hpp"

namespace spall {

/// With s = sqrt(a) = b^(1/3) q and b = R sqrt(2 pi w/E*), delta(a) becomes q^4 - q = delta R /
/// b^(4/3); the branch that is stable at a given distance is q >= 4^(-1/3).
template <class Number>
struct JkrLanes : NoAdhesion {
  explicit JkrLanes(const LawConstants<Number>& law)
      : modulus(law.normal), kt(law.tangential), pull(law.attraction), a1(law.neck) {}
  static constexpr AdhesionKey key = work_of_adhesion;
  static constexpr bool sticks = true, adheres = true;
  static void derive(double w, LawConstants<double>& law) {
    law.attraction = 3 * pi * w;
    law.neck = std::cbrt(2 * pi * w / law.normal);
  }
  static double reach(const LawConstants<double>& law, double radius) {
    return -JkrLanes<double>(law).end_overlap(spread(radius))[0];
  }
  static double resting_contact(const LawConstants<double>& law, double radius) {
    return std::cbrt(1.5 * law.attraction * radius * radius / law.normal);
  }
  static constexpr double q_end = 0.62996052494743658;  // 4^(-1/3)
  static constexpr double end = -0.47247039371057744;   // q_end^4 - q_end

  /// The scale of a: b^(2/3) = R^(2/3) (2 pi w/E*)^(1/3).
  Lanes contact_scale(const Lanes& radius) const {
    const Lanes root = cube_root(radius);
    return a1 * root * root;
  }
  /// m, the overlap at which contacts part: negative.
  Lanes end_overlap(const Lanes& radius) const {
    const Lanes a = contact_scale(radius);
    return end * a * a / radius;
  }
  /// The root of q^4 - q = depth, by Newton's method from above, where it cannot miss.
  static Lanes solve(const Lanes& depth) {
    const Lanes past = depth - end;
    const Lanes near = q_end + root_of(larger(past, Lanes{}) * 0.42);
    const Lanes root = root_of(root_of(larger(depth, Lanes{})));
    Lanes q = smaller(near, root + 1.0);
    for (int k = 0; k < 40; ++k) {
      const Lanes q2 = q * q, q3 = q2 * q;
      const Lanes step = (q2 * q2 - q - depth) / (4.0 * q3 - 1.0);
      const Lanes next = q - step;
      const LaneMask moves = (4.0 * q3 > 1.0) & (step > 1e-8 * q);
      q = select(4.0 * q3 > 1.0, next, q);
      if (!any_lane(moves)) break;
    }
    return larger(q, spread(q_end));
  }
  NormalForce force(const Lanes& overlap, const Lanes& radius) const {
    const Lanes scale = contact_scale(radius);
    const Lanes q = solve(overlap * radius / (scale * scale));
    const Lanes q2 = q * q, q3 = q2 * q, a = scale * q2;
    // F = 2 pi w R (4/3 q^6 - 2 q^3).
    const Lanes attraction = pull * radius;
    // da/ddelta / a, with a = scale q^2 and delta = scale^2/R (q^4 - q).
    const Lanes growth = 2.0 * radius / (scale * scale * q * (4.0 * q3 - 1.0));
    return {attraction * q3 * (8 / 9.0 * q3 - 4 / 3.0), (2 * modulus) * a, kt * a, attraction,
            growth};
  }
  /// J, of the integral of F from the end of the unstable branch, a = 0.
  Lanes energy_at(const Lanes& q, const Lanes& radius) const {
    const Lanes scale = contact_scale(radius), s2 = scale * scale;
    const Lanes q2 = q * q, q4 = q2 * q2, q3 = q2 * q;
    return modulus * s2 * s2 * scale / (radius * radius) * q4 *
           ((8 / 15.0) * q3 * q3 - (4 / 3.0) * q3 + 0.5);
  }
  Lanes energy(const Lanes& overlap, const Lanes& radius) const {
    const Lanes scale = contact_scale(radius);
    return energy_at(solve(overlap * radius / (scale * scale)), radius);
  }
  Lanes energy_at_start(const Lanes& radius) const { return energy_at(spread(1), radius); }
  Lanes energy_at_end(const Lanes& radius) const { return energy_at(spread(q_end), radius); }
  Number modulus, kt, pull, a1;
};

}  // namespace spall
