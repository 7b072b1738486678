// A frictionless problem around the overlaps; its impulses never enter the velocities.
// SPDX-License-Identifier: BSD-3-Clause
#include "rigid/overlap_correction.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "base/let_go.hpp"
#include "engine/free_turn.hpp"
#include "engine/prescribed.hpp"
#include "rigid/narrow_phase.hpp"
#include "solver/problem.hpp"
#include "solver/settings.hpp"

namespace spall {
namespace {

// Overlaps are taken apart from twice this part of the smaller radius on, and down to it: contacts
// that rest stay closed, where a correction to zero would leave gaps to fall through.
constexpr double tolerated_overlap = 1e-4;
constexpr double most_correction = 0.1;  // of the smaller radius, in a step
// Bodies so many contacts away from an overlap do not move for it: a push fades with the square of
// the distance, and what it closes is the next step's to open.
constexpr int rings = 6;

/// How all rows turn by their own angular momentum alone until the end of a step `h`; those of held
/// bodies turn as they do. Empty where all bodies are spheres.
std::vector<Turn> turns_at_end(const World& world, double h) {
  const Bodies& bodies = world.bodies;
  std::vector<Turn> turns;
  if (world.shapes.empty()) return turns;
  for (Index b = 0; b < bodies.size(); ++b) {
    const Turn now{bodies.orientation[b], bodies.angular_velocity[b]};
    if (bodies.shape[b] == 0 || is_held(bodies, b))
      turns.push_back({turned_by(h * now.angular_velocity, now.orientation), now.angular_velocity});
    else
      turns.push_back(turn_freely(shape_of(world.shapes, bodies, b).inertia, now, h));
  }
  return turns;
}

/// The `k`-th sphere of row `b` with its body at `center` and turned so; null where all are
/// spheres.
ShapeSphere sphere_of_row(const World& world, Index b, std::size_t k, const Vec3& center,
                          const Quaternion* turn) {
  const double radius = world.bodies.radius[b];
  if (!turn) return {center, radius};
  const BodyShape& shape = shape_of(world.shapes, world.bodies, b);
  return placed_sphere(shape.spheres[k], center, radius, *turn);
}

/// Per contact: how far (m) the bodies may come nearer until the overlap at the end of a step `h`
/// is the tolerated one.
std::vector<double> slack_at_end(const World& world, const Contacts& contacts,
                                 std::span<const Turn> turns, double h, DriftReport& report) {
  const Bodies& bodies = world.bodies;
  const auto sphere_at_end = [&](Index b, std::int32_t of) {
    return sphere_of_row(world, b, of, bodies.position[b] + h * bodies.velocity[b],
                         turns.empty() ? nullptr : &turns[b].orientation);
  };
  std::vector<double> slack(contacts.size());
  for (Index c = 0; c < contacts.size(); ++c) {
    const Index i = contacts.i[c], j = contacts.j[c];
    const auto [end_i, radius_i] = sphere_at_end(i, turns.empty() ? 0 : contacts.spheres[c].of_i);
    double gap;
    if (j == ground) {
      const Plane& plane = world.planes[contacts.plane[c]];
      gap = plane.normal.dot(end_i - plane.point) - radius_i;
    } else {
      const auto [end_j, radius_j] = sphere_at_end(j, turns.empty() ? 0 : contacts.spheres[c].of_j);
      gap = (end_j - end_i).norm() - radius_i - radius_j;
    }
    const double small = smaller_radius(bodies, contacts, c);
    report.overlap = std::max(report.overlap, -gap / small);
    slack[c] = std::max(gap + tolerated_overlap * small, -most_correction * small);
  }
  return slack;
}

/// Rows within `rings` contacts of one without slack: 1, others 0. Collective.
std::vector<double> rows_near_overlaps(const Ghosts& ghosts, const Contacts& contacts,
                                       const std::vector<double>& slack) {
  std::vector<double> near(static_cast<std::size_t>(ghosts.owned()) + ghosts.ghosts(), 0);
  const auto mark = [&](auto&& reached) {
    if (std::ranges::find(near, 0.0) != near.end()) {  // else all of this rank's rows are
      std::vector<double> next = near;
      for (Index c = 0; c < contacts.size(); ++c) {
        const Index i = contacts.i[c], j = contacts.j[c];
        if (!reached(c, i, j)) continue;
        next[i] = 1;
        if (j != ground) next[j] = 1;
      }
      near = std::move(next);
    }
    ghosts.gather(near.data(), 1);
  };
  mark([&](Index c, Index, Index) { return slack[c] < 0; });
  for (int ring = 0; ring < rings; ++ring)
    mark([&](Index, Index i, Index j) { return near[i] > 0 || (j != ground && near[j] > 0); });
  return near;
}

/// The bodies that move out of each other, in rows of their own: owned ones, then ghosts.
struct Correction {
  std::vector<Index> row;              ///< in the world
  std::vector<Index> contact;          ///< in the step's contacts
  std::vector<VelocityChange> change;  ///< displacement over h, a row each
  std::vector<Vec3> impulse;           ///< a contact each
};

Correction correct_overlaps(const World& world, const Ghosts& all, const Contacts& contacts,
                            std::span<const Turn> turns, double h, DriftReport& report) {
  Correction correction;
  std::vector<double> slack = slack_at_end(world, contacts, turns, h, report);
  if (!world.comm.any(report.overlap > 2 * tolerated_overlap)) return correction;

  // Rows near overlaps, numbered anew here and, for ghosts, where they are owned.
  const Bodies& bodies = world.bodies;
  auto near = rows_near_overlaps(all, contacts, slack);
  std::vector<std::array<double, 2>> place(near.size());  // rank and row there
  std::vector<Index> number(near.size(), -1);
  std::vector<Origin> origins;
  const auto take = [&](Index b) {
    number[b] = static_cast<Index>(correction.row.size());
    correction.row.push_back(b);
  };
  for (Index b = 0; b < all.owned(); ++b) {
    if (near[b] > 0) take(b);
    place[b] = {static_cast<double>(world.comm.rank), static_cast<double>(number[b])};
  }
  const auto owned = static_cast<Index>(correction.row.size());
  all.gather(reinterpret_cast<double*>(place.data()), 2);
  for (std::size_t b = all.owned(); b < near.size(); ++b)
    if (near[b] > 0) {
      take(static_cast<Index>(b));
      origins.push_back({static_cast<int>(place[b][0]), static_cast<Index>(place[b][1])});
    }
  const Ghosts ghosts(world.comm, owned, origins);
  let_go(near, place, origins);

  Index boundary = 0;
  std::vector<Index> i, j;
  std::vector<Vec3> normal, free_velocity;
  LeverArms all_levers = lever_arms(world, contacts);
  LeverArms levers;
  for (Index c = 0; c < contacts.size(); ++c)
    if (number[contacts.i[c]] >= 0 && (contacts.j[c] == ground || number[contacts.j[c]] >= 0))
      correction.contact.push_back(c);
  const auto room = [&](auto&... fields) { (fields.reserve(correction.contact.size()), ...); };
  room(i, j, normal, free_velocity);
  for (const Index c : correction.contact) {
    i.push_back(number[contacts.i[c]]);
    j.push_back(contacts.j[c] == ground ? ground : number[contacts.j[c]]);
    normal.push_back(contacts.normal[c]);
    free_velocity.push_back(slack[c] / h * contacts.normal[c]);
    if (!turns.empty()) {
      levers.arm_i.push_back(all_levers.arm_i[c]);
      levers.arm_j.push_back(all_levers.arm_j[c]);
    }
    if (c < contacts.boundary) boundary = static_cast<Index>(i.size());
  }
  std::vector<double> inverse_masses;
  for (Index b : correction.row) {
    inverse_masses.push_back(inverse_mass(bodies, b));
    if (!turns.empty()) levers.turning.push_back(all_levers.turning[b]);
  }
  let_go(slack, number, all_levers);
  std::vector<double> touching(i.size(), 1);
  correction.impulse.assign(i.size(), Vec3::Zero());
  const bool spheres = world.shapes.empty();  // as on ranks without bodies, too
  auto result = solve(
      {.dimension = spheres ? 1 : 3,
       .boundary = boundary,
       .inverse_mass = inverse_masses,
       .i = i,
       .j = j,
       .normal = normal,
       .kappa = touching,
       .arm_i = levers.arm_i,
       .arm_j = levers.arm_j,
       .turning = levers.turning,
       .free_velocity = free_velocity},
      ghosts,
      {.friction = FrictionModel::convex, .tolerance = 0.1, .max_iterations = 50, .prox = 0},
      correction.impulse, [&] { let_go(touching, free_velocity, levers.arm_i, levers.arm_j); });
  report.products = result.report.products;
  correction.change = std::move(result.change);
  return correction;
}

/// J, of cohesion in pair `p` of bodies that lie so: `sphere(b, k)` is the k-th of row b.
template <class SphereOf>
double bonds_of_pair(const World& world, const Pairs& pairs, Index p, const SphereOf& sphere) {
  const Bodies& bodies = world.bodies;
  const Index i = pairs.i[p], j = pairs.j[p];
  const ContactLaw& law = law_of(world.contact, bodies, world.planes, i, j, pairs.plane[p]);
  const auto count = [&](Index b) -> std::size_t {
    return world.shapes.empty() ? 1 : shape_of(world.shapes, bodies, b).spheres.size();
  };
  double energy = 0;
  for (std::size_t a = 0; law.cohesion > 0 && a < count(i); ++a) {
    const ShapeSphere one = sphere(i, a);
    if (j == ground) {
      const Plane& plane = world.planes[pairs.plane[p]];
      energy += energy_of_bond(law, plane.normal.dot(one.at - plane.point) - one.radius);
      continue;
    }
    for (std::size_t b = 0; b < count(j); ++b) {
      const ShapeSphere other = sphere(j, b);
      energy += energy_of_bond(law, (other.at - one.at).norm() - one.radius - other.radius);
    }
  }
  return energy;
}

/// J, by which the correction opens bonds, less what it closes; bodies lie where it has put them,
/// and without it would have been turned by `turns`.
double opened_bonds(const World& world, const Pairs& pairs, const Correction& correction,
                    std::span<const Turn> turns, double h) {
  if (correction.row.empty() || longest_range(world.contact) == 0) return 0;
  const Bodies& bodies = world.bodies;
  std::vector<Vec3> moved(bodies.size(), Vec3::Zero());
  for (std::size_t k = 0; k < correction.row.size(); ++k)
    moved[correction.row[k]] = h * Eigen::Map<const Vec3>(correction.change[k].linear);
  const auto is_elsewhere = [&](Index b) {
    return !moved[b].isZero(0) ||
           (!turns.empty() && turns[b].orientation.coeffs() != bodies.orientation[b].coeffs());
  };
  const auto sphere_now = [&](Index b, std::size_t k) {
    return sphere_of_row(world, b, k, bodies.position[b],
                         turns.empty() ? nullptr : &bodies.orientation[b]);
  };
  const auto sphere_without = [&](Index b, std::size_t k) {
    return sphere_of_row(world, b, k, bodies.position[b] - moved[b],
                         turns.empty() ? nullptr : &turns[b].orientation);
  };
  double energy = 0;
  for (Index p = 0; p < pairs.size(); ++p) {
    const Index i = pairs.i[p], j = pairs.j[p];
    if (i < bodies.owned && (is_elsewhere(i) || (j != ground && is_elsewhere(j))))
      energy += bonds_of_pair(world, pairs, p, sphere_now) -
                bonds_of_pair(world, pairs, p, sphere_without);
  }
  return energy;
}

/// Moving bodies apart by the correction P along n changes angular momentum by h P n x u, with u
/// their relative velocity: as they move out they must turn slower. The torque t = -h P n x u is
/// given back at the new positions, n' apart by d', as an impulse pair q = t x n' / d' and, for the
/// rest along n', in spins. Bodies without relative motion get nothing, however fast they part.
/// What held bodies receive completes the momenta of both.
void keep_angular_momentum(World& world, const Contacts& contacts, const Correction& correction,
                           double h) {
  if (correction.row.empty()) return;
  Bodies& bodies = world.bodies;
  const auto moves = [&](Index b) { return b < bodies.owned && std::isfinite(bodies.mass[b]); };
  double gained = 0;
  for (std::size_t k = 0; k < correction.row.size(); ++k)
    if (const Index b = correction.row[k]; moves(b))
      gained -= h * bodies.mass[b] *
                bodies.acceleration[b].dot(Eigen::Map<const Vec3>(correction.change[k].linear));

  std::vector<Vec3> impulse(bodies.owned, Vec3::Zero()), turn(bodies.owned, Vec3::Zero());
  for (std::size_t k = 0; k < correction.contact.size(); ++k) {
    const Index c = correction.contact[k], i = contacts.i[c], j = contacts.j[c];
    if (correction.impulse[k].isZero(0) || j == ground) continue;
    const Vec3 u = bodies.velocity[j] - bodies.velocity[i];
    const Vec3 torque = -h * correction.impulse[k].cross(u);
    const Vec3 apart = bodies.position[j] - bodies.position[i];
    Vec3 q = torque.cross(apart) / apart.squaredNorm();
    Vec3 rest = apart.dot(torque) / apart.squaredNorm() * apart;
    // Clumps may embrace each other: then there is no arm for a pair of impulses.
    constexpr double shortest_arm = 1e-3;
    if (!world.shapes.empty() &&
        apart.norm() < shortest_arm * (bodies.radius[i] + bodies.radius[j])) {
      q.setZero();
      rest = torque;
    }
    for (const auto& [b, sign] : {std::pair(i, -1.0), std::pair(j, 1.0)}) {
      if (moves(b)) {
        impulse[b] += sign * q;
        turn[b] += rest / 2;
      } else if (b < bodies.owned) {
        const Vec3 moved = sign * h * correction.impulse[k].cross(bodies.velocity[b]);
        Reactions::at(world.reactions.of_groups, bodies.group[b])
            .add(bodies.position[b], sign * q, rest / 2 + moved);
      }
    }
  }
  for (Index b = 0; b < bodies.owned; ++b) {
    if (!moves(b)) continue;
    const Vec3 dv = impulse[b] / bodies.mass[b];
    const Vec3 dw = spin_of_momentum(world.shapes, bodies, b, turn[b]);
    gained += impulse[b].dot(bodies.velocity[b] + dv / 2) +
              turn[b].dot(bodies.angular_velocity[b] + dw / 2);
    bodies.velocity[b] += dv;
    bodies.angular_velocity[b] += dw;
  }
  world.ledger.corrections += gained;
}

/// A body that is turned out of the others keeps its angular momentum; with its axes it has another
/// energy then, which is booked.
void turn_apart(World& world, const Correction& correction, double h) {
  Bodies& bodies = world.bodies;
  for (std::size_t k = 0; k < correction.row.size(); ++k) {
    const Index b = correction.row[k];
    const Vec3 turn = h * Eigen::Map<const Vec3>(correction.change[k].angular) / bodies.radius[b];
    if (turn.isZero(0)) continue;
    const bool round = bodies.shape[b] == 0;
    const Vec3 momentum = spin_momentum(world.shapes, bodies, b);
    bodies.orientation[b] = turned_by(turn, bodies.orientation[b]);
    if (round) continue;
    const Vec3 omega = spin_of_momentum(world.shapes, bodies, b, momentum);
    if (b < bodies.owned) {
      world.ledger.corrections += momentum.dot(omega - bodies.angular_velocity[b]) / 2;
      if (bodies.has(Field::angular_acceleration))
        world.ledger.corrections -=
            turn.dot(momentum_of_spin(world.shapes, bodies, b, bodies.angular_acceleration[b]));
    }
    bodies.angular_velocity[b] = omega;
  }
}

}  // namespace

DriftReport drift_apart(World& world, const Ghosts& ghosts, const Pairs& pairs,
                        const Contacts& contacts, double h) {
  DriftReport report;
  Bodies& bodies = world.bodies;
  const std::vector<Turn> turns = turns_at_end(world, h);
  const Correction correction = correct_overlaps(world, ghosts, contacts, turns, h, report);
  for (Index b = 0; b < bodies.size(); ++b) bodies.position[b] += h * bodies.velocity[b];
  for (std::size_t k = 0; k < correction.row.size(); ++k)
    bodies.position[correction.row[k]] += h * Eigen::Map<const Vec3>(correction.change[k].linear);
  for (std::size_t b = 0; b < turns.size(); ++b) {
    bodies.orientation[b] = turns[b].orientation;
    bodies.angular_velocity[b] = turns[b].angular_velocity;
  }
  if (!turns.empty()) turn_apart(world, correction, h);
  world.ledger.corrections += opened_bonds(world, pairs, correction, turns, h);
  keep_angular_momentum(world, contacts, correction, h);
  return report;
}

}  // namespace spall
