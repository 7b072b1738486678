// The algorithm, stage by stage; formulas beside their stages.
// SPDX-License-Identifier: BSD-3-Clause
#include "rigid/step.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/let_go.hpp"
#include "engine/prescribed.hpp"
#include "gravity/kick.hpp"
#include "rigid/narrow_phase.hpp"
#include "rigid/overlap_correction.hpp"
#include "solver/problem.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

std::vector<double> inverse_masses(const Bodies& bodies) {
  std::vector<double> w(bodies.size());
  for (Index b = 0; b < bodies.size(); ++b) w[b] = inverse_mass(bodies, b);
  return w;
}

/// How long of a step `h` a pair with gap `g` that separates at `u` is within `range`.
double time_in_range(double g, double u, double h, double range) {
  const double enters = g > range ? (u < 0 ? (range - g) / u : h) : 0;
  const double leaves = u > 0 ? (range - g) / u : h;
  return std::clamp(std::min(leaves, h) - enters, 0.0, h);
}

/// N s, of a pair's cohesion in a step `h` (s) that begins at this gap (m) and speed (m/s).
double cohesive_impulse(const ContactLaw& law, double gap, double closing, double h) {
  switch (law.cohesion_law) {
    case CohesionLaw::force:
      return law.cohesion * time_in_range(gap, closing, h, law.cohesion_range);
    case CohesionLaw::impulse:
      return gap <= law.cohesion_range ? law.cohesion : 0;
  }
  __builtin_unreachable();
}

/// The problem's vectors; `ContactProblem` looks at them.
struct ProblemData {
  std::vector<double> inverse_mass;
  std::vector<Vec3> free_velocity;
  std::vector<double> friction, cohesive_impulse;
  LeverArms levers;
  bool impact = false;  ///< a pair meets faster than what drives resting contacts makes it
  /// J of this rank, at most: what restitution would leave those that meet faster than what drives
  /// them both, and yet no faster than what drives others may make a resting contact.
  double withheld = 0;

  /// What a solver has in its own form.
  void let_go_of_packed() { let_go(free_velocity, friction, levers.arm_i, levers.arm_j); }
  ContactProblem view(const Contacts& contacts, int dimension) const {
    return {.dimension = dimension,
            .boundary = contacts.boundary,
            .inverse_mass = inverse_mass,
            .i = contacts.i,
            .j = contacts.j,
            .normal = contacts.normal,
            .kappa = contacts.kappa,
            .arm_i = levers.arm_i,
            .arm_j = levers.arm_j,
            .turning = levers.turning,
            .free_velocity = free_velocity,
            .friction = friction,
            .cohesive_impulse = cohesive_impulse};
  }
};

/// m/s at which a pair that closes at `closing` over `gap` comes back to this gap after an impact
/// with restitution `e`. Its relative acceleration `a` (negative: closing) speeds it up on the way
/// to the surface and slows it down behind it. 0: it does not come back so far.
double rebound(double closing, double gap, double a, double e) {
  const double speed2_at_surface = std::max(closing * closing - 2 * a * gap, 0.0);
  return std::sqrt(std::max(e * e * speed2_at_surface + 2 * a * gap, 0.0));
}

/// What contacts are asked for.
struct Push {
  double h = 0;         ///< s, over which pairs may meet
  double driven = 0;    ///< m/s that other forces gave a body at most; infinity: nothing hits
  double cohesion = 1;  ///< of that of a step
};

