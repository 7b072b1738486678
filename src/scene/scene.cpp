// Runs through the recipes of a case and keeps this rank's share of the bodies.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/scene.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>

#include "base/hash.hpp"
#include "engine/between.hpp"
#include "scene/packing.hpp"
#include "scene/shape.hpp"
#include "scene/thermal.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

using IsFree = std::function<bool(const Vec3& center, double radius)>;
using Place = std::function<void(const PackedSphere&, double mass)>;

/// Place in the case's shapes, of the `k`-th body of group `g`: one that it draws, the same on any
/// number of ranks.
std::int32_t shape_of_body(const Case& scene, std::size_t g, BodyId k) {
  const std::vector<std::int32_t>& shapes = scene.groups[g].packing.shapes;
  if (shapes.empty()) return 0;
  if (shapes.size() == 1) return shapes[0];
  const std::uint64_t stream = mix(stream_of(scene, g) ^ 0x53484150);  // another than of places
  return shapes[mix(stream + static_cast<std::uint64_t>(k)) % shapes.size()];
}

/// m^3, of the `k`-th body of group `g`, with this radius.
double volume_of_body(const Case& scene, std::size_t g, BodyId k, double radius) {
  const std::int32_t shape = shape_of_body(scene, g, k);
  return shape == 0 ? ball_volume(radius) : scene.shapes[shape].volume * radius * radius * radius;
}

/// kg, of the `k`-th body of group `g`: a sphere of a solid's lattice stands for its cell.
double mass_of_body(const Case& scene, std::size_t g, BodyId k, double radius) {
  const Group& group = scene.groups[g];
  const Material& material = scene.materials[group.material];
  const Lattice lattice = lattice_of(group.packing);
  return material.solid && lattice.neighbours > 0
             ? sphere_mass(*material.solid, lattice)
             : material.density * volume_of_body(scene, g, k, radius);
}

/// Calls `place` with every body of group `g`; those that keep clear are where `is_free`.
/// Masses are those before they are scaled to the group's total. Collective, where `comm` is one.
void place_group(const Case& scene, std::size_t g, const Comm& comm, const IsFree& is_free,
                 const Place& place) {
  const Group& group = scene.groups[g];
  BodyId k = 0;
  group.packing.type->place(
      {.volume = group.volume,
       .packing = group.packing,
       .seed = stream_of(scene, g),
       .place = group.place,
       .period = scene.period,
       .comm = comm,
       .is_free = is_free,
       .put = [&](const PackedSphere& sphere) {
         place(sphere, sphere.mass ? *sphere.mass : mass_of_body(scene, g, k, sphere.radius));
         ++k;
       }});
}

/// Half widths of the box that holds all spheres of a group: those of lattices may stand out.
Vec3 reach(const Group& group) {
  double largest = group.packing.radius;
  for (const StoredBody& body : group.packing.stored) largest = std::max(largest, body.radius);
  return half_widths_in_world(group.volume) + Vec3::Constant(largest);
}

bool may_touch(const Group& a, const Group& b) {
  const Vec3 apart = (a.volume.center - b.volume.center).cwiseAbs();
  return (apart.array() <= (reach(a) + reach(b)).array()).all();
}

/// Whether bodies of an earlier run have the same images here as there.
bool repeats_as_stored(const Group& group, const Period& period) {
  if (group.packing.stored.empty()) return false;
  const Mat3 turn = group.volume.axes * turn_by(group.packing.rotation);
  const auto as_there = [&](int k) {
    return period.size[k] == 0 || period.size[k] == group.packing.stored_period[k];
  };
  return turn == Mat3::Identity() && as_there(0) && as_there(1) && as_there(2);
}

/// The bodies of a group that others must keep clear of; so must its own of their images.
struct Placed {
  std::size_t group;
  BodyId first;
  bool as_there;            ///< its own may overlap as they did in the run that they are of
  Eigen::AlignedBox3d box;  ///< m, that holds all of its spheres; far less than some volumes
  SphereSet spheres;        ///< around the bodies
  // Where bodies have shapes: the spheres that they are made of, and whose each is.
  SphereSet parts;
  std::vector<std::int64_t> body_of_part;

