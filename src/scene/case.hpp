// A case: everything a user asked for, as read from a TOML file, in SI units.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <any>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "engine/between.hpp"
#include "engine/type.hpp"
#include "gravity/map.hpp"
#include "keys/input_files.hpp"
#include "scene/point_source.hpp"
#include "scene/surface_mesh.hpp"
#include "spall/scene.hpp"
#include "spall/types.hpp"

namespace spall {

enum class Shape { sphere, box, ellipsoid, hollow_sphere, cylinder, mesh };

struct Volume {
  Shape shape = Shape::sphere;
  Vec3 center = Vec3::Zero();
  Mat3 axes = Mat3::Identity();  ///< its own, as columns: what is in it turns along
  Vec3 extents = Vec3::Zero();   ///< full widths along its axes (box, ellipsoid); cylinder:
                                 ///< diameter, diameter, height
  double radius = 0;             ///< outer radius of sphere, hollow_sphere
  double inner_radius = 0;       ///< of hollow_sphere
  std::string file = {};         ///< of mesh: a Wavefront OBJ file
  double unit = 1;               ///< m, of mesh: the length of 1 in its file
  std::shared_ptr<const SurfaceMesh> mesh = nullptr;  ///< read_case reads it from the file
};

/// A body of an earlier run.
struct StoredBody {
  Vec3 position;        ///< m, from the centre of mass of those that can move
  double radius = 0;    ///< m
  double mass = 0;      ///< kg
  Vec3 velocity, spin;  ///< m/s, rad/s
  bool fixed = false;   ///< never moves: it has no mass of its own
  double damage = 0;    ///< as in the file; a packing does not take it over
  int material = 0;     ///< the same
};

struct PackingType;  // scene/packing.hpp
extern const PackingType single_packing;

enum class Orientation { rotation, random };
enum class StoredMotion { kept, none };

/// How a volume is filled.
struct Packing {
  const PackingType* type = &single_packing;
  double radius = 0;  ///< m, of the spheres; of unequal ones the largest
  std::optional<double> spacing =
      std::nullopt;  ///< m, of lattices, nearest neighbours; 2 radius where left out
  std::optional<std::int64_t> count = std::nullopt;  ///< of bodies, where it is known beforehand
  Vec3 rotation = Vec3::Zero();                      ///< rotation vector, rad
  Orientation orientation = Orientation::rotation;   ///< random: `rotation` is drawn by the seed
  std::optional<double> grain = std::nullopt;        ///< m, of a lattice of many grains: mean size
  std::string file = {};                             ///< of file: a restart file of an earlier run
  std::vector<StoredBody> stored = {};               ///< of file: with_stored_bodies puts them here
  Vec3 stored_period = Vec3::Zero();                 ///< of file: m, `Period::size` of their run
  StoredMotion stored_motion = StoredMotion::kept;   ///< of file: none: bodies are at rest
  std::vector<std::string> shape_names = {};         ///< that bodies draw from; empty: spheres
  std::vector<std::int32_t> shapes = {};             ///< places of these in the case's shapes
  std::any own = {};                                 ///< what its type alone knows
};

/// A shape as a case tells it, in any unit.
struct ListedShape {
  std::string name;
  std::string place;  ///< where the case asks for it, for messages
  std::vector<ShapeSphere> spheres = {};
};

/// Random velocities, as molecules have them.
struct ThermalVelocity {
  double rms = 0;  ///< m/s, of each component
  std::uint64_t seed = 1;
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
  std::optional<ThermalVelocity> thermal = std::nullopt;  ///< beside `velocity` and `spin`
  bool fixed = false;                                     ///< infinite mass, at rest
  std::optional<PrescribedMotion> motion = std::nullopt;  ///< infinite mass, by the run's time

  /// Whatever acts on it, its motion stays.
  bool held() const { return fixed || motion; }
};

/// How the line of flight is laid: head_on shifts it to pass through the centre of the first sphere
/// that it meets.
enum class Aiming { head_on, line };

/// A sphere added at the start of a phase, aimed at the target along a direction.
struct Impactor {
  double mass = 0;
  double radius = 0;
  std::string place = {};  ///< where the case asks for it, for messages
  int material = 0;        ///< the case's, named "impactor"; else read_case adds one of its density
  double speed = 0;        ///< m/s, relative to the target's centre of mass
  Vec3 direction = Vec3::UnitX();  ///< of flight, unit vector
  double distance = 0;         ///< m flown before the first contact; head-on: the gap at the start
  Vec3 offset = Vec3::Zero();  ///< m, of the aiming line from the target's centre of mass
  Aiming aim = Aiming::head_on;
  /// Its flow is handed to the bodies; without it, it hits them as a rigid body.
  std::optional<PointSource> coupling = std::nullopt;
};

enum class PhaseEnd { time, settled };

struct Phase {
  std::string name;
  std::string place;                   ///< where the case asks for it: "x.toml:12:1: phases.hit"
  const EngineType* engine = nullptr;  ///< how bodies act on each other where they meet
  double step = 0;                     ///< s
  double duration = 0;                 ///< s; until settled the longest
  PhaseEnd until = PhaseEnd::time;
  double settled_speed = 0;          ///< m/s, rms; settled below it
  std::optional<double> cohesion;    ///< N, set at the start of the phase
  std::optional<Impactor> impactor;  ///< added at the start of the phase
  bool remove_drift = false;         ///< at the start: centre of mass to rest at the origin
  EngineSettings settings;           ///< the case's, with what the phase changes