/// Signorini with restitution on velocity level: u_n+ >= -g/h before contact, u_n+ >= 0 in it,
/// u_n+ >= -e u_n- where the pair would close within the step faster than gravity, other forces,
/// cohesion or the prescribed motion of one of both (`accelerations`, m/s^2, by
/// group) alone can drive a resting contact. The law of impact is about velocities of this instant,
/// at the surface: leapfrog's are those of the middle between kicks, and the step begins at the
/// gap.
ProblemData pose(const World& world, const Contacts& contacts, const Push& push,
                 const std::vector<double>& accelerations) {
  const Bodies& bodies = world.bodies;
  const double h = push.h;
  ProblemData data;
  data.inverse_mass = inverse_masses(bodies);
  data.free_velocity.resize(contacts.size());
  if (has_friction(world.contact)) data.friction.resize(contacts.size());
  if (has_cohesion(world.contact)) data.cohesive_impulse.assign(contacts.size(), 0);
  data.levers = lever_arms(world, contacts);
  const GravityKick& kick = world.kick;
  // A kick closes the interval before it, which may have been longer.
  const double interval = world.has_gravity() ? std::max(kick.interval, kick.load) : 0;
  const double by_gravity = interval * kick.largest;
  const auto driven_by = [&](Index b) {
    if (accelerations.empty() || b == ground) return 0.0;
    const std::int32_t group = bodies.group[b];  // an impactor has none
    return group < std::ssize(accelerations) ? h * accelerations[group] : 0.0;
  };
  const double ahead = world.has_gravity() ? kick.steps_left * h - kick.interval / 2 : 0;  // s
  for (Index c = 0; c < contacts.size(); ++c) {
    const Index i = contacts.i[c], j = contacts.j[c];
    const ContactLaw& law = law_of(world, contacts, c);
    if (!data.friction.empty()) data.friction[c] = law.friction;
    const Vec3& n = contacts.normal[c];
    const double gap = contacts.gap[c];
    const Vec3 u = contact_velocity(bodies, contacts, c);
    const double closing = u.dot(n);
    double pulled = 0;  // m/s, what cohesion takes from the closing speed
    if (law.cohesion > 0) {
      const double cohesive = push.cohesion * cohesive_impulse(law, gap, closing, h);
      pulled = cohesive * (contacts.spheres.empty()
                               ? data.inverse_mass[i] + (j == ground ? 0 : data.inverse_mass[j])
                               : n.dot(delassus_block(data.view(contacts, 3), c) * n));
      data.cohesive_impulse[c] = cohesive;
    }
    const double to_close = gap_to_close(bodies, contacts, c, h);
    const double open = std::max(to_close, 0.0);
    double bias = open / h;
    const double by_others = push.driven + std::max(driven_by(i), driven_by(j));
    const double driven = 2 * (by_gravity + by_others);
    const bool meets = to_close + h * closing < 0 && -closing > driven + 2 * pulled;
    data.impact |= meets;
    const double a_n = law.restitution > 0 && world.has_gravity()
                           ? contact_acceleration(bodies, contacts, c).dot(n)
                           : 0;
    if (!meets && law.restitution > 0 && to_close + h * closing < 0 &&
        -closing > 2 * (interval * std::max(0.0, -a_n) + by_others + pulled)) {
      const double kept = law.restitution * closing;
      const double inverse = data.inverse_mass[i] + (j == ground ? 0 : data.inverse_mass[j]);
      data.withheld += kept * kept / (2 * inverse) * (c < contacts.boundary ? 0.5 : 1);
    }
    if (meets && law.restitution > 0) {
      const double leaves = rebound(closing - ahead * a_n, open, a_n, law.restitution);
      bias = std::min(bias, -(leaves + ahead * a_n));
    }
    data.free_velocity[c] = u + bias * n;
  }
  return data;
}

/// Enters what walls and held bodies receive by the impulses. Returns the work (J) of held bodies.
double book_reactions(World& world, const Contacts& contacts) {
  const Bodies& bodies = world.bodies;
  const double before = world.ledger.prescribed_work;
  for (Index c = 0; c < contacts.size(); ++c) {
    const Vec3& push = contacts.impulse[c];
    if (push.isZero(0)) continue;
    const Index i = contacts.i[c], j = contacts.j[c];
    const Vec3& n = contacts.normal[c];
    const bool shapes = !contacts.spheres.empty();
    const auto turn = [&](Index b) -> Vec3 {
      if (shapes)
        return b == i ? Vec3(-contacts.spheres[c].arm_i.cross(push))
                      : Vec3(contacts.spheres[c].arm_j.cross(push));
      return -contacts.kappa[c] * bodies.radius[b] * n.cross(push);
    };
    if (j == ground)
      Reactions::at(world.reactions.of_walls, contacts.plane[c])
          .add(bodies.position[i] +
                   (shapes ? contacts.spheres[c].arm_i : Vec3(bodies.radius[i] * n)),
               push);
    else if (j < bodies.owned && is_held(bodies, j))
      book_held(world, j, bodies.position[j], push, turn(j));
    if (i < bodies.owned && is_held(bodies, i))
      book_held(world, i, bodies.position[i], -push, turn(i));
  }
  return world.ledger.prescribed_work - before;
}