  Placed(const Group& of, const Period& period, std::size_t g, BodyId id, std::int64_t count)
      : group(g),
        first(id),
        as_there(repeats_as_stored(of, period)),
        spheres(of.volume.center, reach(of), count),
        parts(spheres) {}
  /// Of the spheres that a program adds, in `box`.
  Placed(const Eigen::AlignedBox3d& within, std::size_t g, BodyId id, std::int64_t count)
      : group(g),
        first(id),
        as_there(false),
        spheres(within.center(), within.sizes() / 2, count),
        parts(spheres) {}

  void add(const Vec3& center, double radius) {
    box.extend(center - Vec3::Constant(radius)).extend(center + Vec3::Constant(radius));
    spheres.add(center, radius);
    ++bodies_;
  }
  /// Of the body that was added last.
  void add_part(const ShapeSphere& part) {
    parts.add(part.at, part.radius);
    body_of_part.push_back(bodies_ - 1);
  }

 private:
  std::int64_t bodies_ = 0;
};

/// An overlap of a sphere, of group `g`, and of its images with `others` of `earlier`.
struct Overlap : SphereSet::Overlap {
  bool of_image;
};
std::optional<Overlap> find_overlap(const Period& period, const Placed& earlier,
                                    const SphereSet& others, std::size_t g, const Vec3& center,
                                    double radius, double allowed) {
  std::optional<Overlap> found;
  const bool own = earlier.group == g;  // groups keep clear of themselves, but for their images
  if (earlier.box.isEmpty() || (own && earlier.as_there)) return found;
  const Vec3 half = earlier.box.sizes() / 2 + Vec3::Constant(radius);
  for_each_image(period, center, earlier.box.center(), half, [&](const Vec3& image, bool itself) {
    if (found || (own && itself)) return;
    if (const auto hit = others.find_overlap(image, radius, allowed)) found = {*hit, !itself};
  });
  return found;
}

std::string words(const Vec3& v) {
  return fmt::format("({:.6g}, {:.6g}, {:.6g}) m", v.x(), v.y(), v.z());
}

/// How the axes of a body lie, which is the `k`-th of group `g`: a single one as the case says,
/// others at random; the same on any number of ranks.
Quaternion orientation_of(const Case& scene, std::size_t g, BodyId k) {
  const Packing& packing = scene.groups[g].packing;
  const std::int32_t shape = shape_of_body(scene, g, k);
  if (shape == 0) return Quaternion::Identity();
  const std::uint64_t stream = mix(stream_of(scene, g) ^ 0x5455524e);  // another than of places
  const Vec3 turn = packing.type == &single_packing
                        ? packing.rotation
                        : random_rotation(mix(stream + static_cast<std::uint64_t>(k)));
  const Quaternion turned(turn_by(turn));
  return (turned * scene.shapes[shape].as_listed).normalized();
}

/// m: the spheres that the `k`-th body of group `g` is made of, itself where it has no shape.
std::vector<ShapeSphere> parts_of(const Case& scene, std::size_t g, BodyId k, const Vec3& center,
                                  double radius) {
  const std::int32_t shape = g < scene.groups.size() ? shape_of_body(scene, g, k) : 0;
  if (shape == 0) return {{center, radius}};
  const Quaternion turn = orientation_of(scene, g, k);
  std::vector<ShapeSphere> parts = scene.shapes[shape].spheres;
  for (ShapeSphere& part : parts) part = placed_sphere(part, center, radius, turn);
  return parts;
}

