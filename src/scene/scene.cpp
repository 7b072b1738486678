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

using IsFree = std::function<bool(const Vec3& center, double radius)>;
using Place = std::function<void(const Vec3& center, double radius, double mass)>;

void place_group_at_random(const Group& group, std::uint64_t seed, const IsFree& is_free,
                           const std::function<void(const Vec3&)>& place) {
  const double radius = group.packing.radius;
  const std::int64_t count = group.packing.count.value();
  const std::int64_t placed = place_at_random(
      group.volume, group.packing, seed, [&](const Vec3& x) { return is_free(x, radius); }, place);
  const double share = ball_volume(radius) / volume_of(group.volume);
  require(
      placed == count,
      "{}: {} spheres of radius {} m would be {:.3f} of the volume; {} ({:.3f}) found a place at "
      "random: enlarge the volume (random packings end near 0.38) or take a lattice",
      group.place, count, radius, static_cast<double>(count) * share, placed,
      static_cast<double>(placed) * share);
}

/// Calls `place` with those bodies of an earlier run that have their centres in the volume.
void place_stored(const Group& group, const Place& place) {
  const Vec3& turn = group.packing.rotation;
  const Eigen::Matrix3d rotation(Eigen::AngleAxisd(turn.norm(), turn.stableNormalized()));
  for (const StoredBody& body : group.packing.stored) {
    const Vec3 center = group.volume.center + rotation * body.position;
    if (depth(group.volume, center) >= 0) place(center, body.radius, body.mass);
  }
}

/// kg, of a sphere: one of a solid's lattice stands for its cell.
double mass_of_sphere(const Case& scene, const Group& group, double radius) {
  const Material& material = scene.materials[group.material];
  const Lattice lattice = lattice_of(group.packing);
  return material.solid && lattice.neighbours > 0 ? sphere_mass(*material.solid, lattice)
                                                  : material.density * ball_volume(radius);
}

/// Calls `place` with every body of group `g`; those of a random packing are where `is_free`.
/// Masses are those before they are scaled to the group's total.
void place_group(const Case& scene, std::size_t g, const IsFree& is_free, const Place& place) {
  const Group& group = scene.groups[g];
  const auto place_sized = [&](const Vec3& center, double radius) {
    place(center, radius, mass_of_sphere(scene, group, radius));
  };
  const auto place_equal = [&](const Vec3& center) { place_sized(center, group.packing.radius); };
  // A stream of its own for each group: changing one leaves the others as they are.
  const std::uint64_t seed = scene.seed * 0x9E3779B97F4A7C15u + g;
  switch (group.packing.kind) {
    case PackingKind::single:
      return place_equal(group.volume.center);
    case PackingKind::random:
      return place_group_at_random(group, seed, is_free, place_equal);
    case PackingKind::graded:
      return place_graded(group.volume, group.packing, seed, place_sized);
    case PackingKind::file:
      return place_stored(group, place);
    default:
      return place_lattice(group.volume, group.packing, place_equal);
  }
}

/// Half widths of the box that holds all spheres of a group: those of lattices may stand out.
Vec3 reach(const Group& group) {
  double largest = group.packing.radius;
  for (const StoredBody& body : group.packing.stored) largest = std::max(largest, body.radius);
  return half_widths(group.volume) + Vec3::Constant(largest);
}

bool may_touch(const Group& a, const Group& b) {
  const Vec3 apart = (a.volume.center - b.volume.center).cwiseAbs();
  return (apart.array() <= (reach(a) + reach(b)).array()).all();
}

/// The bodies that later groups must keep clear of.
struct Placed {
  std::size_t group;
  BodyId first;
  SphereSet spheres;
};

std::string words(const Vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", v.x(), v.y(), v.z());
}

/// Throws unless the sphere at `center`, body `id` of `group`, is clear of planes and of `placed`.
void check_clear(const Case& scene, const Group& group, const std::vector<Placed>& placed,
                 BodyId id, const Vec3& center, double radius) {
  for (std::size_t p = 0; p < scene.planes.size(); ++p) {
    const double gap = scene.planes[p].normal.dot(center - scene.planes[p].point) - radius;
    require(gap >= -scene.allowed_overlap * radius,
            "{}: body {} at {} lies {:.3g} m deep in planes.{}; allowed_overlap = {} of its "
            "radius, {} m",
            group.place, id, words(center), -gap, p, scene.allowed_overlap, radius);
  }
  for (const Placed& earlier : placed) {
    const auto hit = earlier.spheres.find_overlap(center, radius, scene.allowed_overlap);
    if (!hit) continue;
    throw Error(fmt::format(
        "{}: body {} at {} overlaps body {} of groups.{} at {} by {:.3g} m; allowed_overlap = {} "
        "of the smaller radius, {} m",
        group.place, id, words(center), earlier.first + hit->sphere,
        scene.groups[earlier.group].name, words(hit->center), hit->depth, scene.allowed_overlap,
        std::min(radius, hit->radius)));
  }
}

