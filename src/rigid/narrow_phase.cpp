// One pass over the pairs.
// SPDX-License-Identifier: BSD-3-Clause
#include "rigid/narrow_phase.hpp"

#include <algorithm>
#include <cmath>
#include <span>

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

Vec3 contact_velocity(const Bodies& bodies, const Contacts& contacts, Index c) {
  const Index i = contacts.i[c], j = contacts.j[c];
  if (!contacts.spheres.empty()) {
    const SphereContact& at = contacts.spheres[c];
    Vec3 between = -bodies.velocity[i] - bodies.angular_velocity[i].cross(at.arm_i);
    if (j != ground) between += bodies.velocity[j] + bodies.angular_velocity[j].cross(at.arm_j);
    return between;
  }
  const double kappa = contacts.kappa[c];
  const Vec3& normal = contacts.normal[c];
  Vec3 u = -bodies.velocity[i];
  Vec3 surface = bodies.radius[i] * bodies.angular_velocity[i];
  if (j != ground) {
    u += bodies.velocity[j];
    surface += bodies.radius[j] * bodies.angular_velocity[j];
  }
  return u - kappa * surface.cross(normal);
}

Vec3 contact_acceleration(const Bodies& bodies, const Contacts& contacts, Index c) {
  const Index i = contacts.i[c], j = contacts.j[c];
  Vec3 between = -bodies.acceleration[i];
  if (j != ground) between += bodies.acceleration[j];
  if (contacts.spheres.empty() || !bodies.has(Field::angular_acceleration)) return between;
  const SphereContact& at = contacts.spheres[c];
  between -= bodies.angular_acceleration[i].cross(at.arm_i);
  if (j != ground) between += bodies.angular_acceleration[j].cross(at.arm_j);
  return between;
}

namespace {

/// The narrowest gap of two spheres `apart` (m, between their centres) that move on at `u` (m/s).
double narrowest_gap(const Vec3& apart, const Vec3& u, double radii, double h) {
  const double approach = -apart.dot(u);
  if (approach <= 0) return apart.norm() - radii;
  return (apart + std::min(h, approach / u.squaredNorm()) * u).norm() - radii;
}

/// The narrowest gap of the pair in a step `h` of free flight. What flies past at some distance is
/// no contact, though it crosses the tangent plane on which a contact would stop it.
double narrowest_gap(const Bodies& bodies, Index i, Index j, const Separation& s, double h) {
  if (j == ground) return s.gap + h * std::min(0.0, s.normal.dot(-bodies.velocity[i]));
  return narrowest_gap(bodies.position[j] - bodies.position[i],
                       bodies.velocity[j] - bodies.velocity[i], bodies.radius[i] + bodies.radius[j],
                       h);
}

/// m, up to which contacts of this law attract.
double range_of(const ContactLaw& law) {
  return law.cohesion > 0 ? law.cohesion_range : 0;
}

/// The spheres of all rows as bodies lie now, row after row.
struct PlacedSpheres {
  struct Sphere {
    Vec3 offset;    ///< m, from the body's centre
    Vec3 velocity;  ///< m/s
    double radius;  ///< m
  };
  std::vector<std::size_t> start = {0};  ///< row b's are [start[b], start[b + 1])
  std::vector<Sphere> spheres;