/// Throws unless `sphere`, body `id` of group `g`, which `place` asks for, is clear of walls and of
/// `placed`: the spheres of its shape are, of those of others.
void check_clear(const Case& scene, const std::string& place, std::size_t g,
                 const std::vector<Placed>& placed, BodyId id, const PackedSphere& sphere,
                 BodyId place_in_group = 0) {
  const Vec3& center = sphere.center;
  const double radius = sphere.radius;
  const Walls walls = scene.walls();
  // Some of the sphere around a shape is empty.
  const std::vector<ShapeSphere> parts = parts_of(scene, g, place_in_group, center, radius);
  for (std::size_t w = 0; w < walls.size(); ++w) {
    double gap = infinity;
    for (const ShapeSphere& part : parts)
      gap = std::min(gap, face_of(walls, w, part.at).height - part.radius);
    require(gap >= -scene.allowed_overlap * radius,
            "{}: body {} at {} lies {:.3g} m deep in the wall {}; allowed_overlap = {} of its "
            "radius, {} m",
            place, id, words(center), -gap, walls.name(w), scene.allowed_overlap, radius);
  }
  const bool shapes = !scene.shapes.empty();
  for (const Placed& earlier : placed) {
    // Spheres of shapes meet only where those around them do.
    if (!find_overlap(scene.period, earlier, earlier.spheres, g, center, radius,
                      shapes ? 0 : scene.allowed_overlap))
      continue;
    for (const ShapeSphere& part : parts) {
      const auto hit = find_overlap(scene.period, earlier, shapes ? earlier.parts : earlier.spheres,
                                    g, part.at, part.radius, scene.allowed_overlap);
      if (!hit) continue;
      throw Error(fmt::format(
          "{}: body {} at {} overlaps {}body {} of {} at {} by {:.3g} m; allowed_overlap = {} "
          "of the smaller radius, {} m",
          place, id, words(part.at), hit->of_image ? "an image of " : "",
          earlier.first + (shapes ? earlier.body_of_part[hit->sphere] : hit->sphere),
          earlier.group < scene.groups.size() ? "groups." + scene.groups[earlier.group].name
                                              : "the program",
          words(hit->center), hit->depth, scene.allowed_overlap,
          std::min(part.radius, hit->radius)));
    }
  }
}

/// Gives the bodies of group `g` that this rank owns, from row `begin` on, their share of its
/// random velocities; the group's ids begin at `first`. Collective.
void add_thermal_velocities(const Comm& comm, const Case& scene, std::size_t g, Index begin,
                            BodyId first, Bodies& bodies) {
  const Group& group = scene.groups[g];
  std::vector<BodyId> number;
  for (Index b = begin; b < bodies.size(); ++b) number.push_back(bodies.id[b] - first);
  const std::vector<Vec3> velocity =
      thermal_velocities(comm, std::span(bodies.mass).subspan(begin), number, group.thermal->rms,
                         mix(mix(group.thermal->seed) + g));
  for (std::size_t k = 0; k < velocity.size(); ++k) bodies.velocity[begin + k] += velocity[k];
}

/// Doubles tell a place to some 1e-16 of its distance from the origin, and contacts are about small
/// parts of a radius (m).
void check_resolved(const std::string& place, double farthest, double radius) {
  constexpr double told = 1e-4;  // of a radius: what resting spheres may overlap by
  const double off = std::numeric_limits<double>::epsilon() * farthest;
  require(off <= told * radius,
          "{}: bodies of {:.3g} m radius lie up to {:.3g} m from the origin, where doubles "
          "resolve {:.1g} m: move the scene to the origin",
          place, radius, farthest, off);
}

/// m, no coordinate of its bodies is larger.
double farthest(const Group& group) {
  const Volume& volume = group.volume;
  if (group.packing.stored.empty())
    return (volume.center.cwiseAbs() + half_widths_in_world(volume)).maxCoeff();
  double most = 0;
  for (const StoredBody& body : group.packing.stored) most = std::max(most, body.position.norm());
  return volume.center.cwiseAbs().maxCoeff() + most;
}

}  // namespace

std::vector<GroupContent> measure_groups(const Case& scene) {
  std::vector<GroupContent> contents;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    require(group.volume.shape != Shape::mesh || group.volume.mesh, "{}: '{}' was not read",
            group.place, group.volume.file);
    if (group.packing.radius > 0)  // there packings would not end
      check_resolved(group.place, group.volume.center.cwiseAbs().maxCoeff(), group.packing.radius);
    GroupContent content;
    const auto count = [&](double radius, double mass, bool fixed) {
      content.volume += volume_of_body(scene, g, content.count, radius);
      content.add(radius, mass, !fixed);
    };
    if (const auto radii_of = group.packing.type->radii) {
      const Radii radii = radii_of(group.packing, stream_of(scene, g));
      for (std::int64_t k = 0; k < radii.count; ++k)
        count(radii[k], mass_of_body(scene, g, k, radii[k]), false);
    } else {
      place_group(scene, g, {}, {}, [&](const PackedSphere& sphere, double mass) {
        count(sphere.radius, mass, sphere.fixed);
      });
    }
    require(content.count > 0, "{}: its volume holds no sphere{}", group.place,
            group.packing.file.empty() ? fmt::format(" of radius {} m", group.packing.radius)
                                       : fmt::format(" of '{}'", group.packing.file));
    check_resolved(group.place, farthest(group), content.smallest);
    contents.push_back(content);
  }
  return contents;
}

