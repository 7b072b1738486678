// Pairs are found for several steps at once: a body's reach covers this step and some more.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/neighbours.hpp"

#include <algorithm>
#include <array>

namespace spall {
namespace {

constexpr double steps_ahead = 8;  // for which a moving body's reach is meant to last
constexpr double least_skin = 0.02, most_skin = 0.3;  // of the radius

/// What a body needs this step beyond its motion since the pairs were found: see `find_contacts`.
double needed(const Bodies& bodies, Index b, const Vec3& drift, double h, double cohesion_range) {
  return h * (bodies.velocity[b] - drift).norm() +
         std::max(near_contact * bodies.radius[b], cohesion_range) / 2;
}

/// m/s: the mean velocity of those bodies that are not far from the mean of all, as is a planet
/// that a pile passes, or an impactor. Collective.
Vec3 common_velocity(const Comm& comm, const Bodies& bodies) {
  const auto mean = [&](auto&& counts) {
    std::array<double, 4> sums{};  // velocities, bodies
    for (Index b = 0; b < bodies.owned; ++b)
      if (counts(bodies.velocity[b])) {
        for (int k = 0; k < 3; ++k) sums[k] += bodies.velocity[b][k];
        ++sums[3];
      }
    comm.sum(sums);
    return Vec3(Vec3(sums[0], sums[1], sums[2]) / std::max(sums[3], 1.0));
  };
  const Vec3 all = mean([](const Vec3&) { return true; });
  std::array<double, 2> sums{};  // deviations, bodies
  for (Index b = 0; b < bodies.owned; ++b) sums[0] += (bodies.velocity[b] - all).norm();
  sums[1] = static_cast<double>(bodies.owned);
  comm.sum(sums);
  const double usual = sums[0] / sums[1];
  return mean([&](const Vec3& v) { return (v - all).norm() <= 2 * usual; });
}

bool still_valid(const Comm& comm, const Bodies& bodies, double h, double cohesion_range,
                 const Neighbours& neighbours) {
  bool left = !neighbours.valid;
  for (Index b = 0; b < bodies.owned && !left; ++b)
    left = (bodies.position[b] - neighbours.found_at[b] - neighbours.drifted).norm() +
               needed(bodies, b, neighbours.drift, h, cohesion_range) >
           neighbours.reach[b];
  return !comm.any(left);
}

/// m: how far each owned body may come until the next search. A small fast body may have a wide
/// skin: it meets few others all the same. Collective.
std::vector<double> reaches(const Comm& comm, const Bodies& bodies, const Vec3& drift, double h,
                            double cohesion_range) {
  std::array<double, 2> sums{static_cast<double>(bodies.owned), 0};
  for (Index b = 0; b < bodies.owned; ++b) sums[1] += bodies.radius[b];
  comm.sum(sums);
  const double mean_radius = sums[1] / sums[0];
  std::vector<double> reach(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b) {
    const double motion = h * (bodies.velocity[b] - drift).norm();
    reach[b] = needed(bodies, b, drift, h, cohesion_range) +
               std::clamp(steps_ahead * motion, least_skin * bodies.radius[b],
                          most_skin * std::max(bodies.radius[b], mean_radius));
  }
  return reach;
}

}  // namespace

SharedContacts remember(const Bodies& bodies, const Neighbours& neighbours, bool once) {
  // Before the first search after a restart there are no pairs.
  if (neighbours.carried->size() > 0) return neighbours.carried;
  return remember(bodies, neighbours.pairs, once);
}

std::vector<double> work_of(const Bodies& bodies, const Pairs& pairs) {
  std::vector<double> work(bodies.owned, 1.0);
  for (Index p = 0; p < pairs.size(); ++p)
    for (Index b : {pairs.i[p], pairs.j[p]})
      if (b != ground && b < bodies.owned) work[b] += 0.5;
  return work;
}

void update_neighbours(const Comm& comm, Bodies& bodies, const std::vector<Plane>& planes, double h,
                       double cohesion_range, Neighbours& neighbours) {
  if (still_valid(comm, bodies, h, cohesion_range, neighbours)) {
    refresh_ghosts(neighbours.ghosts, bodies);
    neighbours.drifted += h * neighbours.drift;
    return;
  }
  const auto keep = [&](bool cut) {
    SharedContacts memory = remember(bodies, neighbours, cut);
    neighbours.carried = {};
    return memory;
  };
  const auto find = [&](const ContactMemory& memory) {
    // Pairs do not change when all bodies move alike; but planes stay.
    neighbours.drift = planes.empty() ? common_velocity(comm, bodies) : Vec3(Vec3::Zero());
    neighbours.drifted = h * neighbours.drift;
    neighbours.reach = reaches(comm, bodies, neighbours.drift, h, cohesion_range);
    find_ghosts(comm, bodies, {}, neighbours.reach, neighbours);
    neighbours.pairs = find_pairs(bodies, neighbours.reach, planes);
    recall(bodies, memory, neighbours.pairs);
    neighbours.valid = true;
  };
  search_anew(
      comm, bodies, neighbours, [&] { return work_of(bodies, neighbours.pairs); }, keep, find);
}

}  // namespace spall
