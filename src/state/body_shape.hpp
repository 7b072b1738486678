// Shapes of bodies: unions of spheres that move as one, with their volume and inertia.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <string>
#include <vector>

#include "spall/bodies.hpp"

namespace spall {

/// One of the spheres that a shape is made of.
struct ShapeSphere {
  Vec3 at;
  double radius;
};

/// What is a sphere's own of a shape: of an overlap, what is on its side of the plane through the
/// circle in which both meet.
struct ShapePart {
  Vec3 centre;   ///< of mass
  double share;  ///< of the mass
};

/// A union of spheres in units of its own radius: that of the sphere around it about its centre of
/// mass. Body axes are the principal ones, from the centre of mass. Overlaps count once.
struct BodyShape {
  std::string name;
  std::vector<ShapeSphere> spheres = {{Vec3::Zero(), 1}};
  std::vector<ShapePart> parts = {{Vec3::Zero(), 1}};  ///< their masses and first moments add up
  double volume = 4 * pi / 3;                          ///< over the radius cubed
  double arm = 0;                                      ///< from its centre to a sphere's, at most
  Vec3 inertia = Vec3::Constant(sphere_inertia);       ///< principal moments over m r^2
  Quaternion as_listed = Quaternion::Identity();  ///< turns body axes into those it was listed in

  bool is_sphere() const { return spheres.size() == 1; }
};

/// All shapes of a case; the first is the sphere. Empty: all bodies are spheres. `Bodies::shape`
/// is a place in it.
using BodyShapes = std::vector<BodyShape>;

/// Relative to volume and principal moments: their largest error.
inline constexpr double shape_error = 1e-5;

/// The shape of these spheres, in any unit, about any origin. Volume and inertia are good to
/// `shape_error`. Throws Error where its spheres do not hang together.
BodyShape make_shape(std::string name, std::span<const ShapeSphere> spheres);

/// `count` spheres in an ellipsoid with these semi-axes, each as large as it can be where it lies.
/// The first is in the middle; each of the others is that which stands out most of all before it.
/// Fewer where all of them would coincide.
std::vector<ShapeSphere> fill_ellipsoid(const Vec3& axes, int count);

/// The shape of body `b`.
inline const BodyShape& shape_of(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  return shapes[bodies.shape[b]];
}

/// One of a shape's spheres (m), of a body of this radius (m) about `center`, turned so.
inline ShapeSphere placed_sphere(const ShapeSphere& sphere, const Vec3& center, double radius,
                                 const Quaternion& turn) {
  return {center + radius * (turn * sphere.at), radius * sphere.radius};
}

/// The tensor that has these principal values in the axes that `turn` turns into the world's.
inline Mat3 turned_tensor(const Quaternion& turn, const Vec3& principal) {
  const Mat3 axes = turn.toRotationMatrix();
  return axes * principal.asDiagonal() * axes.transpose();
}

/// Of body `b`, over m r^2, in the world's axes.
inline Mat3 inertia_factor(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  if (shapes.empty() || bodies.shape[b] == 0) return sphere_inertia * Mat3::Identity();
  return turned_tensor(bodies.orientation[b], shape_of(shapes, bodies, b).inertia);
}
/// The inverse of that.
inline Mat3 inverse_inertia_factor(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  if (shapes.empty() || bodies.shape[b] == 0) return 1 / sphere_inertia * Mat3::Identity();
  return turned_tensor(bodies.orientation[b], shape_of(shapes, bodies, b).inertia.cwiseInverse());
}

/// m/s, at most, of the spheres of body `b` beside its centre.
inline double turning_speed(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  if (shapes.empty() || bodies.shape[b] == 0) return 0;
  return bodies.radius[b] * shape_of(shapes, bodies, b).arm * bodies.angular_velocity[b].norm();
}

/// kg m^2/s: angular momentum about its centre of body `b`, of finite mass, with this angular
/// velocity (rad/s).
inline Vec3 momentum_of_spin(const BodyShapes& shapes, const Bodies& bodies, Index b,
                             const Vec3& spin) {
  const double mass = bodies.mass[b], radius = bodies.radius[b];
  if (shapes.empty() || bodies.shape[b] == 0) return moment_of_inertia(mass, radius) * spin;
  return mass * radius * radius * (inertia_factor(shapes, bodies, b) * spin);
}
/// The same with the one that it has.
inline Vec3 spin_momentum(const BodyShapes& shapes, const Bodies& bodies, Index b) {
  return momentum_of_spin(shapes, bodies, b, bodies.angular_velocity[b]);
}
/// rad/s: the angular velocity with which it has this angular momentum (kg m^2/s).
inline Vec3 spin_of_momentum(const BodyShapes& shapes, const Bodies& bodies, Index b,
                             const Vec3& momentum) {
  const double mass = bodies.mass[b], radius = bodies.radius[b];
  if (shapes.empty() || bodies.shape[b] == 0) return momentum / moment_of_inertia(mass, radius);
  return inverse_inertia_factor(shapes, bodies, b) * momentum / (mass * radius * radius);
}

}  // namespace spall