std::vector<GroupContent> measure_bodies(const Comm& comm, const Case& scene,
                                         const Bodies& bodies) {
  std::vector<GroupContent> contents(scene.groups.size());
  for (Index b = 0; b < bodies.owned; ++b) {
    if (bodies.group[b] < 0 || bodies.group[b] >= std::ssize(contents)) continue;
    contents[bodies.group[b]].add(bodies.radius[b], bodies.mass[b], std::isfinite(bodies.mass[b]));
  }
  std::vector<double> sums, most;
  for (const GroupContent& content : contents) {
    sums.insert(sums.end(), {static_cast<double>(content.count),
                             static_cast<double>(content.movable), content.mass});
    most.insert(most.end(), {-content.smallest, content.largest, -content.lightest});
  }
  comm.sum(sums);
  comm.max(most);
  for (std::size_t g = 0; g < contents.size(); ++g) {
    contents[g].count = std::llround(sums[3 * g]);
    contents[g].movable = std::llround(sums[3 * g + 1]);
    contents[g].mass = sums[3 * g + 2];
    contents[g].smallest = -most[3 * g];
    contents[g].largest = most[3 * g + 1];
    contents[g].lightest = -most[3 * g + 2];
  }
  return contents;
}

FieldSet fields_of(const Case& scene) {
  const auto turns = [](const auto& bodies) { return !bodies.spin.isZero(0); };
  // Files need not be there any more where a run goes on: what they hold is not asked.
  const auto may_turn = [](const Group& group) {
    return !group.packing.file.empty() && group.packing.stored_motion == StoredMotion::kept;
  };
  FieldSet fields;
  if (std::ranges::any_of(scene.groups, turns) || std::ranges::any_of(scene.spheres, turns) ||
      std::ranges::any_of(scene.groups, may_turn))
    fields |= {Field::angular_velocity};
  if (!scene.motions.empty()) fields |= {Field::anchor};
  if (scene.has_gravity()) fields |= {Field::acceleration};
  if (scene.has_near_clumps())
    fields |= {Field::angular_acceleration, Field::angular_velocity, Field::orientation};
  for (const Phase& phase : scene.phases) fields |= phase.engine->fields(scene, phase.settings);
  return fields;
}

World make_world(const Comm& comm, const Case& scene) {
  World world;
  static_cast<Surroundings&>(world) = scene;
  world.comm = comm;
  world.reactions.of_walls.resize(scene.walls().size());
  world.reactions.of_groups.resize(group_of_spheres(scene) + 1);
  return world;
}

