// Names of columns stand beside their values, in for_each_column.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/debris_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scene/read_walls.hpp"

namespace spall {

DebrisLog::DebrisLog(const Case& scene) {
  if (!scene.debris) return;
  for (const DebrisPlate& plate : scene.debris->plates)
    plates_.push_back({.laid = plate, .target = find_target(scene, plate)});
  projectile_ = scene.debris->projectile_name;
  wall_ = scene.debris->wall;
  every_ = scene.debris->every;
}

void DebrisLog::weigh(std::span<const GroupContent> groups) {
  for (Plate& plate : plates_)
    plate.target.areal_density = groups[plate.laid.group].mass / plate.target.area;
}

namespace {

/// What speaks against numbers of a plate; empty where nothing does.
std::string doubt_of(const DebrisPlate& laid, const Target& target, const Cloud& cloud) {
  std::string text;
  if (std::abs(cloud.plate_moved) > target.clearance())
    text = fmt::format(
        "{} has moved by {:.4g} m, more than a quarter of the projectile: bodies of it count as "
        "debris, and the hole is not to be believed; make it wider, or the run shorter",
        laid.name, cloud.plate_moved);
  if (std::isnan(cloud.hole_spread))
    text += fmt::format(
        "{}the hole of {} reaches its rim, and may be wider than {:.4g} m; make it wider",
        text.empty() ? "" : "; ", laid.name, cloud.hole);
  return text;
}

}  // namespace

std::vector<std::string> DebrisLog::read_out(const World& world, double time) {
  std::vector<std::string> lines;
  for (auto& [laid, t, rows] : plates_) {
    const Cloud c = measure_cloud(world.comm, world.bodies, t, time);
    rows.push_back(c);
    lines.push_back(fmt::format(
        "debris{} at {:.4g} s: front {:.4g}, centre {:.4g}, rear {:.4g}, radial {:.4g} of the "
        "impact's speed; hole {:.4g} +- {:.2g} diameters",
        laid.section.empty() ? "" : " behind " + laid.name, time, c.front / t.speed,
        c.centre / t.speed, c.rear / t.speed, c.radial / t.speed, c.hole / t.diameter,
        c.hole_spread / t.diameter));
    if (const std::string doubt = doubt_of(laid, t, c); !doubt.empty())
      lines.push_back("WARNING: " + doubt);
  }
  return lines;
}

std::vector<std::string> DebrisLog::conclude(const World& world, const Engine& engine, bool bonded,
                                             double time, ResultTable& table) {
  std::vector<std::string> lines;
  if (plates_.empty()) return lines;
  for (auto& [laid, t, rows] : plates_)
    if (rows.empty() || rows.back().time < time)
      rows.push_back(measure_cloud(world.comm, world.bodies, t, time));
  std::optional<LinkedBodies> linked;
  if (bonded) linked.emplace(engine.links(world));
  for (const Plate& plate : plates_) {
    conclude(plate, world, linked ? &*linked : nullptr, table);
    const std::string doubt = doubt_of(plate.laid, plate.target, plate.rows.back());
    if (doubt.empty()) continue;
    table.add("debris" + plate.laid.section, "warning", doubt);
    lines.push_back("WARNING: " + doubt);
  }
  return lines;
}

void DebrisLog::conclude(const Plate& plate, const World& world, const LinkedBodies* linked,
                         ResultTable& table) const {
  const Target& t = plate.target;
  const Cloud& last = plate.rows.back();
  const auto named = [&](const char* section) { return section + plate.laid.section; };
  const std::string debris = named("debris"), fragments = named("fragments"), wall = named("wall");
  for_each_column(last, [&](const char* name, double value, const char* unit, const char* note) {
    table.add(debris, name, value, unit, note);
  });
  const auto components = [](const Vec3& v) { return std::vector<double>(v.data(), v.data() + 3); };
  table.add(debris, "speed", t.speed, "m/s", "of the impact");
  table.add(debris, "diameter", t.diameter, "m", "of the projectile, D");
  table.add(debris, "origin", components(t.origin), "m",
            "on the rear, behind where its line meets the middle of the plate");
  table.add(debris, "normal", components(t.normal), "", "of the plate, to its rear");
  table.add(debris, "front_over_speed", last.front / t.speed, "", "of the impact");
  table.add(debris, "radial_over_speed", last.radial / t.speed);
  table.add(debris, "hole_over_diameter", last.hole / t.diameter, "", "of the projectile");
  table.add(debris, "contour_length_over_width",
            last.contour_width > 0 ? last.contour_length / last.contour_width : 0.0);
  const double momentum = last.projectile_momentum + last.plate_momentum;
  table.add(debris, "momentum_forward", momentum, "kg m/s");
  if (linked) {
    const Fragments f =
        find_fragments(world.comm, linked->ghosts, linked->bodies, linked->links, t);
    table.add(fragments, "pieces", f.pieces, "", "of two bodies or more, in the debris");
    table.add(fragments, "singles", f.singles, "", "bodies alone");
    table.add(fragments, "largest", f.largest, "kg");
    table.add(fragments, "by_decade", f.counts, "", "pieces of 2 to 9, 10 to 99, ... bodies");
  }
  if (wall_) {
    const WallLoad load = load_wall(world.comm, world.bodies, t, *wall_);
    table.add(wall, "distance", *wall_, "m", "behind the plate; debris fly there freely");
    table.add(wall, "momentum", load.momentum, "kg m/s");
    table.add(wall, "half_radius", load.half_radius, "m", "with half of it");
    table.add(wall, "radius", load.radius, "m", "with 90 % of it");
    table.add(wall, "peak", load.peak, "Pa s", "on a pixel of half a diameter");
  }
  for_each_column(last, [&](const std::string& name, double, const char* unit, const char*) {
    std::vector<double> values;
    for (const Cloud& row : plate.rows)
      for_each_column(row, [&](const char* other, double value, const char*, const char*) {
        if (name == other) values.push_back(value);
      });
    table.add(named("cloud"), name, values, unit);
  });
}

/// Another plate, or another projectile, has another history.
std::string DebrisLog::key_of(const DebrisPlate& plate) const {
  return fmt::format("debris.{}.{}", column_name(projectile_), column_name(plate.name));
}

void DebrisLog::save(Scalars& scalars) const {
  for (const auto& [laid, target, rows] : plates_) {
    const std::string key = key_of(laid);
    scalars[key + ".rows"] = static_cast<double>(rows.size());
    for (std::size_t r = 0; r < rows.size(); ++r)
      for_each_column(rows[r], [&](const char* name, double value, const char*, const char*) {
        scalars[fmt::format("{}.{}.{}", key, r, name)] = value;
      });
  }
}

void DebrisLog::load(const Scalars& scalars) {
  for (auto& [laid, target, rows] : plates_) {
    const std::string key = key_of(laid);
    if (!scalars.contains(key + ".rows")) continue;  // of a plate that is named from here on
    rows.resize(static_cast<std::size_t>(find_scalar(scalars, key + ".rows")));
    for (std::size_t r = 0; r < rows.size(); ++r)
      for_each_column(rows[r], [&](const char* name, double& value, const char*, const char*) {
        value = find_scalar(scalars, fmt::format("{}.{}.{}", key, r, name));
      });
  }
}

}  // namespace spall
