// The bodies of one rank, one vector a field; and the table that declares each field once.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <initializer_list>
#include <vector>

#include "spall/types.hpp"

namespace spall {

/// What is done with a field.
namespace trait {
inline constexpr unsigned always = 1;      ///< in every run; others where an engine requests them
inline constexpr unsigned migrated = 2;    ///< goes with its body to another rank
inline constexpr unsigned ghosted = 4;     ///< ghosts get it when they are made
inline constexpr unsigned refreshed = 8;   ///< `refresh_ghosts` brings it to ghosts again
inline constexpr unsigned restarted = 16;  ///< stands in restart files
inline constexpr unsigned written = 32;    ///< stands in snapshots, in each frame
inline constexpr unsigned fixed = 64;      ///< stands in snapshots, and never changes
inline constexpr unsigned kept = migrated | restarted;
}  // namespace trait

/// All fields: X(type, name, default, unit, traits, meaning). To add a field, add a line: resizing,
/// migration, ghosts, restarts, snapshots, the estimate of memory and `spall keys` follow. Where a
/// trait is missing, as `migrated` on a rank that gets the body, the field has its default. Units
/// are SI, by H5MD's rules; "": a pure number. Numbers of bodies or lists are 0 … N-1.
#define SPALL_FIELDS(X)                                                                            \
  X(BodyId, id, 0, "", always | kept | ghosted | written, "number of the body, for ever")          \
  X(std::int32_t, group, 0, "", always | kept | ghosted | fixed, "number of the group")            \
  X(std::int32_t, material, 0, "", always | kept | ghosted | fixed, "number of the material")      \
  X(double, radius, 0, "m", always | kept | ghosted | fixed, "of the sphere around it")            \
  X(std::int32_t, shape, 0, "", kept | ghosted | fixed, "number of the shape; 0: a sphere")        \
  X(double, mass, 0, "kg", always | kept | ghosted | fixed, "infinite: fixed or prescribed")       \
  X(Vec3, position, Vec3::Zero(), "m", always | kept | ghosted | refreshed | written, "")          \
  X(Vec3, velocity, Vec3::Zero(), "m s-1", always | kept | ghosted | refreshed | written, "")      \
  X(Vec3, angular_velocity, Vec3::Zero(), "rad s-1", kept | ghosted | refreshed | written,         \
    "in the world's frame")                                                                        \
  X(Quaternion, orientation, Quaternion::Identity(), "", kept | ghosted | refreshed | written,     \
    "x, y, z, w; turns the principal axes of the shape into the world's")                          \
  X(Vec3, acceleration, Vec3::Zero(), "m s-2", kept | ghosted | refreshed | written,               \
    "by gravity when its field was last evaluated")                                                \
  X(Vec3, angular_acceleration, Vec3::Zero(), "rad s-2", kept | ghosted | refreshed | written,     \
    "of clumps, by the gravity of those that are near")                                            \
  X(Vec3, anchor, Vec3::Zero(), "m", kept, "at the start, of bodies that move as prescribed")      \
  X(double, heat, 0, "J", kept | written, "beyond its cold energy; of pairs: left by damping")     \
  X(Vec3, kick, Vec3::Zero(), "m s-1", kept | ghosted | written, "by smooth forces when it acted") \
  X(std::int32_t, bonds, 0, "", kept | written, "that the body was made with")                     \
  X(double, damage, 0, "", kept | ghosted | written,                                               \
    "share of its bonds that are broken; of a solid with a stress: from 1 on it has failed")       \
  X(double, compression, 1, "", kept | ghosted | written, "density, of that at rest")              \
  X(double, pressure, 0, "Pa", kept | written, "")                                                 \
  X(Vec3, direct_stress, Vec3::Zero(), "Pa", kept | written, "deviator: xx, yy, zz")               \
  X(Vec3, shear_stress, Vec3::Zero(), "Pa", kept | written, "deviator: yz, zx, xy")                \
  X(double, plastic_strain, 0, "", kept | written, "equivalent, that has accumulated")             \
  X(double, strained, 0, "", kept | written,                                                       \
    "Johnson and Cook's sum of plastic strain: from 1 on the metal fails")                         \
  X(double, crushed, 0, "", kept | written,                                                        \
    "largest pressure on its pores, from the elastic (0) to the compaction pressure (1)")          \
  X(double, internal_energy, 0, "J", kept | written, "elastic, and heat")

enum class Field {
#define SPALL_FIELD(type, name, initial, unit, traits, meaning) name,
  SPALL_FIELDS(SPALL_FIELD)
#undef SPALL_FIELD
};

/// A line of the table but for the type.
struct FieldInfo {
  Field field;
  const char *name, *unit, *meaning;
  unsigned traits;
  constexpr bool is(unsigned any_of) const { return (traits & any_of) != 0; }
};

inline constexpr auto field_table = [] {
  using namespace trait;
#define SPALL_FIELD(type, name, initial, unit, traits, meaning)                  \
  static_assert(((traits)&refreshed) == 0 || sizeof(type) % sizeof(double) == 0, \
                "ghosts are refreshed by whole doubles");
  SPALL_FIELDS(SPALL_FIELD)
#undef SPALL_FIELD
#define SPALL_FIELD(type, name, initial, unit, traits, meaning) \
  FieldInfo{Field::name, #name, unit, meaning, traits},
  return std::to_array({SPALL_FIELDS(SPALL_FIELD)});
#undef SPALL_FIELD
}();

/// Fields that bodies have: those of every run, and those asked for.
class FieldSet {
 public:
  constexpr FieldSet(std::initializer_list<Field> requested = {}) {
    for (const FieldInfo& info : field_table)
      if (info.is(trait::always)) bits_ |= bit(info.field);
    for (Field field : requested) bits_ |= bit(field);
  }
  static constexpr FieldSet all() {
    FieldSet set;
    for (const FieldInfo& info : field_table) set |= {info.field};
    return set;
  }
  constexpr bool has(Field field) const { return (bits_ & bit(field)) != 0; }
  constexpr FieldSet& operator|=(const FieldSet& other) {
    bits_ |= other.bits_;
    return *this;
  }
  bool operator==(const FieldSet&) const = default;

 private:
  static_assert(field_table.size() <= 64, "a bit for each field");
  static constexpr std::uint64_t bit(Field field) {
    return std::uint64_t{1} << static_cast<int>(field);
  }
  std::uint64_t bits_ = 0;
};

/// Spheres, or bodies with a shape made of them. Row b of every field is body b of this rank; rows
/// [0, owned) are this rank's own, the rest are copies of other ranks' bodies, current only after a
/// ghost exchange.
struct Bodies {
  Index owned = 0;
  FieldSet fields = FieldSet::all();  ///< the same on every rank; a field not in it is empty

#define SPALL_FIELD(type, name, initial, unit, traits, meaning) std::vector<type> name;
  SPALL_FIELDS(SPALL_FIELD)
#undef SPALL_FIELD

  bool has(Field field) const {
    return fields.has(field);
  }
  Index size() const {
    return static_cast<Index>(id.size());
  }
  Index ghosts() const {
    return size() - owned;
  }
};

/// What `for_each_field` tells of a field.
template <class T>
struct TypedField : FieldInfo {
  T initial;  ///< its default
};

/// Calls `f(info, field)` for every field that the bodies have, in the order of the table.
template <class BodiesLike, class F>
void for_each_field(BodiesLike& bodies, F&& f) {
#define SPALL_FIELD(type, name, initial, unit, traits, meaning) \
  if (bodies.has(Field::name))                                  \
    f(TypedField<type>{field_table[static_cast<int>(Field::name)], initial}, bodies.name);
  SPALL_FIELDS(SPALL_FIELD)
#undef SPALL_FIELD
}

/// Makes every field as long as `id`, by defaults.
void fill_fields(Bodies& bodies);

/// Grows, by defaults, or cuts every field to `rows`; `owned` never exceeds it.
void resize(Bodies& bodies, Index rows);

/// Appends a row of defaults to every field and returns its place; `owned` is left to the caller.
Index append_row(Bodies& bodies);

/// From now on bodies have these fields: what they did not have is its default.
void set_fields(Bodies& bodies, const FieldSet& fields);

}  // namespace spall
