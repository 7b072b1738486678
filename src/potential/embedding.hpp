// What depends on how crowded a body is and not on one neighbour alone: the solid's pressure.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "potential/pair_potential.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// Of the distance of rest: r_c, up to which bodies crowd each other.
inline constexpr double crowding_reach = 1.3;

/// How much a body r away crowds: w(r) = (1 - r/r_c)^2 below r_c, the same for all lanes or one for
/// each.
template <class Number>
class BasicCrowdingWeight {
 public:
  explicit BasicCrowdingWeight(const Number& reach)
      : reach2_(reach * reach), inverse_(1.0 / reach), twice_(2.0 / reach) {}

  const Number& reach2() const { return reach2_; }  ///< m^2

  Lanes operator()(const Lanes& r2) const {
    const Lanes left = 1.0 - r2 * inverse_sqrt(r2) * inverse_;
    return select((r2 < reach2_) & (r2 > 0.0), left * left, Lanes{});
  }
  /// 1/m^2, -w'(r)/r. Both are 0 of a body and itself.
  Lanes slope_over_distance(const Lanes& r2) const {
    const Lanes slope = twice_ * (inverse_sqrt(r2) - inverse_);
    return select((r2 < reach2_) & (r2 > 0.0), slope, Lanes{});
  }

 private:
  Number reach2_, inverse_, twice_;
};
using CrowdingWeight = BasicCrowdingWeight<double>;

/// The embedding part of a pair potential, as a table. Body i is as crowded as
///
///   n_i = sum_j w(r_ij),
///
/// with r_c = 1.3 d. Between two materials d is that pair's, and w counts by (d_jj/d_ij)^2, since
/// as many more neighbours fit around a body as they are smaller; among others of equal spacing a
/// body is as crowded as in its own solid. In an fcc crystal n tells its density x, of that at
/// rest. Beside what pairs do, a body of mass m and heat Q presses with
///
///   P = P_c(x) - P_pair(x) + Gamma Q/v    where x > 1; not less than the heat's,
///   P = max(0, K (x - 1) + Gamma Q/v)     below, where bonds alone bear tension,
///
/// where v is what m takes of the solid, but no more than a cell of the crystal, and P_pair that of
/// pairs of nearest neighbours in it, so that a crystal answers shocks by the equation of state of
/// Mie and Gruneisen, Gamma rho constant, and a hot one expands until its cohesion holds the heat's
/// pressure, but not beyond 1.15 d. P_c is the isentrope from rest: with eta = 1 - 1/x, E_c = int
/// P_c d eta (J/m^3),
///
///   P_c = P_H (1 - Gamma eta/2) + Gamma E_c,   P_H = K eta / (1 - s eta)^2.
///
/// The forces follow from -P dv = P v/x^2 dx. The work of what is not cold is taken from the heat:
/// energy is kept. (The idea is the embedded atom's: Daw & Baskes, Phys. Rev. B 29 (1984) 6443; the
/// equation of state is that of Meyers, Dynamic Behavior of Materials, ch. 5.)
class EmbeddingLaw {
 public:
  explicit EmbeddingLaw(const PairPotential& potential);

  double reach() const { return reach_; }  ///< m, r_c

  /// m^3, v of a body (kg).
  double volume(double mass) const { return std::min(mass / density_, cell_); }

  /// Pa, -P dV/dn over v: all of it, and the heat's.
  struct Push {
    double all = 0, heat = 0;
  };
  /// Of a body with this crowding and heat (J/m^3, Q/v).
  Push push(double crowding, double heat) const;

  /// J/m^3, of the cold pressure from rest on.
  double energy(double crowding) const;

 private:
  struct Node {
    double cold = 0;    ///< Pa, P_cold dx/dn / x^2
    double hot = 0;     ///< Gamma dx/dn / x^2
    double energy = 0;  ///< J/m^3
  };
  struct Place {
    std::size_t node;
    double beyond;  ///< of the way to the next node
  };
  Place place(double crowding) const;

  double reach_, density_, cell_, at_rest_ = 0, step_ = 0;
  std::vector<Node> nodes_;
};

}  // namespace spall