/// Newton's law of restitution tells normal speeds alone: with friction an eccentric hit of a shape
/// may give energy. Books what a step of hits gained (`gain`, J, of this rank), beyond what its
/// solver leaves open of the `exchanged` energy, and beyond what impulses do in the change of speed
/// between two kicks of gravity. Collective.
void book_gain(World& world, const Contacts& contacts, double gain, double exchanged,
               double residual) {
  const Bodies& bodies = world.bodies;
  double open = residual * exchanged;
  const double interval =
      world.has_gravity() ? std::max(world.kick.interval, world.kick.load) : 0;  // s
  for (Index c = 0; c < contacts.size(); ++c) {
    if (contacts.i[c] >= bodies.owned) continue;
    open +=
        interval * contact_acceleration(bodies, contacts, c).norm() * contacts.impulse[c].norm();
  }
  std::array<double, 2> sums{gain, open};
  world.comm.sum(sums);
  if (world.comm.rank == 0 && sums[0] > sums[1]) world.ledger.gained += sums[0];
}

/// Where contacts touch each other's friction, restitution may leave Coulomb's law without a
/// solution that is found, as of a ball in an edge whose friction is large: iterates diverge, and
/// all contacts of the world would go without impulses. The convex law always has one.
template <class Pose>
SolverResult solve_or_relax(ProblemData& data, Pose&& pose, Contacts& contacts, int dimension,
                            const Ghosts& ghosts, SolverSettings settings) {
  const auto solve_posed = [&] {
    return solve(data.view(contacts, dimension), ghosts, settings, contacts.impulse,
                 [&] { data.let_go_of_packed(); });
  };
  SolverResult result = solve_posed();
  if (!result.report.unsolved || settings.friction == FrictionModel::convex) return result;
  const SolverReport before = result.report;
  settings.friction = FrictionModel::convex;
  data = pose();
  std::ranges::fill(contacts.impulse, Vec3::Zero());
  result = solve_posed();
  result.report.relaxed = true;
  result.report.iterations += before.iterations;
  result.report.products += before.products;
  return result;
}

