// Sweeps the impactor along its line to the first body in its way.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/impactor.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "spall/error.hpp"

namespace spall {
namespace {

/// A meeting of the impactor with a sphere of one body: `along` is the impactor's place on its
/// line, m.
struct Meeting {
  double along = infinity;
  BodyId id = -1;
  int sphere = 0;              ///< of the body's shape
  Vec3 center = Vec3::Zero();  ///< m, of that sphere
};

/// The first sphere of a body that a sphere of `radius` meets that comes along `direction` on the
/// line through `through`; of all ranks. Without any it lies infinitely far.
Meeting first_meeting(const Comm& comm, const Bodies& bodies, const BodyShapes& shapes,
                      const Vec3& through, const Vec3& direction, double radius) {
  Meeting own;
  const auto meet = [&](Index b, int sphere, const Vec3& center, double radius_of_it) {
    const Vec3 to = center - through;
    const double along = to.dot(direction);
    const double reach = radius + radius_of_it;
    const double aside2 = (to - along * direction).squaredNorm();
    if (aside2 >= reach * reach) return;
    const double at = along - std::sqrt(reach * reach - aside2);
    if (at < own.along || (at == own.along && bodies.id[b] < own.id))
      own = {at, bodies.id[b], sphere, center};
  };
  for (Index b = 0; b < bodies.owned; ++b) {
    if (shapes.empty() || shape_of(shapes, bodies, b).is_sphere()) {
      meet(b, 0, bodies.position[b], bodies.radius[b]);
      continue;
    }
    const auto& spheres = shape_of(shapes, bodies, b).spheres;
    for (int k = 0; k < std::ssize(spheres); ++k) {
      const auto [center, radius_of_it] =
          placed_sphere(spheres[k], bodies.position[b], bodies.radius[b], bodies.orientation[b]);
      meet(b, k, center, radius_of_it);
    }
  }
  Meeting first;
  first.along = comm.min(own.along);
  const bool may = own.along == first.along;
  first.id = static_cast<BodyId>(comm.min(may ? static_cast<double>(own.id) : infinity));
  const bool is = may && own.id == first.id;
  first.center = comm.sum(is ? own.center : Vec3(Vec3::Zero()));
  if (!shapes.empty()) first.sphere = static_cast<int>(comm.sum(is ? double(own.sphere) : 0.0));
  return first;
}

struct Target {
  Vec3 center, velocity;  ///< of mass, of the bodies that can move; the origin, at rest, without
};

Target measure_target(const Comm& comm, const Bodies& bodies) {
  double sums[7] = {};
  Eigen::Map<Vec3> position(sums + 1), momentum(sums + 4);
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!std::isfinite(bodies.mass[b])) continue;
    sums[0] += bodies.mass[b];
    position += bodies.mass[b] * bodies.position[b];
    momentum += bodies.mass[b] * bodies.velocity[b];
  }
  comm.sum(std::span<double>(sums));
  if (sums[0] == 0) return {Vec3::Zero(), Vec3::Zero()};
  return {position / sums[0], momentum / sums[0]};
}

}  // namespace

Aim aim_impactor(const Comm& comm, const Impactor& impactor, const Bodies& bodies,
                 const BodyShapes& shapes) {
  const Target target = measure_target(comm, bodies);
  const Vec3& direction = impactor.direction;
  Vec3 through = target.center + impactor.offset;
  Meeting met = first_meeting(comm, bodies, shapes, through, direction, impactor.radius);
  require(met.along < infinity,
          "{}: the impactor misses: no body within its radius, {} m, of its line of flight",
          impactor.place, impactor.radius);
  // Each shift brings the impactor to an earlier meeting, so this ends.
  Meeting before;
  while (impactor.aim == Aiming::head_on && (met.id != before.id || met.sphere != before.sphere)) {
    before = met;
    through = met.center;
    met = first_meeting(comm, bodies, shapes, through, direction, impactor.radius);
  }
  return {through + (met.along - impactor.distance) * direction,
          target.velocity + impactor.speed * direction, met.id};
}

bool would_hit(const Comm& comm, const Impactor& impactor, const Bodies& bodies,
               const BodyShapes& shapes) {
  const Vec3 through = measure_target(comm, bodies).center + impactor.offset;
  return first_meeting(comm, bodies, shapes, through, impactor.direction, impactor.radius).along <
         infinity;
}

Aim place_impactor(const Comm& comm, const Case& scene, const Impactor& impactor, Bodies& bodies) {
  const Aim aim = aim_impactor(comm, impactor, bodies, scene.shapes);
  const auto highest = std::ranges::max_element(bodies.id);
  const BodyId next = 1 + static_cast<BodyId>(comm.max(
                              highest == bodies.id.end() ? -1.0 : static_cast<double>(*highest)));
  if (std::ranges::find(bodies.id, aim.struck) == bodies.id.end()) return aim;
  const Index row = append_row(bodies);
  bodies.id[row] = next;
  bodies.group[row] = static_cast<std::int32_t>(scene.groups.size());
  bodies.material[row] = impactor.material;
  bodies.radius[row] = impactor.radius;
  bodies.mass[row] = impactor.mass;
  bodies.position[row] = aim.position;
  bodies.velocity[row] = aim.velocity;
  ++bodies.owned;
  return aim;
}

Aim add_impactor(const Comm& comm, const Case& scene, const Impactor& impactor, Bodies& bodies) {
  const Aim aim = place_impactor(comm, scene, impactor, bodies);
  const Walls walls = scene.walls();
  for (std::size_t w = 0; w < walls.size(); ++w) {
    const double gap = face_of(walls, w, aim.position).height - impactor.radius;
    require(gap >= 0,
            "{}: it begins {:.3g} m deep in the wall {}: another direction or distance is wanted",
            impactor.place, -gap, walls.name(w));
  }
  require(!scene.period.any() || scene.period.wrapped(aim.position) == aim.position,
          "{}: it begins at ({:.6g}, {:.6g}, {:.6g}) m, outside of [periodic], and images would "
          "stand in its way: a shorter distance is wanted",
          impactor.place, aim.position.x(), aim.position.y(), aim.position.z());
  return aim;
}

}  // namespace spall
