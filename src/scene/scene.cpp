// Runs through the recipes of a case and keeps this rank's share of the bodies.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/scene/scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <numeric>
#include <optional>

#include "spall/base/require.hpp"
#include "spall/scene/packing.hpp"
#include "spall/scene/shape.hpp"

namespace spall {
namespace {

using Place = std::function<void(const Vec3&)>;

void place_group_at_random(const Group& group, std::uint64_t seed,
                           const std::function<bool(const Vec3&)>& is_free, const Place& place) {
  const std::int64_t count = group.packing.count.value();
  const std::int64_t placed = place_at_random(group.volume, group.packing, seed, is_free, place);
  const double share = ball_volume(group.packing.radius) / volume_of(group.volume);
  require(
      placed == count,
      "{}: {} spheres of radius {} m would be {:.3f} of the volume; {} ({:.3f}) found a place at "
      "random: enlarge the volume (random packings end near 0.38) or take a lattice",
      group.place, count, group.packing.radius, static_cast<double>(count) * share, placed,
      static_cast<double>(placed) * share);
}

/// Calls `place` with the centre of every body of group `g`; random ones are where `is_free`.
void place_group(const Case& scene, std::size_t g, const std::function<bool(const Vec3&)>& is_free,
                 const Place& place) {
  const Group& group = scene.groups[g];
  switch (group.packing.kind) {
    case PackingKind::single:
      return place(group.volume.center);
    case PackingKind::random:
      // A stream of its own for each group: changing one leaves the others as they are.
      return place_group_at_random(group, scene.seed * 0x9E3779B97F4A7C15u + g, is_free, place);
    default:
      return place_lattice(group.volume, group.packing, place);
  }
}

/// Half widths of the box that holds all spheres of a group: those of lattices may stand out.
Vec3 reach(const Group& group) {
  return half_widths(group.volume) + Vec3::Constant(group.packing.radius);
}

bool may_touch(const Group& a, const Group& b) {
  const Vec3 apart = (a.volume.center - b.volume.center).cwiseAbs();
  return (apart.array() <= (reach(a) + reach(b)).array()).all();
}

/// The bodies that later groups must keep clear of.
struct Placed {
  std::size_t group;
  BodyId first;
  SphereGrid grid;
};

std::string words(const Vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", v.x(), v.y(), v.z());
}

/// Throws unless the sphere at `center`, body `id` of `group`, is clear of planes and of `placed`.
void check_clear(const Case& scene, const Group& group, const std::vector<Placed>& placed,
                 BodyId id, const Vec3& center) {
  const double radius = group.packing.radius;
  for (std::size_t p = 0; p < scene.planes.size(); ++p) {
    const double gap = scene.planes[p].normal.dot(center - scene.planes[p].point) - radius;
    require(gap >= -scene.allowed_overlap * radius,
            "{}: body {} at {} lies {:.3g} m deep in planes.{}; allowed_overlap = {} of its "
            "radius, {} m",
            group.place, id, words(center), -gap, p, scene.allowed_overlap, radius);
  }
  for (const Placed& earlier : placed) {
    const double other = earlier.grid.radius(), smaller = std::min(radius, other);
    const std::int64_t hit =
        earlier.grid.find_nearer(center, radius + other - scene.allowed_overlap * smaller);
    if (hit < 0) continue;
    const Vec3& at = earlier.grid.center(hit);
    throw Error(fmt::format(
        "{}: body {} at {} overlaps body {} of groups.{} at {} by {:.3g} m; allowed_overlap = {} "
        "of the smaller radius, {} m",
        group.place, id, words(center), earlier.first + hit, scene.groups[earlier.group].name,
        words(at), radius + other - (at - center).norm(), scene.allowed_overlap, smaller));
  }
}

}  // namespace

double mass_of_one(const Case& scene, const Group& group, std::int64_t count) {
  if (group.total_mass) return *group.total_mass / static_cast<double>(count);
  const Material& material = scene.materials[group.material];
  return material.solid ? sphere_mass(*material.solid, lattice_of(group.packing))
                        : material.density * ball_volume(group.packing.radius);
}

std::vector<std::int64_t> count_bodies(const Case& scene) {
  std::vector<std::int64_t> counts;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    std::int64_t count = group.packing.count.value_or(0);
    if (!group.packing.count) place_group(scene, g, {}, [&](const Vec3&) { ++count; });
    require(count > 0, "{}: its volume holds no sphere of radius {} m", group.place,
            group.packing.radius);
    counts.push_back(count);
  }
  return counts;
}

Bodies make_bodies(const Case& scene, const Comm& comm) {
  const std::vector<std::int64_t> counts = count_bodies(scene);
  const std::int64_t all = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  require(all > 0, "{}: no bodies", scene.file);
  require(all >= comm.size, "{}: {} bodies on {} ranks: run it on at most {}", scene.file, all,
          comm.size, all);
  const BodyId first_owned = all * comm.rank / comm.size;
  const BodyId end_owned = all * (comm.rank + 1) / comm.size;

  Bodies bodies;
  bodies.owned = static_cast<Index>(end_owned - first_owned);
  for_each_field(bodies, [&](const char*, auto& field) { field.reserve(bodies.owned); });

  std::vector<Placed> placed;
  BodyId id = 0;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    const double mass = group.fixed ? infinity : mass_of_one(scene, group, counts[g]);
    const bool random = group.packing.kind == PackingKind::random;
    std::optional<SphereGrid> grid;
    if (std::any_of(scene.groups.begin() + g + 1, scene.groups.end(),
                    [&](const Group& later) { return may_touch(group, later); }))
      grid.emplace(group.volume.center, reach(group), group.packing.radius, counts[g]);
    const BodyId first = id;

    const auto is_free = [&](const Vec3& center) {
      const double radius = group.packing.radius;
      for (const Plane& plane : scene.planes)
        if (plane.normal.dot(center - plane.point) < radius) return false;
      for (const Placed& earlier : placed)
        if (earlier.grid.find_nearer(center, radius + earlier.grid.radius()) >= 0) return false;
      return true;
    };
    const auto place = [&](const Vec3& center) {
      if (!random) check_clear(scene, group, placed, id, center);
      if (grid) grid->add(center);
      if (id >= first_owned && id < end_owned) {
        const Index row = append_row(bodies);
        bodies.id[row] = id;
        bodies.group[row] = static_cast<std::int32_t>(g);
        bodies.material[row] = group.material;
        bodies.radius[row] = group.packing.radius;
        bodies.mass[row] = mass;
        bodies.position[row] = center;
        bodies.velocity[row] = group.velocity + group.spin.cross(center - group.volume.center);
        bodies.angular_velocity[row] = group.spin;
      }
      ++id;
    };
    place_group(scene, g, is_free, place);
    if (grid) placed.push_back({g, first, std::move(*grid)});
  }
  return bodies;
}

}  // namespace spall
