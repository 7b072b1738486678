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
ShapeSphere placed_sphere(const ShapeSphere& sphere, const Vec3& center, double radius,
                          const Quaternion& turn);

/// The tensor that has these principal values in the axes that `turn` turns into the world's.
Mat3 turned_tensor(const Quaternion& turn, const Vec3& principal);

/// Of body `b`, over m r^2, in the world's axes.
Mat3 inertia_factor(const BodyShapes& shapes, const Bodies& bodies, Index b);
/// The inverse of that.
Mat3 inverse_inertia_factor(const BodyShapes& shapes, const Bodies& bodies, Index b);

/// m/s, at most, of the spheres of body `b` beside its centre.
double turning_speed(const BodyShapes& shapes, const Bodies& bodies, Index b);

/// kg m^2/s: angular momentum about its centre of body `b`, of finite mass, with this angular
/// velocity (rad/s).
Vec3 momentum_of_spin(const BodyShapes& shapes, const Bodies& bodies, Index b, const Vec3& spin);
/// The same with the one that it has.
Vec3 spin_momentum(const BodyShapes& shapes, const Bodies& bodies, Index b);
/// rad/s: the angular velocity with which it has this angular momentum (kg m^2/s).
Vec3 spin_of_momentum(const BodyShapes& shapes, const Bodies& bodies, Index b,
                      const Vec3& momentum);

}  // namespace spall
