// What a plate's impact threw behind it, and what it left of the plate.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <string>
#include <vector>

#include "analysis/clumps.hpp"
#include "scene/case.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"

namespace spall {

/// The plate and what flies at it, as the case laid them. Places are told along the plate's normal,
/// 0 at its rear face, and across it from where the projectile's line of flight meets its middle.
struct Target {
  std::int32_t projectile = 0, plate = 0;  ///< groups
  Vec3 origin = Vec3::Zero();              ///< m
  Vec3 normal = Vec3::UnitZ();             ///< to the rear
  std::array<Vec3, 2> across;
  double diameter = 0;       ///< m, of the projectile, D
  double speed = 0;          ///< m/s
  double thickness = 0;      ///< m
  double half_width = 0;     ///< m, of the plate about the origin
  double area = 0;           ///< m^2, of the plate
  double areal_density = 0;  ///< kg/m^2, of the plate; by its material until it is weighed
  double density = 0;        ///< kg/m^3, of the projectile's solid
  /// J/kg from room temperature, of projectile and plate; 0: not known.
  std::array<double, 2> melt_energy{}, sublimation_energy{};

  /// m: what is farther from the plate has left it.
  double clearance() const { return diameter / 4; }
};
/// `plate` is one of the case's `debris->plates`.
Target find_target(const Case& scene, const DebrisPlate& plate);

/// One instant. Debris are the bodies of projectile and plate that are more than D/4 behind the
/// plate. Percentiles are weighted by mass. The contour is that of two side views, its width their
/// mean. A pixel is D/4 wide. It belongs to the cloud where the column of its mass, at the solid's
/// density, is longer than D/100.
struct Cloud {
  double time = 0;                         ///< s
  double front = 0, centre = 0, rear = 0;  ///< m/s along the normal: 99th percentile, mean, 1st
  double radial = 0;                       ///< m/s, 99th percentile
  double length = 0, width = 0;  ///< m: 1st to 99th percentile of place; twice the 99th of radius
  double contour_length = 0, contour_width = 0;        ///< m
  double projectile_mass = 0, plate_mass = 0;          ///< kg, in the debris
  double projectile_momentum = 0, plate_momentum = 0;  ///< kg m/s along the normal
  double projectile_melted = 0, plate_melted = 0;      ///< of these masses; NaN: not known
  double projectile_vapour = 0, plate_vapour = 0;      ///< the same
  double ejecta_mass = 0, ejecta_momentum = 0;  ///< more than D/4 before the plate, flying back
  double hole = 0, hole_spread = 0;  ///< m: where the plate has half of its areal density, mean and
                                     ///< standard deviation over twelve sectors; NaN: the hole
                                     ///< reaches the plate's rim, and may be wider
  double plate_speed = 0;            ///< m/s along the normal, mean of the plate's other bodies
  double plate_moved = 0;            ///< m along it, what is left of the plate
};
/// Velocities and positions must belong to the same instant. Collective.
Cloud measure_cloud(const Comm& comm, const Bodies& bodies, const Target& target, double time);

/// Calls `f(name, value, unit, note)` for each column.
template <class CloudLike, class F>
void for_each_column(CloudLike& c, F&& f) {
  f("time", c.time, "s", "");
  f("front", c.front, "m/s", "99th percentile of the debris' speeds along the plate's normal");
  f("centre", c.centre, "m/s", "their mean");
  f("rear", c.rear, "m/s", "1st percentile");
  f("radial", c.radial, "m/s", "99th percentile of speeds across it");
  f("length", c.length, "m", "1st to 99th percentile of place");
  f("width", c.width, "m", "twice the 99th percentile of radius");
  f("contour_length", c.contour_length, "m", "where a column is longer than D/100, pixels of D/4");
  f("contour_width", c.contour_width, "m", "mean of two side views");
  f("projectile_mass", c.projectile_mass, "kg", "of the projectile, in the debris");
  f("plate_mass", c.plate_mass, "kg", "of the plate");
  f("projectile_momentum", c.projectile_momentum, "kg m/s", "");
  f("plate_momentum", c.plate_momentum, "kg m/s", "");
  f("projectile_melted", c.projectile_melted, "",
    "part of that mass with more heat than melt_energy");
  f("plate_melted", c.plate_melted, "", "nan: no melt_energy, or a method without heat");
  f("projectile_vapour", c.projectile_vapour, "", "part with more heat than sublimation_energy");
  f("plate_vapour", c.plate_vapour, "", "nan as above");
  f("ejecta_mass", c.ejecta_mass, "kg", "before the plate, flying back");
  f("ejecta_momentum", c.ejecta_momentum, "kg m/s", "");
  f("hole", c.hole, "m", "diameter at half of the areal density");
  f("hole_spread", c.hole_spread, "m",
    "standard deviation over twelve sectors; nan: it reaches the rim");
  f("plate_speed", c.plate_speed, "m/s", "mean of what is left of the plate");
  f("plate_moved", c.plate_moved, "m",
    "beyond D/4 the plate counts as debris, and hole is not to be believed");
}

/// Pieces of the debris: bodies joined by links.
struct Fragments {
  std::int64_t pieces = 0;     ///< of two bodies or more
  std::int64_t singles = 0;    ///< bodies alone
  double largest = 0;          ///< kg
  std::vector<double> counts;  ///< pieces of 2 to 9, 10 to 99, ... bodies
};
/// Collective.
Fragments find_fragments(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                         const Links& links, const Target& target);

/// What a wall so far behind the plate receives, or would have, of debris that fly freely.
struct WallLoad {
  double momentum = 0;                 ///< kg m/s along the normal
  double half_radius = 0, radius = 0;  ///< m, about the line of flight: with half, 90 % of it
  double peak = 0;                     ///< Pa s, on the pixel, D/2 wide, with most of it; no
                                       ///< farther from the line than twice the distance
};
/// Collective.
WallLoad load_wall(const Comm& comm, const Bodies& bodies, const Target& target, double distance);

}  // namespace spall