/// Adds the impulses' velocities to all rows; books the work of contacts, cohesion and gravity.
/// With v the velocity before the kick k and v' after the impulses' dv, the kinetic energy changes
/// by
///
///   m (v' - v).(v' + v)/2 = m k.(v + v')/2 + m dv.(v + v')/2,
///
/// so a pile at rest (v = v' = 0) dissipates nothing, whatever its load. What held bodies gave by
/// their work is no loss of the others. `met`: bodies have hit each other, on any rank.
void kick_by_impulses(World& world, const Contacts& contacts, const ProblemData& data,
                      const std::vector<VelocityChange>& change, bool met, StepReport& report) {
  Bodies& bodies = world.bodies;
  const double load = world.has_gravity() ? world.kick.load : 0;
  const bool turned = world.has_near_clumps();
  std::vector<double> closing_before;
  const bool cohesive = has_cohesion(world.contact);
  auto closing = [&](Index c) {
    if (!contacts.spheres.empty())
      return contacts.normal[c].dot(contact_velocity(bodies, contacts, c));
    const Index i = contacts.i[c], j = contacts.j[c];
    Vec3 v = -bodies.velocity[i];
    if (j != ground) v += bodies.velocity[j];
    return contacts.normal[c].dot(v);
  };
  if (cohesive)
    for (Index c = 0; c < contacts.size(); ++c)
      closing_before.push_back(
          closing(c) - load * contacts.normal[c].dot(contact_acceleration(bodies, contacts, c)));

  double by_impulses = 0, by_gravity = 0, exchanged = 0;
  for (Index b = 0; b < bodies.size(); ++b) {
    const Eigen::Map<const Vec3> dv(change[b].linear), ds(change[b].angular);
    if (b < bodies.owned && std::isfinite(bodies.mass[b])) {
      const Vec3 s = bodies.radius[b] * bodies.angular_velocity[b];
      const Vec3 kick = load * bodies.acceleration[b];
      const Vec3 mean = bodies.velocity[b] + (dv - kick) / 2;
      Vec3 turn = Vec3::Zero();  // gravity's, times the radius as ds
      if (turned) turn = load * bodies.radius[b] * bodies.angular_acceleration[b];
      const Vec3 mean_turn = s + (ds - turn) / 2;
      double by_turn = sphere_inertia * ds.dot(mean_turn);
      if (!world.shapes.empty()) {
        const Mat3 inertia = inertia_factor(world.shapes, bodies, b);
        by_turn = (inertia * ds).dot(mean_turn);
        exchanged += bodies.mass[b] * (dv.norm() * mean.norm() + std::abs(by_turn));
        by_gravity += bodies.mass[b] * (inertia * turn).dot(mean_turn);
      }
      by_impulses += bodies.mass[b] * (dv.dot(mean) + by_turn);
      by_gravity += bodies.mass[b] * kick.dot(mean);
    }
    bodies.velocity[b] += dv;
    bodies.angular_velocity[b] += ds / bodies.radius[b];
  }

  double by_cohesion = 0;
  if (cohesive)
    for (Index c = 0; c < contacts.size(); ++c)
      if (contacts.i[c] < bodies.owned &&
          law_of(world, contacts, c).cohesion_law == CohesionLaw::force)
        by_cohesion -= data.cohesive_impulse[c] * (closing_before[c] + closing(c)) / 2;
  const double by_held = book_reactions(world, contacts);
  world.ledger.cohesion_work += by_cohesion;
  const double gain = by_impulses - by_cohesion - by_held;
  world.ledger.dissipated -= gain;
  if (met && !world.shapes.empty())
    book_gain(world, contacts, gain, exchanged, report.solver.residual);
  report.gravity_work = by_gravity;
}

bool carries(const Vec3& impulse) {
  return !impulse.isZero(0);
}

/// What the contacts carried, with their pairs.
void keep_impulses(const Contacts& contacts, Pairs& pairs) {
  pairs.carried.clear();
  pairs.carried.reserve(std::ranges::count_if(contacts.impulse, carries));
  for (Index c = 0; c < contacts.size(); ++c) {
    if (!carries(contacts.impulse[c])) continue;
    CarriedImpulse& carried = pairs.carried.emplace_back();
    carried.pair = contacts.pair[c];
    carried.impulse = contacts.impulse[c];
    if (contacts.spheres.empty()) continue;
    carried.of_i = contacts.spheres[c].of_i;
    carried.of_j = contacts.spheres[c].of_j;
  }
}

/// Contacts as bodies are now, with what they carried at the last kick.
Contacts find_step_contacts(World& world, Rigid& rigid, double h, StepReport& report) {
  Bodies& bodies = world.bodies;
  {
    StageTimer timer(world.stages, "neighbours");
    rigid.neighbours.cut = world.cut;
    update_neighbours(world.comm, bodies, world.planes, h, longest_range(world.contact),
                      rigid.neighbours);
  }
  Pairs& pairs = rigid.neighbours.pairs;
  StageTimer timer(world.stages, "contacts");
  Contacts contacts = find_contacts(bodies, world.shapes, world.planes, pairs, h, world.contact);
  // Kept anew; until then the solver needs the memory.
  if (world.kick.load > 0) let_go(pairs.carried);
  report.energy = energy_of_bonds(world, contacts);
  report.contacts = std::count_if(contacts.i.begin(), contacts.i.end(),
                                  [&](Index i) { return i < bodies.owned; });
  return contacts;
}

/// Leaves the contacts that carried something at the last kick.
void keep_carrying(Contacts& contacts) {
  std::vector<char> kept;
  for (const Vec3& impulse : contacts.impulse) kept.push_back(carries(impulse) ? 1 : 0);
  contacts.boundary =
      static_cast<Index>(std::count(kept.begin(), kept.begin() + contacts.boundary, 1));
  const auto keep = [&](auto& values) {
    std::size_t at = 0;
    std::erase_if(values, [&](const auto&) { return kept[at++] == 0; });
  };
  keep(contacts.i);
  keep(contacts.j);
  keep(contacts.plane);
  keep(contacts.normal);
  keep(contacts.gap);
  keep(contacts.kappa);
  keep(contacts.impulse);
  keep(contacts.pair);
  if (!contacts.spheres.empty()) keep(contacts.spheres);
}