Bodies make_bodies(const Case& scene, const Comm& comm) {
  const std::vector<GroupContent> contents = measure_groups(scene);
  std::int64_t all = 0;
  for (const GroupContent& content : contents) all += content.count;
  all += std::ssize(scene.spheres);
  require(all > 0, "{}: no bodies", scene.file);
  for (std::size_t g = 0; g < contents.size(); ++g)
    for (int k = 0; k < 3; ++k)  // packings would place so many images of each body
      require(scene.period.size[k] == 0 || scene.period.size[k] > 2 * contents[g].largest,
              "{}: periodic.size = {:g} m along {} is not more than the diameter of a body, {:g} m",
              scene.groups[g].place, scene.period.size[k], "xyz"[k], 2 * contents[g].largest);
  require(all >= comm.size, "{}: {} bodies on {} ranks: run it on at most {}", scene.file, all,
          comm.size, all);
  const BodyId first_owned = all * comm.rank / comm.size;
  const BodyId end_owned = all * (comm.rank + 1) / comm.size;

  Bodies bodies;
  bodies.fields = fields_of(scene);
  bodies.owned = static_cast<Index>(end_owned - first_owned);
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(bodies.owned); });

  const Walls walls = scene.walls();
  std::vector<Placed> placed;
  BodyId id = 0;
  for (std::size_t g = 0; g < scene.groups.size(); ++g) {
    const Group& group = scene.groups[g];
    const double factor = contents[g].mass_factor(group);
    const BodyId first = id;
    const Index first_row = bodies.size();
    const bool others_repeat =
        scene.period.any() && (scene.groups.size() > 1 || !group.packing.type->keeps_clear);
    const bool keeps_spheres =
        others_repeat || !scene.spheres.empty() ||
        std::any_of(scene.groups.begin() + g + 1, scene.groups.end(),
                    [&](const Group& later) { return may_touch(group, later); });
    if (keeps_spheres) placed.emplace_back(group, scene.period, g, first, contents[g].count);

    const auto is_free = [&](const Vec3& center, double radius) {
      for (std::size_t w = 0; w < walls.size(); ++w)
        if (face_of(walls, w, center).height < radius) return false;
      for (const Placed& earlier : placed)
        if (earlier.group != g &&
            find_overlap(scene.period, earlier, earlier.spheres, g, center, radius, 0))
          return false;
      return true;
    };
    const auto place = [&](const PackedSphere& sphere, double nominal) {
      const Vec3& center = sphere.center;
      const bool held = group.held() || sphere.fixed;
      const double mass = held ? infinity : factor * nominal;
      if (!group.packing.type->keeps_clear)
        check_clear(scene, group.place, g, placed, id, sphere, id - first);
      if (keeps_spheres) {
        placed.back().add(center, sphere.radius);
        if (!scene.shapes.empty())
          for (const ShapeSphere& part : parts_of(scene, g, id - first, center, sphere.radius))
            placed.back().add_part(part);
      }
      if (id >= first_owned && id < end_owned) {
        const Index row = append_row(bodies);
        bodies.id[row] = id;
        bodies.group[row] = static_cast<std::int32_t>(g);
        bodies.material[row] = group.material;
        bodies.radius[row] = sphere.radius;
        bodies.mass[row] = mass;
        bodies.position[row] = center;
        if (bodies.has(Field::anchor)) bodies.anchor[row] = center;
        bodies.velocity[row] = group.velocity + group.spin.cross(center - group.volume.center);
        if (!held) bodies.velocity[row] += sphere.velocity;
        if (bodies.has(Field::shape)) {
          bodies.shape[row] = shape_of_body(scene, g, id - first);
          bodies.orientation[row] = orientation_of(scene, g, id - first);
        }
        if (bodies.has(Field::angular_velocity))
          bodies.angular_velocity[row] = held ? group.spin : Vec3(group.spin + sphere.spin);
      }
      ++id;
    };
    place_group(scene, g, comm, is_free, place);
    if (group.thermal) {
      require(contents[g].movable > 1,
              "{}.thermal_velocity: without a drift one body that moves has none", group.place);
      add_thermal_velocities(comm, scene, g, first_row, first, bodies);
    }
  }
  Eigen::AlignedBox3d of_spheres;
  for (const SceneSphere& sphere : scene.spheres) of_spheres.extend(sphere.position);
  const auto group_of_added = static_cast<std::size_t>(group_of_spheres(scene));
  if (!scene.spheres.empty())
    placed.emplace_back(of_spheres, group_of_added, id, std::ssize(scene.spheres));
  for (std::size_t k = 0; k < scene.spheres.size(); ++k) {
    const SceneSphere& sphere = scene.spheres[k];
    check_resolved(scene.file, sphere.position.cwiseAbs().maxCoeff(), sphere.radius);
    // No group's number: these do not keep clear of each other by themselves.
    check_clear(scene, fmt::format("{}: sphere {}", scene.file, k), group_of_added + 1, placed, id,
                {.center = sphere.position, .radius = sphere.radius});
    placed.back().add(sphere.position, sphere.radius);
    if (!scene.shapes.empty()) placed.back().add_part({sphere.position, sphere.radius});
    if (id >= first_owned && id < end_owned) {
      const Index row = append_row(bodies);
      bodies.id[row] = id;
      bodies.group[row] = group_of_spheres(scene);
      bodies.material[row] = find_material(scene.materials, sphere.material, scene.file);
      bodies.radius[row] = sphere.radius;
      bodies.mass[row] = sphere.mass;
      bodies.position[row] = sphere.position;
      bodies.velocity[row] = sphere.velocity;
      if (bodies.has(Field::angular_velocity)) bodies.angular_velocity[row] = sphere.spin;
    }
    ++id;
  }
  return bodies;
}

}  // namespace spall
