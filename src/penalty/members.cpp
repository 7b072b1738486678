// Members lie in the order of their bodies, and of the spheres of a shape.
// SPDX-License-Identifier: BSD-3-Clause
#include "penalty/members.hpp"

#include <algorithm>

namespace spall {
namespace {

/// Calls `f(body, sphere)` for every sphere of every owned body.
template <class F>
void for_each_member(const World& world, F&& f) {
  for (Index b = 0; b < world.bodies.owned; ++b)
    for (const ShapeSphere& sphere : shape_of(world.shapes, world.bodies, b).spheres) f(b, sphere);
}

}  // namespace

BodyId members_a_body(const BodyShapes& shapes) {
  std::size_t most = 1;
  for (const BodyShape& shape : shapes) most = std::max(most, shape.spheres.size());
  return static_cast<BodyId>(most);
}

Members members_of(const World& world) {
  const Bodies& bodies = world.bodies;
  const BodyId each = members_a_body(world.shapes);
  Members members;
  Bodies& rows = members.bodies;
  for_each_member(world, [&](Index b, const ShapeSphere&) { members.whole.push_back(b); });
  rows.fields = {Field::angular_velocity};
  resize(rows, static_cast<Index>(members.whole.size()));
  rows.owned = rows.size();
  Index row = 0, before = -1;
  BodyId place = 0;
  for_each_member(world, [&](Index b, const ShapeSphere& sphere) {
    place = b == before ? place + 1 : 0;
    before = b;
    rows.id[row] = bodies.id[b] * each + place;
    rows.group[row] = bodies.group[b];
    rows.material[row] = bodies.material[b];
    rows.radius[row] = bodies.radius[b] * sphere.radius;
    rows.mass[row] = bodies.mass[b];
    ++row;
  });
  members.arm.resize(rows.owned);
  follow_bodies(world, members);
  return members;
}

void follow_bodies(const World& world, Members& members) {
  const Bodies& bodies = world.bodies;
  Bodies& rows = members.bodies;
  std::size_t row = 0;
  for (Index b = 0; b < bodies.owned; ++b) {
    const Mat3 turn = bodies.radius[b] * bodies.orientation[b].toRotationMatrix();
    const Vec3& spin = bodies.angular_velocity[b];
    for (const ShapeSphere& sphere : shape_of(world.shapes, bodies, b).spheres) {
      const Vec3 arm = turn * sphere.at;
      members.arm[row] = arm;
      rows.position[row] = bodies.position[b] + arm;
      if (!members.shift.empty()) rows.position[row] += members.shift[row];
      rows.velocity[row] = bodies.velocity[b] + spin.cross(arm);
      rows.angular_velocity[row++] = spin;
    }
  }
}

void note_shifts(const World& world, Members& members) {
  members.shift.clear();
  if (!world.period.any()) return;
  for (std::size_t row = 0; row < members.whole.size(); ++row)
    members.shift.push_back(members.bodies.position[row] -
                            (world.bodies.position[members.whole[row]] + members.arm[row]));
}

SharedContacts by_members(const SharedContacts& contacts, BodyId members) {
  if (members == 1) return contacts;
  ContactMemory memory = *contacts;
  for (std::size_t m = 0; m < memory.size(); ++m) {
    const auto [of_i, of_j] = memory.spheres_of(m);
    memory.i[m] = memory.i[m] * members + of_i;
    if (memory.j[m] >= 0) memory.j[m] = memory.j[m] * members + of_j;
  }
  memory.spheres.clear();
  return memory;
}

namespace {

/// Back from what `by_members` gives.
ContactMemory by_bodies(ContactMemory memory, BodyId members) {
  if (members == 1) return memory;
  for (std::size_t m = 0; m < memory.size(); ++m) {
    BodyId &i = memory.i[m], &j = memory.j[m];
    memory.spheres.push_back({static_cast<std::int32_t>(i % members),
                              j < 0 ? 0 : static_cast<std::int32_t>(j % members)});
    i /= members;
    if (j >= 0) j /= members;
  }
  return memory;
}

}  // namespace

SharedContacts remember(const World& world, const Members& members, const TouchPairs& touch,
                        bool once) {
  // Before the first search after a restart there are no pairs.
  if (touch.carried->size() > 0) return touch.carried;
  return by_bodies(remember(meeting(world, members), touch, once), members_a_body(world.shapes));
}

void add_up_loads(const World& world, std::vector<ForceRow>& rows, Members& members) {
  members.loads.assign(world.bodies.owned, ForceRow{});
  for (std::size_t row = 0; row < members.whole.size(); ++row) {
    ForceRow& load = members.loads[members.whole[row]];
    const RowHalf& force = rows[row].force;
    const Vec3 about = members.arm[row].cross(Vec3(force[0], force[1], force[2]));
    load.force += force;
    load.torque += rows[row].torque + RowHalf{about.x(), about.y(), about.z(), 0};
  }
  std::fill(rows.begin(), rows.end(), ForceRow{});
}

std::vector<double> work_of_bodies(const World& world, const Members& members,
                                   const TouchPairs& touch) {
  if (world.shapes.empty()) return work_of(world.bodies, touch);
  std::vector<double> work(world.bodies.owned, 0.0);
  const std::vector<double> of_rows = work_of(members.bodies, touch);
  for (std::size_t row = 0; row < members.whole.size(); ++row)
    work[members.whole[row]] += of_rows[row];
  return work;
}

void search_touch_pairs(World& world, const TouchRange& range, Members& members,
                        TouchPairs& touch) {
  const BodyId each = members_a_body(world.shapes);
  const auto keep = [&](bool cut) {
    SharedContacts memory = remember(world, members, touch, cut);
    // What comes needs the memory.
    touch.carried = {};
    touch.springs.clear();
    touch.windows.clear();
    return memory;
  };
  search_anew(
      world.comm, world.bodies, touch, [&] { return work_of_bodies(world, members, touch); }, keep,
      [&](const SharedContacts& memory) {
        if (!world.shapes.empty()) {
          members = members_of(world);
          members.found_at = {world.bodies.position.begin(),
                              world.bodies.position.begin() + world.bodies.owned};
        }
        find_touch_pairs(world.comm, meeting(world, members), world.walls(), world.period, range,
                         by_members(memory, each), touch);
        note_shifts(world, members);
      });
}

double gap_between(const BodyShapes& shapes, const Bodies& bodies, Index i, Index j) {
  if (shapes.empty())
    return (bodies.position[j] - bodies.position[i]).norm() - bodies.radius[i] - bodies.radius[j];
  const auto placed = [&](Index b, const ShapeSphere& sphere) {
    return placed_sphere(sphere, bodies.position[b], bodies.radius[b], bodies.orientation[b]);
  };
  double least = infinity;
  for (const ShapeSphere& one : shape_of(shapes, bodies, i).spheres) {
    const ShapeSphere a = placed(i, one);
    for (const ShapeSphere& other : shape_of(shapes, bodies, j).spheres) {
      const ShapeSphere b = placed(j, other);
      least = std::min(least, (b.at - a.at).norm() - a.radius - b.radius);
    }
  }
  return least;
}

}  // namespace spall