  bool has_impactor() const { return impactor.has_value(); }
  /// That it lasts, at most where it ends settled.
  std::int64_t steps() const { return std::llround(duration / step); }
  double lasts() const { return step * static_cast<double>(steps()); }  ///< s, of whole steps
};

struct OutputSettings {
  double snapshot_every = 0;  ///< s of simulated time; 0: at the ends of phases only
  std::optional<double>
      series_every;            ///< s of simulated time; 0: every step; none: see timetable.cpp
  double restart_every = 600;  ///< s of wall time
};

/// A plate behind which debris are measured.
struct DebrisPlate {
  std::string name;  ///< of its group
  int group = -1;
  std::string section;  ///< what its sections of the results end in: "_wall"; "" of `plate` alone
};

/// What is measured of a projectile's debris behind plates, of each as if it were alone.
struct DebrisSettings {
  int projectile = -1;  ///< group
  std::string projectile_name;
  std::vector<DebrisPlate> plates;
  double every = 0;            ///< s; 0: at the end only
  std::optional<double> wall;  ///< m behind the plate, of the wall that they are to hit
  std::string place;           ///< where the case asks for it, for messages
};

/// A wall that is judged in the end: is it held, spalled or perforated?
struct Shield {
  int wall = -1;  ///< group
  std::string wall_name;
  Vec3 rear = Vec3::Zero();  ///< unit normal of the wall, away from what flies at it
  std::string place;         ///< where the case asks for it, for messages
};

/// The orbit whose change is asked for (thesis eqs. 3.3, 3.4).
struct Binary {
  double separation = 0;   ///< m, R
  double speed = 0;        ///< m/s, v_old; negative where the impactor comes from ahead
  double parameter = 0;    ///< m^3/s^2, mu
  double period = 0;       ///< s, T_old
  std::string place = {};  ///< where the case asks for it, for messages
};

struct Case : Surroundings {
  std::string file;                    ///< where it was read
  std::string text;                    ///< the file as read: with `overrides` gives the case again
  std::vector<std::string> overrides;  ///< "key.path=value"
  /// What the library and the files of materials hold, as overrides that come before those.
  std::vector<std::string> constants;
  std::string resolved;  ///< TOML that is this case, with `overrides` in it; empty: a program added
                         ///< to it what no file tells
  std::vector<std::string> unused;  ///< its tables and keys that nothing reads, and why
  std::string title;
  std::string reference;         ///< file with a source's values, for the report; empty: none
  std::string reference_place;   ///< where the case asks for it, for messages
  std::string contact_of;        ///< material from which cohesion follows; empty: none
  std::string contact_of_place;  ///< where the case asks for it, for messages
  // [contact] itself: it does not follow.
  bool tells_cohesion = false, tells_range = false, tells_friction = false;
  std::vector<Between<ContactLaw>> contact_between;
  double allowed_overlap = 1e-3;  ///< of two bodies at the start, in units of the smaller radius
  std::vector<ListedShape> listed_shapes;
  std::vector<Group> groups;
  std::optional<Grid> gravity_map;  ///< where snapshots have gravity's field
  EngineSettings engines;           ///< what the case tells them
  std::vector<Phase> phases;
  OutputSettings output;
  std::optional<Binary> binary;
  std::optional<DebrisSettings> debris;
  std::vector<Shield> shields;
  std::vector<SceneSphere> spheres;  ///< that a program added; masses as they are
  std::vector<double> read_out;      ///< s after the impactor was added: where dv is tabulated
  std::string read_out_place;        ///< where the case asks for it, for messages
};

/// The seed of random numbers of a group: changing one group leaves the others as they are.
inline std::uint64_t stream_of(const Case& scene, std::size_t group) {
  return scene.seed * 0x9E3779B97F4A7C15u + group;
}

/// Reads and checks a case. `overrides` are "key.path=value" as given to --set; elements of arrays
/// go by place or by name ("phases.0.step=1e-4", "phases.impact.step=1e-4"). Throws Error with
/// file, line, key and what would be right.
Case read_case(const std::string& file, const std::vector<std::string>& overrides = {},
               const InputFiles& files = {});

/// Whether a case without bodies of its own is an error.
enum class Groups { needed, may_lack };
/// The same from the text of a file. With its `constants` a restart gets its case back: files that
/// the case names need not be there any more.
Case parse_case(const std::string& text, const std::string& file,
                const std::vector<std::string>& overrides = {}, Groups groups = Groups::needed,
                const InputFiles& files = {}, const std::vector<std::string>& constants = {});

/// Laws know the spheres that a program has added, too, and what a case is refused for is asked
/// again with them. Throws Error.
void check_spheres(Case& scene);

/// The case files in a folder and below it, sorted. Beside a case.toml other files are not cases.
std::vector<std::string> find_cases(const std::string& folder);

/// Every key of a case file with its unit, default and meaning: written by the reader itself.
std::string case_reference();

}  // namespace spall
