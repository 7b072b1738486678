// The bodies of one rank: one vector a field, owned bodies first, ghosts after.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <type_traits>
#include <vector>

#include "spall/base/types.hpp"

namespace spall {

/// Whether bodies have the fields that only some methods need; the same on every rank.
struct OptionalFields {
  bool angular_velocity = true, acceleration = true, heat = true, kick = true;
  bool bonds = true;  ///< and damage
};

/// Spheres. Row b of every field is body b of this rank; rows [0, owned) are this rank's own, the
/// rest are copies of other ranks' bodies, current only after a ghost exchange.
struct Bodies {
  Index owned = 0;
  OptionalFields has;  ///< a field that they do not have is empty

  std::vector<BodyId> id;
  std::vector<std::int32_t> group;     ///< index of the scene's recipe that made the body
  std::vector<std::int32_t> material;  ///< index into the scene's materials
  std::vector<double> radius;          ///< m
  std::vector<double> mass;            ///< kg; infinite for a body that never moves
  std::vector<Vec3> position;          ///< m
  std::vector<Vec3> velocity;          ///< m/s
  std::vector<Vec3> angular_velocity;  ///< rad/s, world frame
  std::vector<Vec3> acceleration;      ///< m/s^2, by gravity when its field was last evaluated
  std::vector<double>
      heat;                ///< J, that damping has left in the body, less the work of its pressure
  std::vector<Vec3> kick;  ///< m/s, by pair potentials in the last step
  std::vector<std::int32_t> bonds;  ///< that the body was made with, where bonds break
  std::vector<double> damage;       ///< share of them broken, when last measured

  Index size() const { return static_cast<Index>(id.size()); }
  Index ghosts() const { return size() - owned; }
};

/// Calls `f(name, field)` for every field that the bodies have: resizing, migration, ghosts and
/// restart go through this list alone, so a new field is one line.
template <class BodiesLike, class F>
void for_each_field(BodiesLike& bodies, F&& f) {
  f("id", bodies.id);
  f("group", bodies.group);
  f("material", bodies.material);
  f("radius", bodies.radius);
  f("mass", bodies.mass);
  f("position", bodies.position);
  f("velocity", bodies.velocity);
  if (bodies.has.angular_velocity) f("angular_velocity", bodies.angular_velocity);
  if (bodies.has.acceleration) f("acceleration", bodies.acceleration);
  if (bodies.has.heat) f("heat", bodies.heat);
  if (bodies.has.kick) f("kick", bodies.kick);
  if (bodies.has.bonds) {
    f("bonds", bodies.bonds);
    f("damage", bodies.damage);
  }
}

/// Makes every field as long as `id`, by zeros.
inline void fill_fields(Bodies& bodies) {
  for_each_field(bodies, [&](const char*, auto& field) {
    using T = typename std::remove_cvref_t<decltype(field)>::value_type;
    if constexpr (std::is_same_v<T, Vec3>)
      field.resize(bodies.id.size(), Vec3::Zero());
    else
      field.resize(bodies.id.size(), T{});
  });
}

/// Appends a row of zeros to every field and returns its place; `owned` is left to the caller.
inline Index append_row(Bodies& bodies) {
  bodies.id.push_back(0);
  fill_fields(bodies);
  return bodies.size() - 1;
}

/// From now on bodies have these fields: what they did not have is zero.
inline void set_fields(Bodies& bodies, const OptionalFields& fields) {
  if (!fields.angular_velocity) bodies.angular_velocity = {};
  if (!fields.acceleration) bodies.acceleration = {};
  if (!fields.heat) bodies.heat = {};
  if (!fields.kick) bodies.kick = {};
  if (!fields.bonds) {
    bodies.bonds = {};
    bodies.damage = {};
  }
  bodies.has = fields;
  fill_fields(bodies);
}

}  // namespace spall
