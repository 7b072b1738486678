// What an impact did: the clump that is left, its velocity change, the ejecta.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "analysis/clumps.hpp"
#include "scene/case.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// The instant at which the impactor was added. All other bodies of finite mass are the target.
struct BeforeImpact {
  BodyId impactor = -1;
  double impactor_mass = 0;  ///< kg, m
  double target_mass = 0;    ///< kg, M
  BodyId struck = -1;        ///< the body that the impactor meets first; -1: not known
  double struck_mass = 0;    ///< kg, of the body that the impactor meets first; 0 where
                             ///< bodies are parts of a solid, not bodies that meet
  double stirred = 0;  ///< kg m/s, of the target's largest clump against all of it: read-outs take
                       ///< it for the impact's
  Vec3 target_velocity = Vec3::Zero();    ///< m/s, mass-weighted mean
  Vec3 relative_velocity = Vec3::Zero();  ///< m/s, U: impactor less target
  Vec3 direction() const { return relative_velocity.normalized(); }  ///< of flight
  double speed() const { return relative_velocity.norm(); }          ///< m/s
};
/// Of the impactor's energy, what a rigid head-on hit of restitution e leaves in the body that it
/// meets: (1 + e)^2 m M / (m + M)^2. No energy goes into shock and crushing, so in a pile of rigid
/// bodies the ejecta, and with them beta, grow with this share: it is set by the size of the body.
double rigid_share(const BeforeImpact& before, double restitution);

/// `struck`, `struck_mass` and `stirred` are left as they are made. Collective.
BeforeImpact before_impact(const Comm& comm, const Bodies& bodies, BodyId impactor);

/// What of the ejecta is faster than a speed (m/s): bodies and their mass (kg).
struct FasterThan {
  double speed, count, mass;
};

/// Bodies of the target that are not in the largest clump. Velocities are relative to the target's
/// before the impact; `back` is against the impactor's direction of flight.
struct Ejecta {
  std::int64_t count = 0;
  double mass = 0;               ///< kg
  Vec3 momentum = Vec3::Zero();  ///< kg m/s
  double v_ejecta = 0;           ///< m/s, sum of the speeds back of those that move back: thesis
                                 ///< Table 3.15's "sum of speeds towards the incident direction"
  double back_momentum = 0;      ///< kg m/s, the same sum weighted by mass
  double fastest = 0;            ///< m/s
  /// Half-aperture, degrees (upwards to 0.1), of the cone about the mean direction (that of
  /// `momentum`) that holds half or 90 % of sum m |v|. 0 without ejecta.
  double cone_half = 0, cone_most = 0;
  /// At 1, 1.5, 2, 3, 5 and 7 m/s times powers of ten: from what all exceed, at most six decades
  /// below the fastest, to what the fastest exceeds.
  std::vector<FasterThan> faster = {};
};

struct Deflection {
  Clump clump;    ///< the heaviest connected piece of the target, with the bodies its gravity holds
  double dv = 0;  ///< m/s, of the clump, along the impactor's direction of flight
  Vec3 dv_vector = Vec3::Zero();  ///< m/s
  /// Momentum enhancement from M dv = m U + m (beta - 1) (E.U) E (Cheng et al. 2023, Nature 616),
  /// E the direction of what left (ejecta and impactor): M (dv.E) / (m U.E); 1 if nothing left, nan
  /// where E lies across the flight, so that it is one small number over another.
  double beta = 1;
  double beta_along = 1;  ///< M dv / (m |U|): the same in one dimension
  Ejecta ejecta;
  Vec3 impactor_velocity = Vec3::Zero();  ///< m/s, relative to the target before the impact
  /// dv = dv_impactor + dv_rebound + dv_ejecta: what m U brought, what the impactor kept, what the
  /// ejecta took; each over the clump's mass, m/s.
  double dv_impactor = 0, dv_rebound = 0, dv_ejecta = 0;
  bool has_struck = true;  ///< the body that was hit is one of the clump's
  double closure = 0;      ///< |clump + ejecta + impactor - m U| / (m |U|)
};

/// `links` connect bodies that hang together; those of the impactor do not count, so it neither
/// joins pieces nor belongs to one. Collective.
Deflection measure_deflection(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                              const Links& links, double gravity_constant,
                              const BeforeImpact& before);

}  // namespace spall