/// Solves for what contacts do against the kick and against each other.
void push_contacts(World& world, Rigid& rigid, Contacts& contacts, const Push& push,
                   StepReport& report) {
  StageTimer timer(world.stages, "solver");
  GravityKick& kick = world.kick;
  // Between kicks nothing loads a resting pile: what the contacts carried at the last kick says
  // nothing about such a step, and all about the next kick.
  const double scale = kick.remembered_load > 0 ? kick.load / kick.remembered_load : 0;
  for (Vec3& impulse : contacts.impulse) impulse *= scale;
  const auto pose_step = [&] {
    return pose(world, contacts, push,
                prescribed_accelerations(world, world.time - push.h, world.time + push.h));
  };
  ProblemData data = pose_step();
  const int dimension = has_friction(world.contact) || !world.shapes.empty() ? 3 : 1;
  SolverSettings settings = rigid.solver;
  // Without friction both laws are one, and methods that minimise want it named so.
  if (!has_friction(world.contact)) settings.friction = FrictionModel::convex;
  // A kick's step has impulses of the last one to be judged by; between kicks there are none.
  std::array<double, 2> sums{data.impact ? 1.0 : 0.0, data.withheld};
  world.comm.sum(sums);
  const bool met = sums[0] > 0;
  report.withheld = sums[1];
  settings.impact = met || kick.load > 0;
  if (!settings.impact) settings.least_scale = kick.remembered_scale;
  const SolverResult result =
      solve_or_relax(data, pose_step, contacts, dimension, rigid.neighbours.ghosts, settings);
  report.solver = result.report;
  kick_by_impulses(world, contacts, data, result.change, met, report);
  if (kick.load > 0) {
    keep_impulses(contacts, rigid.neighbours.pairs);
    kick.remembered_load = kick.load;
    kick.remembered_scale = met ? 0 : result.report.scale;
  }
}

}  // namespace

SolverReport close_nonsmooth_kick(World& world, Rigid& rigid, double h) {
  StepReport report{.solver = {.converged = true}};
  close_kick(world);
  if (world.kick.load == 0) return report.solver;
  Contacts contacts = find_step_contacts(world, rigid, h, report);
  keep_carrying(contacts);  // no time passes in which others could meet
  push_contacts(world, rigid, contacts, {.h = h, .driven = infinity, .cohesion = 0.5}, report);
  world.kick.load = 0;
  return report.solver;
}

StepReport nonsmooth_step(World& world, Rigid& rigid, const StepRequest& request) {
  StepReport report;
  GravityKick& kick = world.kick;
  const double h = request.h;
  require(world.bodies.has(Field::angular_velocity) && world.bodies.has(Field::acceleration),
          "steps of rigid spheres need fields that the bodies were made without");

  // Before gravity's kick, whose work is then told from velocities that hold these changes; and
  // before the search for pairs, after which bodies may be others' or have other rows.
  const double driven = kick_by_own_forces(world, h);
  set_prescribed_velocities(world, world.time, h);
  if (kick.steps_left == 0) {
    evaluate_field(world);
    give_kick(world, h, world.own_forces.empty() ? request.most_steps : 1);
  }
  Contacts contacts = find_step_contacts(world, rigid, h, report);
  push_contacts(world, rigid, contacts, {.h = h, .driven = driven}, report);
  {
    StageTimer timer(world.stages, "motion");
    // What takes overlaps apart asks where bodies touch alone, and needs the memory.
    let_go(contacts.gap, contacts.kappa, contacts.impulse, contacts.pair);
    const DriftReport drifted =
        drift_apart(world, rigid.neighbours.ghosts, rigid.neighbours.pairs, contacts, h);
    move_prescribed(world, h);
    report.overlap = drifted.overlap;
    report.correction_products = drifted.products;
  }
  kick.load = 0;
  kick.evaluated = false;
  --kick.steps_left;
  return report;
}

}  // namespace spall
