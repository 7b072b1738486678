// A case: everything a user asked for, as read from a TOML file, in SI units.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "spall/analysis/gravity_map.hpp"
#include "spall/base/types.hpp"
#include "spall/domain/halo.hpp"
#include "spall/force/constitutive.hpp"
#include "spall/force/gravity.hpp"
#include "spall/force/pair_potential.hpp"
#include "spall/force/penalty.hpp"
#include "spall/scene/surface_mesh.hpp"
#include "spall/solver/problem.hpp"

namespace spall {

struct Material {
  std::string name;
  double density = 0;  ///< kg/m^3 of a sphere of it
  /// What it is a piece of: then `density` is the solid's, and a sphere of a lattice has the mass
  /// of its cell.
  std::optional<Solid> solid = std::nullopt;
};

/// What happens where two bodies meet.
struct ContactLaw {
  double friction = 0;
  double restitution = 0;
  double cohesion = 0;               ///< N, attractive, on every pair with gap <= cohesion_range
  double cohesion_range = 0;         ///< m
  bool cohesion_is_impulse = false;  ///< cohesion read as N s a step, as the reference engine does
};

enum class Shape { sphere, box, ellipsoid, hollow_sphere, cylinder, mesh };

struct Volume {
  Shape shape = Shape::sphere;
  Vec3 center = Vec3::Zero();
  Vec3 extents = Vec3::Zero();  ///< full widths (box, ellipsoid); cylinder: diameter, diameter,
                                ///< height (along z)
  double radius = 0;            ///< outer radius of sphere, hollow_sphere
  double inner_radius = 0;      ///< of hollow_sphere
  std::string file = {};        ///< of mesh: a Wavefront OBJ file
  double unit = 1;              ///< m, of mesh: the length of 1 in its file
  std::shared_ptr<const SurfaceMesh> mesh = nullptr;  ///< read_case reads it from the file
};

enum class PackingKind { single, random, simple_cubic, fcc, hcp, graded, file };

/// Boulders that are fine around a site and coarse far from it. At x the largest have the radius
///   R(x) = growth |x - site|, not below `smallest` and not above the packing's radius,
/// and there are N(>r) ~ r^-exponent of them from R down to R/4, which together fill `fill`.
struct Grading {
  Vec3 site = Vec3::Zero();  ///< m
  double smallest = 0;       ///< m
  double growth = 0;
  double exponent = 3;
  double fill = 0.5;
};

/// A body of an earlier run.
struct StoredBody {
  Vec3 position;  ///< m, from the centre of mass
  double radius, mass;
};

struct Packing {
  PackingKind kind = PackingKind::single;
  double radius = 0;  ///< of the spheres; of graded ones the largest
  std::optional<double> spacing =
      std::nullopt;  ///< of lattices, nearest neighbours; 2 radius where left out
  std::optional<std::int64_t> count = std::nullopt;  ///< of random packings
  Vec3 rotation = Vec3::Zero();         ///< of lattices and stored bodies: rotation vector, rad
  bool random_orientation = false;      ///< `rotation` is drawn by the case's seed
  Grading grading = {};                 ///< of graded
  std::string file = {};                ///< of file: a restart file of an earlier run
  std::vector<StoredBody> stored = {};  ///< of file: read_stored_bodies puts them here
};

/// One recipe: a volume filled with spheres of one material.
struct Group {
  std::string name;
  std::string place;  ///< where the case asks for it, for messages: "x.toml:12:1: groups.cloud"
  int material = 0;
  Volume volume;
  Packing packing;
  std::optional<double> total_mass;  ///< spheres' density is scaled to give it (thesis eq. 2.13)
  Vec3 velocity = Vec3::Zero();
  Vec3 spin = Vec3::Zero();  ///< rad/s, rigid rotation about the volume's center
  bool fixed = false;        ///< infinite mass
};

/// A half-space that never moves: its surface passes through `point`, `normal` points to the free
/// side.
struct Plane {
  Vec3 point = Vec3::Zero();
  Vec3 normal = Vec3::UnitZ();
};

/// The space outside an endless cylinder, which never moves.
struct Cylinder {
  Vec3 point = Vec3::Zero();  ///< on the axis
  Vec3 axis = Vec3::UnitZ();
  double radius = 0;  ///< m
};

/// A sphere added at the start of a phase, aimed at the target along a direction.
struct Impactor {
  double mass = 0;
  double radius = 0;
  int material = 0;                ///< read_case adds one of its density, named "impactor"
  double speed = 0;                ///< m/s, relative to the target's centre of mass
  Vec3 direction = Vec3::UnitX();  ///< of flight, unit vector
  double distance = 0;         ///< m flown before the first contact; head-on: the gap at the start
  Vec3 offset = Vec3::Zero();  ///< m, of the aiming line from the target's centre of mass
  /// The line is shifted to pass through the centre of the first sphere that it meets: a head-on
  /// hit.
  bool head_on = true;
};

/// How bodies act on each other where they meet.
enum class Method { nonsmooth, potential, penalty };

struct Phase {
  std::string name;
  Method method = Method::nonsmooth;
  double step = 0;      ///< s
  double duration = 0;  ///< s; with `until_settled` the longest
  bool until_settled = false;
  double settled_speed = 0;              ///< m/s, rms; settled below it
  std::optional<double> cohesion;        ///< N, set at the start of the phase
  std::optional<Impactor> impactor;      ///< added at the start of the phase
  bool remove_drift = false;             ///< at the start: centre of mass to rest at the origin
  std::optional<SolverSettings> solver;  ///< where it differs from the case's
};

struct OutputSettings {
  double snapshot_every = 0;   ///< s of simulated time; 0: at the ends of phases only
  double series_every = 0;     ///< s of simulated time; 0: every step
  double restart_every = 600;  ///< s of wall time
};

/// What is measured of a projectile's debris behind a plate.
struct DebrisSettings {
  int projectile = -1, plate = -1;  ///< groups
  std::string projectile_name, plate_name;
  double every = 0;            ///< s; 0: at the end only
  std::optional<double> wall;  ///< m behind the plate, of the wall that they are to hit
  std::string place;           ///< where the case asks for it, for messages
};

/// The orbit whose change is asked for (thesis eqs. 3.3, 3.4).
struct Binary {
  double separation = 0;  ///< m, R
  double speed = 0;       ///< m/s, v_old; negative where the impactor comes from ahead
  double parameter = 0;   ///< m^3/s^2, mu
  double period = 0;      ///< s, T_old
};

/// A law that follows from a material's constants and the lattice of the groups that are of it.
struct DerivedLaw {
  std::string material;
  std::string place;  ///< where the case asks for it, for messages
  Match match = Match::solid;
};

struct Case {
  std::string file;                    ///< where it was read
  std::string text;                    ///< the file as read: with `overrides` gives the case again
  std::vector<std::string> overrides;  ///< "key.path=value"
  std::string title;
  std::string reference;        ///< file with a source's values, for the report; empty: none
  std::string reference_place;  ///< where the case asks for it, for messages
  std::uint64_t seed = 1;
  std::vector<Material> materials;
  ContactLaw contact;
  std::optional<PairPotential> potential;
  std::optional<PenaltySettings> penalty;
  std::optional<DerivedLaw> potential_of, contact_of;
  double allowed_overlap = 1e-3;  ///< of two bodies at the start, in units of the smaller radius
  std::vector<Group> groups;
  std::vector<Plane> planes;
  std::vector<Cylinder> cylinders;
  Period period;
  GravitySettings gravity;
  Vec3 uniform_gravity = Vec3::Zero();  ///< m/s^2
  std::optional<Grid> gravity_map;      ///< where snapshots have gravity's field
  SolverSettings solver;
  std::vector<Phase> phases;
  OutputSettings output;
  std::optional<Binary> binary;
  std::optional<DebrisSettings> debris;
  std::vector<double> read_out;  ///< s after the impactor was added: where dv is tabulated
};

/// Reads and checks a case. `overrides` are "key.path=value" as given to --set; elements of arrays
/// go by place or by name ("phases.0.step=1e-4", "phases.impact.step=1e-4"). Throws Error with
/// file, line, key and what would be right.
Case read_case(const std::string& file, const std::vector<std::string>& overrides = {});

/// The same from the text of a file: how a restart gets its case back. Files that the case names
/// need not be there any more.
Case parse_case(const std::string& text, const std::string& file,
                const std::vector<std::string>& overrides = {});

/// The case files in a folder and below it, sorted. Beside a case.toml other files are not cases.
std::vector<std::string> find_cases(const std::string& folder);

/// Every key of a case file with its unit, default and meaning: written by the reader itself.
std::string case_reference();

}  // namespace spall
