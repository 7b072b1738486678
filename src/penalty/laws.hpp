// The force of eight contacts at once, of any normal law.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pairs/transfer.hpp"
#include "penalty/normal_force.hpp"
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
inline LaneVectors only(const LaneMask& mask, const LaneVectors& a) {
  const Lanes zero{};
  return {select(mask, a.x, zero), select(mask, a.y, zero), select(mask, a.z, zero)};
}

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