/// What the mass of each body of a group is multiplied with.
double mass_factor(const Group& group, const GroupContent& content) {
  if (group.fixed) return infinity;
  return group.total_mass ? *group.total_mass / content.mass : 1;
}

}  // namespace

std::vector<GroupContent> measure_groups(const Case& scene) {
  std::vector<GroupContent> contents;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    GroupContent content;
    const auto count = [&](std::int64_t bodies, double radius, double mass) {
      content.count += bodies;
      content.volume += static_cast<double>(bodies) * ball_volume(radius);
      content.mass += static_cast<double>(bodies) * mass;
      content.smallest = std::min(content.smallest, radius);
      content.largest = std::max(content.largest, radius);
    };
    if (const auto known = group.packing.count) {
      const double radius = group.packing.radius;
      count(*known, radius, mass_of_sphere(scene, group, radius));
    } else {
      place_group(scene, g, {},
                  [&](const Vec3&, double radius, double mass) { count(1, radius, mass); });
    }
    require(content.count > 0, "{}: its volume holds no sphere{}", group.place,
            group.packing.kind == PackingKind::file
                ? fmt::format(" of '{}'", group.packing.file)
                : fmt::format(" of radius {} m", group.packing.radius));
    contents.push_back(content);
  }
  return contents;
}

OptionalFields fields_of(const Case& scene) {
  const auto uses = [&](Method method) {
    return std::ranges::any_of(scene.phases, [&](const Phase& p) { return p.method == method; });
  };
  const bool nonsmooth = uses(Method::nonsmooth), penalty = uses(Method::penalty);
  const bool potential = uses(Method::potential) && scene.potential;
  const bool damped = potential && scene.potential->damping > 0;
  const bool spins =
      std::ranges::any_of(scene.groups, [](const Group& g) { return !g.spin.isZero(0); });
  const bool gravity =
      scene.gravity.method != GravityMethod::none || !scene.uniform_gravity.isZero(0);
  return {.angular_velocity = nonsmooth || penalty || spins,
          .acceleration = nonsmooth || gravity,
          .heat = penalty || damped,
          .kick = damped,
          .bonds = potential && scene.potential->breaking_strain > 0};
}

Bodies make_bodies(const Case& scene, const Comm& comm) {
  const std::vector<GroupContent> contents = measure_groups(scene);
  std::int64_t all = 0;
  for (const GroupContent& content : contents) all += content.count;
  require(all > 0, "{}: no bodies", scene.file);
  require(all >= comm.size, "{}: {} bodies on {} ranks: run it on at most {}", scene.file, all,
          comm.size, all);
  const BodyId first_owned = all * comm.rank / comm.size;
  const BodyId end_owned = all * (comm.rank + 1) / comm.size;

  Bodies bodies;
  bodies.has = fields_of(scene);
  bodies.owned = static_cast<Index>(end_owned - first_owned);
  for_each_field(bodies, [&](const char*, auto& field) { field.reserve(bodies.owned); });

  std::vector<Placed> placed;
  BodyId id = 0;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    const double factor = mass_factor(group, contents[g]);
    const bool random = group.packing.kind == PackingKind::random;
    std::optional<SphereSet> spheres;
    if (std::any_of(scene.groups.begin() + g + 1, scene.groups.end(),
                    [&](const Group& later) { return may_touch(group, later); }))
      spheres.emplace(group.volume.center, reach(group), contents[g].count);
    const BodyId first = id;

    const auto is_free = [&](const Vec3& center, double radius) {
      for (const Plane& plane : scene.planes)
        if (plane.normal.dot(center - plane.point) < radius) return false;
      for (const Placed& earlier : placed)
        if (earlier.spheres.find_overlap(center, radius, 0)) return false;
      return true;
    };
    const auto place = [&](const Vec3& center, double radius, double mass) {
      if (!random) check_clear(scene, group, placed, id, center, radius);
      if (spheres) spheres->add(center, radius);
      if (id >= first_owned && id < end_owned) {
        const Index row = append_row(bodies);
        bodies.id[row] = id;
        bodies.group[row] = static_cast<std::int32_t>(g);
        bodies.material[row] = group.material;
        bodies.radius[row] = radius;
        bodies.mass[row] = factor * mass;
        bodies.position[row] = center;
        bodies.velocity[row] = group.velocity + group.spin.cross(center - group.volume.center);
        if (bodies.has.angular_velocity) bodies.angular_velocity[row] = group.spin;
      }
      ++id;
    };
    place_group(scene, g, is_free, place);
    if (spheres) placed.push_back({g, first, std::move(*spheres)});
  }
  return bodies;
}

}  // namespace spall
