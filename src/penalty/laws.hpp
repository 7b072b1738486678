// The laws of penalty contact for eight contacts at once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bit>
#include <cmath>

#include "pairs/transfer.hpp"
#include "penalty/penalty.hpp"
#include "spall/lanes.hpp"
#include "spall/types.hpp"

namespace spall {

inline Lanes dot(const LaneVectors& a, const LaneVectors& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
inline LaneVectors cross(const LaneVectors& a, const LaneVectors& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
inline LaneVectors operator+(const LaneVectors& a, const LaneVectors& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
inline LaneVectors operator-(const LaneVectors& a, const LaneVectors& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
inline LaneVectors operator*(const Lanes& s, const LaneVectors& a) {
  return {s * a.x, s * a.y, s * a.z};
}
/// A constant of one law for all lanes, or of one for each.
inline Lanes lanes_of(double constant) {
  return spread(constant);
}
inline const Lanes& lanes_of(const Lanes& constants) {
  return constants;
}
inline LaneVectors only(const LaneMask& mask, const LaneVectors& a) {
  const Lanes zero{};
  return {select(mask, a.x, zero), select(mask, a.y, zero), select(mask, a.z, zero)};
}

/// What the normal law says of a contact; see `PenaltyLaw`.
struct NormalForce {
  Lanes force;       ///< N, without damping
  Lanes slope;       ///< S, N/m
  Lanes tangential;  ///< k_t, N/m
  Lanes attraction;  ///< N, by which the friction bound exceeds the force
  Lanes growth;      ///< 1/m, of k_t with the overlap: d ln k_t/d delta
};

/// Each law has: force, energy (J) as a function of overlap, and the energies (J) that are lost as
/// a contact forms and as it parts. Its constants are those of all lanes, doubles, or lanes.
template <class Number>
struct HookeLanes {
  explicit HookeLanes(const LawConstants<Number>& law) : k(law.normal), kt(law.tangential) {}
  static constexpr bool sticks = false, adheres = false;
  NormalForce force(const Lanes& overlap, const Lanes&) const {
    return {k * overlap, lanes_of(k), lanes_of(kt), Lanes{}, Lanes{}};
  }
  Lanes energy(const Lanes& overlap, const Lanes&) const { return 0.5 * k * overlap * overlap; }
  Number k, kt;
};

template <bool dmt, class Number>
struct HertzLanes {
  explicit HertzLanes(const LawConstants<Number>& law)
      : modulus(law.normal), kt(law.tangential), pull(law.attraction) {}
  static constexpr bool sticks = false, adheres = dmt;
  NormalForce force(const Lanes& overlap, const Lanes& radius) const {
    const Lanes inverse = inverse_sqrt(radius * overlap), attraction = pull * radius;
    const Lanes a = radius * overlap * inverse;
    Lanes f = (4 / 3.0 * modulus) * a * overlap;
    if constexpr (dmt) f -= attraction;
    return {f, (2 * modulus) * a, kt * a, attraction, 0.5 * radius * inverse * inverse};
  }
  Lanes energy(const Lanes& overlap, const Lanes& radius) const {
    const Lanes hertz = (8 / 15.0 * modulus) * root_of(radius * overlap) * overlap * overlap;
    return dmt ? hertz - pull * radius * overlap : hertz;
  }
  Number modulus, kt, pull;
};
template <class Number>
using PlainHertzLanes = HertzLanes<false, Number>;
template <class Number>
using DmtLanes = HertzLanes<true, Number>;

/// With s = sqrt(a) = b^(1/3) q and b = R sqrt(2 pi w/E*), delta(a) becomes q^4 - q = delta R /
/// b^(4/3); the branch that is stable at a given distance is q >= 4^(-1/3).
template <class Number>
struct JkrLanes {
  explicit JkrLanes(const LawConstants<Number>& law)
      : modulus(law.normal), kt(law.tangential), pull(law.attraction), a1(law.neck) {}
  static constexpr bool sticks = true, adheres = true;
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

/// A contact of body j, the partner, with body i.
struct ContactLanes {
  LaneVectors normal;    ///< from i to j
  Lanes overlap;         ///< m
  Lanes radius;          ///< R, m
  Lanes inverse_mass;    ///< 1/m, 1/kg
  Lanes kappa;           ///< distance over r_i + r_j: both lever arms end in one point
  LaneVectors velocity;  ///< m/s, of j's centre against i's
  LaneVectors surface;   ///< m/s, r_i omega_i + r_j omega_j
  LaneVectors rolling;   ///< rad/s, omega_j - omega_i
  Lanes twist;           ///< rad/s, that the pair turns about its normal
};

/// What a contact keeps from step to step, m; on j against i.
struct SpringLanes {
  LaneVectors sliding, rolling;
};

struct ContactForce {
  LaneVectors force;    ///< N, on j
  LaneVectors lever;    ///< N: on either body it exerts the torque r times this
  LaneVectors rolling;  ///< N m, on j; on i the opposite
  Lanes power;          ///< W, that the bodies lose, the elastic part of the normal force apart
};

/// A vector that was tangential turns with the pair and keeps its length.
inline LaneVectors turned(const LaneVectors& v, const LaneVectors& n, const Lanes& angle) {
  const LaneVectors with = v + angle * cross(n, v);
  const LaneVectors flat = with - dot(with, n) * n;
  const Lanes scale = root_of(dot(v, v)) * inverse_sqrt(dot(flat, flat));
  return scale * flat;
}

/// A spring from the last step: turned, and scaled where the contact radius a has changed, `shrunk`
/// being what a has lost of itself. Its force stays as the contact grows and falls as a when it
/// shrinks (Thornton, Cummins & Cleary, Powder Technology 233 (2013) 30, eqs. 18, 19), but as a^4
/// where it is pushed on: a contact that shrinks slips in its rim. The exponent is fitted to the
/// solution with that slip (Cattaneo 1938; Mindlin & Deresiewicz 1953) for oblique impacts.
inline LaneVectors carried(const LaneVectors& xi, const LaneVectors& velocity, const Lanes& angle,
                           const Lanes& shrunk, const LaneVectors& n) {
  const Lanes pushed = dot(xi, velocity);
  const Lanes scale =
      1.0 + select(shrunk < 0.0, shrunk, select(pushed > 0.0, -3.0 * shrunk, Lanes{}));
  return larger(scale, Lanes{}) * turned(xi, n, angle);
}

/// Spring and dashpot with a slider: the force of the spring `xi`, which is cut back to `bound`.
inline LaneVectors slide(LaneVectors& xi, const LaneVectors& velocity, const Lanes& k,
                         const Lanes& c, const Lanes& bound) {
  const LaneVectors drag = c * velocity;
  LaneVectors f = -k * xi - drag;
  const Lanes f2 = dot(f, f);
  const LaneMask slips = f2 > bound * bound;
  if (any_lane(slips)) {
    const Lanes scale = select(slips, bound * inverse_sqrt(f2), spread(1));
    f = scale * f;
    const Lanes inverse = -1.0 / k;
    xi.x = select(slips, inverse * (f.x + drag.x), xi.x);
    xi.y = select(slips, inverse * (f.y + drag.y), xi.y);
    xi.z = select(slips, inverse * (f.z + drag.z), xi.z);
  }
  return f;
}

/// The force of touching contacts over a step `h` (s), in which their springs grow.
template <bool frictional, bool rolling, class Normal, class Number>
ContactForce contact_force(const Normal& normal, const LawConstants<Number>& law,
                           const ContactLanes& c, double h, SpringLanes& spring) {
  const NormalForce elastic = normal.force(c.overlap, c.radius);
  const Lanes un = dot(c.velocity, c.normal);
  const Lanes damping = law.damping * root_of(elastic.slope / c.inverse_mass);
  const Lanes fn = elastic.force - law.cohesion - damping * un;
  ContactForce result{};
  result.power = damping * un * un;
  result.force = fn * c.normal;
  if constexpr (frictional) {
    const LaneVectors ut = c.velocity - un * c.normal - c.kappa * cross(c.surface, c.normal);
    const Lanes load = fn + law.cohesion + elastic.attraction;
    const Lanes bound = law.friction * select(load > 0.0, load, -load);
    spring.sliding = carried(spring.sliding, ut, h * c.twist, h * un * elastic.growth, c.normal);
    spring.sliding = spring.sliding + spread(h) * ut;
    const LaneVectors ft =
        slide(spring.sliding, ut, elastic.tangential, law.tangential_damping * damping, bound);
    result.power -= dot(ft, ut);
    result.force = result.force + ft;
    result.lever = -c.kappa * cross(c.normal, ft);
    if constexpr (rolling) {
      // Luding 2008: a spring as stiff as the sliding one, without a dashpot as in EPSD2
      // (LIGGGHTS; Ai et al., Powder Technology 206 (2011) 269), on v = R omega_ij x n.
      const LaneVectors v = c.radius * cross(c.rolling, c.normal);
      spring.rolling = carried(spring.rolling, v, h * c.twist, h * un * elastic.growth, c.normal);
      spring.rolling = spring.rolling + spread(h) * v;
      const Lanes most = law.rolling_friction * select(load > 0.0, load, -load);
      const LaneVectors f = slide(spring.rolling, v, elastic.tangential, Lanes{}, most);
      result.rolling = c.radius * cross(c.normal, f);
      result.power -= dot(f, v);
    }
  }
  return result;
}

}  // namespace spall