  PlacedSpheres(const Bodies& bodies, const BodyShapes& shapes) {
    for (Index b = 0; b < bodies.size(); ++b) {
      const double r = bodies.radius[b];
      const Mat3 turn = bodies.orientation[b].toRotationMatrix();
      for (const ShapeSphere& sphere : shape_of(shapes, bodies, b).spheres) {
        const Vec3 offset = r * (turn * sphere.at);
        spheres.push_back({offset, bodies.velocity[b] + bodies.angular_velocity[b].cross(offset),
                           r * sphere.radius});
      }
      start.push_back(spheres.size());
    }
  }
  std::span<const Sphere> of(Index b) const {
    return {spheres.data() + start[b], start[b + 1] - start[b]};
  }
};

/// A pair is the pairs of its spheres. That a sphere goes in a circle, not straight on, brings two
/// of them nearer by omega^2 |offset| h^2 / 2 each.
Contacts find_shape_contacts(const Bodies& bodies, const BodyShapes& shapes,
                             const std::vector<Plane>& planes, const Pairs& pairs, double h,
                             const ByPair<ContactLaw>& laws) {
  const PlacedSpheres placed(bodies, shapes);
  Contacts contacts;
  auto remembered = pairs.carried.begin();
  const auto bend = [&](Index b) {
    return h * h / 2 * bodies.angular_velocity[b].squaredNorm() * bodies.radius[b];
  };
  const auto rim_speed = [&](Index b) {
    return bodies.angular_velocity[b].norm() * bodies.radius[b];
  };
  for (Index p = 0; p < pairs.size(); ++p) {
    const Index i = pairs.i[p], j = pairs.j[p];
    const auto first = remembered;
    while (remembered != pairs.carried.end() && remembered->pair == p) ++remembered;
    if (is_held(bodies, i) && (j == ground || is_held(bodies, j))) continue;
    const double range = range_of(law_of(laws, bodies, planes, i, j, pairs.plane[p]));
    const double bent = bend(i) + (j == ground ? 0 : bend(j));
    const auto add = [&](std::size_t a, std::size_t b, const Vec3& normal, double gap, double kappa,
                         double small, const Vec3& arm_i, const Vec3& arm_j) {
      contacts.i.push_back(i);
      contacts.j.push_back(j);
      contacts.plane.push_back(pairs.plane[p]);
      contacts.normal.push_back(normal);
      contacts.gap.push_back(gap);
      contacts.kappa.push_back(kappa);
      contacts.pair.push_back(p);
      contacts.spheres.push_back(
          {arm_i, arm_j, small, static_cast<std::int32_t>(a), static_cast<std::int32_t>(b)});
      const auto& last = contacts.spheres.back();
      const auto known = std::find_if(first, remembered, [&](const CarriedImpulse& s) {
        return s.of_i == last.of_i && s.of_j == last.of_j;
      });
      contacts.impulse.push_back(known == remembered ? Vec3(Vec3::Zero()) : known->impulse);
      if (p < pairs.boundary) ++contacts.boundary;
    };
    const auto of_i = placed.of(i);
    if (j == ground) {
      const Plane& wall = planes[pairs.plane[p]];
      for (std::size_t a = 0; a < of_i.size(); ++a) {
        const auto& [offset, velocity, radius] = of_i[a];
        const double gap = wall.normal.dot(bodies.position[i] + offset - wall.point) - radius;
        const double nearest = gap + h * std::min(0.0, wall.normal.dot(velocity)) - bent;
        if (nearest > std::max(near_contact * radius, range)) continue;
        add(a, 0, -wall.normal, gap, 1, radius, offset - radius * wall.normal, Vec3::Zero());
      }
      continue;
    }
    const auto of_j = placed.of(j);
    const Vec3 centres = bodies.position[j] - bodies.position[i];
    // Most spheres of a pair are too far apart for a closer look.
    const double closing =
        (bodies.velocity[j] - bodies.velocity[i]).norm() + rim_speed(i) + rim_speed(j);
    const double reach =
        h * closing + bent + std::max(near_contact * smaller_radius(bodies, i, j), range);
    const auto is_far = [&](const Vec3& apart, double radii) {
      return apart.squaredNorm() > (radii + reach) * (radii + reach);
    };
    for (std::size_t a = 0; a < of_i.size(); ++a) {
      if (is_far(centres - of_i[a].offset, of_i[a].radius + bodies.radius[j])) continue;
      for (std::size_t b = 0; b < of_j.size(); ++b) {
        const auto &one = of_i[a], &other = of_j[b];
        const double radii = one.radius + other.radius;
        const double small = std::min(one.radius, other.radius);
        const Vec3 apart = centres + other.offset - one.offset;
        if (is_far(apart, radii)) continue;
        const Vec3 u = other.velocity - one.velocity;
        if (narrowest_gap(apart, u, radii, h) - bent > std::max(near_contact * small, range))
          continue;
        const double distance = apart.norm();
        const Vec3 normal = distance > 0 ? Vec3(apart / distance) : Vec3(Vec3::UnitX());
        const double kappa = distance / radii;
        add(a, b, normal, distance - radii, kappa, small, one.offset + kappa * one.radius * normal,
            other.offset - kappa * other.radius * normal);
      }
    }
  }
  return contacts;
}

}  // namespace

