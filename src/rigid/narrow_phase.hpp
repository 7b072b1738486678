// From pairs to contacts: gaps, normals, and which of them can close within the step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "pairs/neighbours.hpp"
#include "rigid/contacts.hpp"
#include "state/world.hpp"

namespace spall {

/// A contact's geometry; the same bits on every rank that has both bodies.
struct Separation {
  Vec3 normal;   ///< from i to j
  double gap;    ///< m
  double kappa;  ///< distance of the centres over the sum of radii
};

/// Spheres at the same centre have no normal: they part along x.
Separation separation(const Bodies& bodies, const std::vector<Plane>& planes, Index i, Index j,
                      std::int32_t plane);

/// 1/kg; 0 for a body that never moves.
inline double inverse_mass(const Bodies& bodies, Index b) {
  return std::isfinite(bodies.mass[b]) ? 1 / bodies.mass[b] : 0;
}

/// Of the pair, m; a plane has none.
inline double smaller_radius(const Bodies& bodies, Index i, Index j) {
  return j == ground ? bodies.radius[i] : std::min(bodies.radius[i], bodies.radius[j]);
}

/// Relative velocity of j against i at the contact, m/s: u = v_j - v_i - kappa (r_i omega_i + r_j
/// omega_j) x n between spheres, with lever arms u = v_j + omega_j x a_j - v_i - omega_i x a_i.
Vec3 contact_velocity(const Bodies& bodies, const Contacts& contacts, Index c);
/// Relative acceleration of j against i by gravity, there, m/s^2.
Vec3 contact_acceleration(const Bodies& bodies, const Contacts& contacts, Index c);

/// m: of the smaller one of the two spheres that touch; a plane has none.
inline double smaller_radius(const Bodies& bodies, const Contacts& contacts, Index c) {
  return contacts.spheres.empty() ? smaller_radius(bodies, contacts.i[c], contacts.j[c])
                                  : contacts.spheres[c].radius;
}

/// m: the gap that a contact may close within a step `h`. That of two that attract each other from
/// afar and fly past is wider by as much as they will miss each other.
double gap_to_close(const Bodies& bodies, const Contacts& contacts, Index c, double h);

/// What a contact problem has in place of kappa where bodies have shapes; else empty.
struct LeverArms {
  std::vector<Vec3> arm_i, arm_j;  ///< over the radius
  std::vector<Mat3> turning;       ///< 1/kg, r^2 J^-1 of all rows; 0: never turns
};
LeverArms lever_arms(const World& world, const Contacts& contacts);

/// All pairs whose gap becomes, within a step `h` (s) of flight at their present velocities, no
/// wider than the range of cohesion or than `near_contact`. Impulses are the pairs'. What is held
/// does nothing to what is held. Bodies with shapes touch by their spheres, each pair in the order
/// of their lists.
Contacts find_contacts(const Bodies& bodies, const BodyShapes& shapes,
                       const std::vector<Plane>& planes, const Pairs& pairs, double h,
                       const ByPair<ContactLaw>& laws);

/// The law of a pair of bodies, or of a body and a plane, which may be of the body's own material.
inline const ContactLaw& law_of(const ByPair<ContactLaw>& laws, const Bodies& bodies,
                                const std::vector<Plane>& planes, Index i, Index j,
                                std::int32_t plane) {
  const int other = j == ground ? planes[plane].material : bodies.material[j];
  return laws(bodies.material[i], other == same_material ? bodies.material[i] : other);
}
/// The law of contact `c`.
inline const ContactLaw& law_of(const World& world, const Contacts& contacts, Index c) {
  return law_of(world.contact, world.bodies, world.planes, contacts.i[c], contacts.j[c],
                contacts.plane[c]);
}

/// J, of the work that cohesion did on the way to a gap (m). A bound of impulses has none: what it
/// does depends on the steps, and is booked as dissipated.
inline double energy_of_bond(const ContactLaw& law, double gap) {
  if (law.cohesion_law == CohesionLaw::impulse) return 0;
  return -law.cohesion * std::max(law.cohesion_range - gap, 0.0);
}

/// m, the longest of all pairs of materials.
double longest_range(const ByPair<ContactLaw>& laws);

}  // namespace spall
