// What would make a verdict mean nothing is refused here: no plate, no damage, nothing that flies.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/shields.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>

#include "scene/packing.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {

void read_shield(Section& in, Shield& shield) {
  in.need("wall", "one of groups, a plate: held, detached spall or perforated?", shield.wall_name);
  in.take("rear", "way through the wall; left out: that of what flies at it", shield.rear,
          any(dimension::number));
  shield.place = in.place();
}

int axis_through(const Volume& volume) {
  if (volume.shape != Shape::box && volume.shape != Shape::cylinder) return -1;
  const int thin = thin_axis(volume);
  const auto is_wider = [&](int k) { return volume.extents[k] > volume.extents[thin]; };
  return is_wider((thin + 1) % 3) && is_wider((thin + 2) % 3) ? thin : -1;
}

std::string section_end(const std::string& group) {
  std::string end = "_" + group;
  for (char& c : end)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  return end;
}

std::string results_of(const Shield& shield) {
  return "shield" + section_end(shield.wall_name);
}

double rim_of(double half_width, double spacing) {
  constexpr double share = 0.1, spacings = 2;
  return std::max(share * half_width, spacings * spacing);
}

double miss_of_line(const Volume& plate, const Vec3& from, const Vec3& velocity, double spacing) {
  const int thin = axis_through(plate);
  const Vec3 normal = plate.axes.col(thin);
  const double flight = normal.dot(plate.center - from) / normal.dot(velocity);  // s
  const Vec3 meets = plate.axes.transpose() * (from + flight * velocity - plate.center);
  std::array<double, 2> off, edge;
  for (int k = 0; k < 2; ++k) {
    const int side = (thin + 1 + k) % 3;
    const double half = plate.extents[side] / 2;
    off[k] = std::abs(meets[side]);
    edge[k] = spacing > 0 ? half - rim_of(half, spacing) : half;
  }
  if (plate.shape == Shape::cylinder) return std::hypot(off[0], off[1]) - edge[0];
  return std::max(off[0] - edge[0], off[1] - edge[1]);
}

double width_across(const Volume& volume, const Vec3& flight) {
  const Vec3 half = half_widths(volume);
  if (half.maxCoeff() == half.minCoeff()) return 2 * half[0];
  double widest = 0;
  for (int k = 0; k < 3; ++k)
    widest = std::max(widest, 2 * half[k] * volume.axes.col(k).cross(flight).norm());
  return widest;
}

double speed_of_flight(const Group& wall, const Group& other, const Vec3& normal) {
  const Vec3 velocity = other.velocity - wall.velocity;
  const double speed = speed_across(velocity, normal);
  const double ahead = normal.dot(wall.volume.center - other.volume.center);
  if (other.held() || speed <= 0 || ahead <= 0) return 0;
  const double radius = half_widths(other.volume).norm();
  return miss_of_line(wall.volume, other.volume.center, velocity) > radius ? 0 : speed;
}

double speed_from_either_side(const Group& wall, const Group& other, const Vec3& normal) {
  return std::max(speed_of_flight(wall, other, normal), speed_of_flight(wall, other, -normal));
}