Contacts find_contacts(const Bodies& bodies, const BodyShapes& shapes,
                       const std::vector<Plane>& planes, const Pairs& pairs, double h,
                       const ByPair<ContactLaw>& laws) {
  if (!shapes.empty()) return find_shape_contacts(bodies, shapes, planes, pairs, h, laws);
  const auto separation_of = [&](Index p) {
    return separation(bodies, planes, pairs.i[p], pairs.j[p], pairs.plane[p]);
  };
  const auto may_touch = [&](Index p) {
    const Index i = pairs.i[p], j = pairs.j[p];
    if (is_held(bodies, i) && (j == ground || is_held(bodies, j))) return false;
    const Separation s = separation_of(p);
    const double near = std::max(near_contact * smaller_radius(bodies, i, j),
                                 range_of(law_of(laws, bodies, planes, i, j, pairs.plane[p])));
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
  auto remembered = pairs.carried.begin();
  for (const Index p : contacts.pair) {
    const Separation s = separation_of(p);
    contacts.i.push_back(pairs.i[p]);
    contacts.j.push_back(pairs.j[p]);
    contacts.plane.push_back(pairs.plane[p]);
    contacts.normal.push_back(s.normal);
    contacts.gap.push_back(s.gap);
    contacts.kappa.push_back(s.kappa);
    while (remembered != pairs.carried.end() && remembered->pair < p) ++remembered;
    const bool known = remembered != pairs.carried.end() && remembered->pair == p;
    contacts.impulse.push_back(known ? remembered->impulse : Vec3(Vec3::Zero()));
  }
  return contacts;
}

double gap_to_close(const Bodies& bodies, const Contacts& contacts, Index c, double h) {
  const double gap = contacts.gap[c], near = near_contact * smaller_radius(bodies, contacts, c);
  if (contacts.j[c] == ground || gap <= near) return gap;
  const double kappa = contacts.kappa[c], radii = gap / (kappa - 1);
  const Vec3& n = contacts.normal[c];
  const Vec3 u = contacts.spheres.empty()
                     ? Vec3(bodies.velocity[contacts.j[c]] - bodies.velocity[contacts.i[c]])
                     : contact_velocity(bodies, contacts, c);
  const double narrowest = narrowest_gap(kappa * radii * n, u, radii, h);
  return narrowest > near ? narrowest - h * std::min(0.0, u.dot(n)) : gap;
}

LeverArms lever_arms(const World& world, const Contacts& contacts) {
  LeverArms arms;
  if (world.shapes.empty()) return arms;
  const Bodies& bodies = world.bodies;
  for (Index b = 0; b < bodies.size(); ++b)
    arms.turning.push_back(inverse_mass(bodies, b) *
                           inverse_inertia_factor(world.shapes, bodies, b));
  for (Index c = 0; c < contacts.size(); ++c) {
    const Index i = contacts.i[c], j = contacts.j[c];
    arms.arm_i.push_back(contacts.spheres[c].arm_i / bodies.radius[i]);
    arms.arm_j.push_back(j == ground ? Vec3(Vec3::Zero())
                                     : Vec3(contacts.spheres[c].arm_j / bodies.radius[j]));
  }
  return arms;
}

double longest_range(const ByPair<ContactLaw>& laws) {
  double longest = 0;
  laws.for_each([&](const ContactLaw& law) { longest = std::max(longest, law.cohesion_range); });
  return longest;
}

}  // namespace spall
