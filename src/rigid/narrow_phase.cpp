// One pass over the pairs.
// SPDX-License-Identifier: BSD-3-Clause
#include "rigid/narrow_phase.hpp"

#include <cmath>

#include "engine/prescribed.hpp"

namespace spall {

Separation separation(const Bodies& bodies, const std::vector<Plane>& planes, Index i, Index j,
                      std::int32_t plane) {
  if (j == ground) {
    const Plane& wall = planes[plane];
    const double height = wall.normal.dot(bodies.position[i] - wall.point);
    return {-wall.normal, height - bodies.radius[i], 1};
  }
  const Vec3 apart = bodies.position[j] - bodies.position[i];
  const double distance = apart.norm(), radii = bodies.radius[i] + bodies.radius[j];
  if (distance == 0) return {Vec3::UnitX(), -radii, 0};
  return {apart / distance, distance - radii, distance / radii};
}

Vec3 contact_velocity(const Bodies& bodies, Index i, Index j, double kappa, const Vec3& normal) {
  Vec3 u = -bodies.velocity[i];
  Vec3 surface = bodies.radius[i] * bodies.angular_velocity[i];
  if (j != ground) {
    u += bodies.velocity[j];
    surface += bodies.radius[j] * bodies.angular_velocity[j];
  }
  return u - kappa * surface.cross(normal);
}

namespace {

/// The narrowest gap of the pair in a step `h` of free flight. What flies past at some distance is
/// no contact, though it crosses the tangent plane on which a contact would stop it.
double narrowest_gap(const Bodies& bodies, Index i, Index j, const Separation& s, double h) {
  if (j == ground) return s.gap + h * std::min(0.0, s.normal.dot(-bodies.velocity[i]));
  const Vec3 apart = bodies.position[j] - bodies.position[i];
  const Vec3 u = bodies.velocity[j] - bodies.velocity[i];
  const double approach = -apart.dot(u);
  if (approach <= 0) return s.gap;
  const double nearest = std::min(h, approach / u.squaredNorm());
  return (apart + nearest * u).norm() - bodies.radius[i] - bodies.radius[j];
}

}  // namespace

Contacts find_contacts(const Bodies& bodies, const std::vector<Plane>& planes, const Pairs& pairs,
                       double h, const ByPair<ContactLaw>& laws) {
  const auto separation_of = [&](Index p) {
    return separation(bodies, planes, pairs.i[p], pairs.j[p], pairs.plane[p]);
  };
  const auto may_touch = [&](Index p) {
    const Index i = pairs.i[p], j = pairs.j[p];
    if (is_held(bodies, i) && (j == ground || is_held(bodies, j))) return false;
    const Separation s = separation_of(p);
    const double near = std::max(near_contact * smaller_radius(bodies, i, j),
                                 law_of(laws, bodies, planes, i, j, pairs.plane[p]).cohesion_range);
    return s.gap <= near || narrowest_gap(bodies, i, j, s, h) <= near;
  };

  // Counted first: a third of the pairs of a packing may touch nothing, and a contact is 80 bytes.
  Contacts contacts;
  contacts.pair.reserve(pairs.size());
  for (Index p = 0; p < pairs.size(); ++p) {
    if (!may_touch(p)) continue;
    contacts.pair.push_back(p);
    if (p < pairs.boundary) ++contacts.boundary;
  }
  const auto room = [&](auto&... fields) { (fields.reserve(contacts.pair.size()), ...); };
  room(contacts.i, contacts.j, contacts.plane, contacts.normal, contacts.gap, contacts.kappa,
       contacts.impulse);
  for (const Index p : contacts.pair) {
    const Separation s = separation_of(p);
    contacts.i.push_back(pairs.i[p]);
    contacts.j.push_back(pairs.j[p]);
    contacts.plane.push_back(pairs.plane[p]);
    contacts.normal.push_back(s.normal);
    contacts.gap.push_back(s.gap);
    contacts.kappa.push_back(s.kappa);
    contacts.impulse.push_back(pairs.impulse[p]);
  }
  return contacts;
}

double longest_range(const ByPair<ContactLaw>& laws) {
  double longest = 0;
  laws.for_each([&](const ContactLaw& law) { longest = std::max(longest, law.cohesion_range); });
  return longest;
}

}  // namespace spall