namespace {

/// The way along `normal` of the groups that fly at the wall; 0 where they come from both sides.
double way_of_flight(const Case& scene, const Group& wall, const Vec3& normal,
                     const std::string& told) {
  bool up = false, down = false;
  for (const Group& group : scene.groups) {
    up |= speed_of_flight(wall, group, normal) > 0;
    down |= speed_of_flight(wall, group, -normal) > 0;
  }
  require(up || down,
          "{}: no group flies at it along {}: one with a mass and a velocity, whose line meets it, "
          "is wanted",
          told, words_of_direction(normal));
  return up == down ? 0 : up ? 1 : -1;
}

/// What flies at the rim would be told to have done nothing to the wall, and a wall that is
/// narrower than it would be swept away.
void check_rim(const Case& scene, const Group& wall, const Vec3& normal, const std::string& told) {
  const double spacing = lattice_of(wall.packing).distance;
  for (const Group& group : scene.groups) {
    if (speed_from_either_side(wall, group, normal) == 0) continue;
    const Vec3 flight = group.velocity - wall.velocity;
    const double beyond = miss_of_line(wall.volume, group.volume.center, flight, spacing) +
                          width_across(group.volume, flight.normalized()) / 2;
    require(beyond <= 0,
            "{}: groups.{} flies at its rim, or past it, {:.3g} m beyond what is judged: a wider "
            "wall is wanted",
            told, group.name, beyond);
  }
}

void find_wall(const Case& scene, Shield& shield) {
  const std::string& place = shield.place;
  const std::string told = fmt::format("{}.wall = \"{}\"", place, shield.wall_name);
  const auto found = std::ranges::find(scene.groups, shield.wall_name, &Group::name);
  require(found != scene.groups.end(), "{} is not one of [[groups]]", told);
  const Group& wall = *found;
  shield.wall = static_cast<int>(found - scene.groups.begin());
  const int thin = axis_through(wall.volume);
  require(thin >= 0,
          "{} is no plate: a box that is thinner along one axis, or a flat cylinder, is wanted",
          told);
  require(!wall.held(), "{} is {}: nothing can break it", told,
          wall.fixed ? "fixed" : "moved as prescribed");
  require(wall.spin.isZero(0), "{} spins: a wall is judged as it was laid, but for its way", told);
  require(!scene.period.any(), "{}: walls are not judged in a [periodic] box", told);
  require(scene.walls().size() == 0,
          "{}: [[planes]], [[boxes]] or [[cylinders]] may prop it up and stop what leaves it; make "
          "them groups",
          told);
  const Lattice lattice = lattice_of(wall.packing);
  require(wall.packing.type->lattice && lattice.neighbours > 0,
          "{}: its packing is no lattice, whose spacing tells how small a hole can be seen", told);
  // A rim of two spacings is not judged, and what is must be wider than the smallest hole.
  constexpr double fewest_spacings = 8;
  for (int k = 1; k <= 2; ++k) {
    const double width = wall.volume.extents[(thin + k) % 3];
    require(width >= fewest_spacings * lattice.distance,
            "{} is {:g} m wide; {:g} spacings of {:g} m are the least that can be judged", told,
            width, fewest_spacings, lattice.distance);
  }
  for (const Phase& phase : scene.phases) {
    require(!phase.impactor,
            "{}: the impactor of phases.{} is no group; make it one with a velocity", told,
            phase.name);
    require(!phase.remove_drift,
            "{}.remove_drift would move groups.{} from where [[shields]] judge it", phase.place,
            shield.wall_name);
  }
  for (const Phase& phase : scene.phases)
    require(phase.engine->breaks(phase.settings, wall.material),
            "{}: phases.{}.method = \"{}\" cannot break it; method = \"solid\" does where {} has a "
            "strength, and \"potential\" with bonds that break",
            told, phase.name, phase.engine->name, scene.materials[wall.material].name);
  const Vec3 normal = wall.volume.axes.col(thin);
  const double way = way_of_flight(scene, wall, normal, told);
  check_rim(scene, wall, normal, told);
  if (shield.rear.isZero(0)) {
    require(
        way != 0,
        "{}: groups fly at it from either side along {}: {}.rear tells the way through it, such "
        "as [0, 0, -1]",
        told, words_of_direction(normal), place);
    shield.rear = way * normal;
    return;
  }
  const double along = normal.dot(shield.rear.normalized());
  require(along * along > 0.5, "{}.rear does not lead through \"{}\", which is thin along {}",
          place, shield.wall_name, words_of_direction(normal));
  require(along * way >= 0,
          "{}.rear leads against what flies at \"{}\": its rear is where that would come out",
          place, shield.wall_name);
  shield.rear = along < 0 ? Vec3(-normal) : normal;
}

}  // namespace

void find_shield_walls(Case& scene) {
  for (auto shield = scene.shields.begin(); shield != scene.shields.end(); ++shield) {
    find_wall(scene, *shield);
    for (auto other = scene.shields.begin(); other != shield; ++other)
      require(results_of(*other) != results_of(*shield),
              "{}.wall = \"{}\": \"{}\" has the section [{}] of the results already", shield->place,
              shield->wall_name, other->wall_name, results_of(*shield));
  }
}

}  // namespace spall
