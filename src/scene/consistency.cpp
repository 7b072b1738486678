// Each refusal here is of something that a run would leave out or do wrong without a word.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/consistency.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include "engine/type.hpp"
#include "scene/orbit.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

const Group* find_held(const Case& scene) {
  const auto found = std::ranges::find_if(scene.groups, &Group::held);
  return found == scene.groups.end() ? nullptr : &*found;
}

bool has_fixed_sphere(const Case& scene) {
  return std::ranges::any_of(scene.spheres, &SceneSphere::fixed);
}

/// Whether there is anything free that an impactor could move.
bool has_target(const Case& scene, Groups groups) {
  const bool whole = groups == Groups::needed || !scene.spheres.empty();  // a program adds its own
  return !whole || !std::ranges::all_of(scene.groups, &Group::held) ||
         !std::ranges::all_of(scene.spheres, &SceneSphere::fixed);
}

/// From the one with an impactor on; none without.
std::span<const Phase> phases_of_impact(const Case& scene) {
  return {std::ranges::find_if(scene.phases, &Phase::has_impactor), scene.phases.end()};
}

/// Times of read-outs count from the impact; what lies behind the last phase is never measured.
void check_read_outs(const Case& scene, Groups groups) {
  if (scene.read_out.empty()) return;
  const std::span<const Phase> phases = phases_of_impact(scene);
  require(!phases.empty(), "{} tells times after the impact, but no phase has an impactor",
          scene.read_out_place);
  const Phase& hit = phases.front();
  const double end = duration_of(phases);
  require(has_target(scene, groups),
          "{} tells how a target is deflected, but all groups are fixed or move as prescribed",
          scene.read_out_place);
  const double half_a_step = scene.phases.back().step / 2;
  const double last = std::ranges::max(scene.read_out);
  require(last <= end + half_a_step,
          "{} = {:g} s is never reached: phases end {:g} s after the impactor is added",
          scene.read_out_place, last, end);
  const Impactor& impactor = *hit.impactor;
  const double flight = impactor.distance / impactor.speed;
  const double first = std::ranges::min(scene.read_out);
  require(first > flight,
          "{} = {:g} s: the impactor of {} has not arrived by then, it flies {:g} m at {:g} m/s",
          scene.read_out_place, first, hit.place, impactor.distance, impactor.speed);
}

/// What is added must meet something that is free.
void check_impactor(const Case& scene, const Phase& hit, Groups groups) {
  require(has_target(scene, groups),
          "{}: all groups are fixed or move as prescribed: nothing that it hits is free",
          hit.impactor->place);
}

/// Whether it has settled is looked at in rows of the series alone.
void check_settling(const Case& scene, const Phase& phase) {
  const double every =
      scene.output.series_every.value_or(phase.engine->solves ? 0 : steps_a_row * phase.step);
  require(phase.until != PhaseEnd::settled || every < phase.duration,
          "{}.until = \"settled\" is looked at in rows of the series, which come every {:g} s, and "
          "the phase ends after {:g} s: a shorter output.series_every is wanted",
          phase.place, every, phase.duration);
}

/// Mechanics here are Newton's: at a tenth of the speed of light the energy is wrong by 1 %.
void check_speeds(const Case& scene) {
  constexpr double most = 0.1 * 299792458.0;  // m/s
  const auto check = [&](const Group& group, const char* key, double speed) {
    require(speed <= most, "{}.{}: {:.3g} m/s are more than a tenth of the speed of light",
            group.place, key, speed);
  };
  for (const Group& group : scene.groups) {
    const Volume& volume = group.volume;
    const bool round = volume.shape == Shape::sphere || volume.shape == Shape::hollow_sphere;
    const bool unread = volume.shape == Shape::mesh && !volume.mesh;
    const double half = round ? volume.radius : unread ? 0 : half_widths(volume).norm();
    check(group, "velocity", group.velocity.norm());
    check(group, "spin", group.spin.norm() * half);
    if (group.thermal) check(group, "thermal_velocity", group.thermal->rms);
    if (!group.motion) continue;
    const VelocityRange range = group.motion->velocities(volume.center, 0, infinity);
    const double turning = range.turning + std::abs(group.motion->rate) * half;
    check(group, "motion", range.low.cwiseAbs().cwiseMax(range.high.cwiseAbs()).norm() + turning);
  }
  for (const Phase& phase : scene.phases)
    require(!phase.impactor || phase.impactor->speed <= most,
            "{}.impactor.speed: {:.3g} m/s are more than a tenth of the speed of light",
            phase.place, phase.impactor ? phase.impactor->speed : 0);
}

/// The centre of mass moves to the origin, and with it all bodies: nothing else may be anywhere.
void check_removal_of_drift(const Case& scene, const Phase& phase) {
  const auto refuse_beside = [&](bool there, std::string_view what) {
    require(!there, "{}.remove_drift: {} would stay where it is while bodies are moved",
            phase.place, what);
  };
  const std::span<const Phase> phases = phases_of_impact(scene);
  const bool later = !phases.empty() && &phase > &phases.front();
  const double begins = later ? duration_of({&phases.front(), &phase}) : 0;
  require(!later || scene.read_out.empty() || std::ranges::max(scene.read_out) <= begins,
          "{}.remove_drift takes away what the impact gave, and {} asks later how fast the target "
          "has become",
          phase.place, scene.read_out_place);
  refuse_beside(!scene.planes.empty(), "a wall of [[planes]] or [[boxes]]");
  refuse_beside(!scene.cylinders.empty(), "a wall of [[cylinders]]");
  refuse_beside(scene.period.any(), "the box of [periodic]");
  const Group* held = find_held(scene);
  refuse_beside(held, held ? fmt::format("groups.{}, which is {},", held->name,
                                         held->fixed ? "fixed" : "moved as prescribed")
                           : "");
  refuse_beside(has_fixed_sphere(scene), "a fixed sphere of the program");
}

/// The flow of an impact is known of loose ground, and its recoil of a target that is free.
void check_coupling(const Case& scene, const Phase& phase) {
  const Impactor& impactor = *phase.impactor;
  const PointSource& source = *impactor.coupling;
  const std::string place = impactor.place + ".coupling";
  require(std::ranges::count(phase.engine->tables, "contact") > 0,
          "{}: the flow is handed to loose bodies, but with method = \"{}\" they are parts of a "
          "solid",
          place, phase.engine->name);
  require(scene.shapes.empty(),
          "{}: the flow is handed to spheres alone, not to bodies with [shapes]", place);
  const LaunchFlow flow(source, impactor.radius, impactor.mass / ball_volume(impactor.radius),
                        impactor.speed);
  double densest = 0;
  for (const Group& group : scene.groups)
    densest = std::max(densest, scene.materials[group.material].density);
  require(densest == 0 || source.density <= densest,
          "{}.density = {:g} kg/m^3 is that of the ground with its voids, but its bodies are of "
          "{:g} kg/m^3 at most",
          place, source.density, densest);
  require(source.hand_over > flow.begin(),
          "{}.hand_over = {:g} m lies within {:.4g} m, n1 radii of the impactor, where nothing is "
          "launched",
          place, source.hand_over, flow.begin());
  require(source.hand_over < flow.end(),
          "{}.hand_over = {:g} m lies beyond {:.4g} m, n2 radii of the crater, where the flow ends",
          place, source.hand_over, flow.end());
  const double inner =
      flow.between(flow.begin(), source.hand_over).momentum * std::sin(source.angle);
  require(inner <= impactor.mass * impactor.speed,
          "{}.hand_over = {:g} m: {:.3g} m U are launched within, and in the impactor's body alone "
          "they would have more energy than the impact: a smaller hand_over gives more to bodies",
          place, source.hand_over, inner / (impactor.mass * impactor.speed));
  const std::string taker = taker_of_recoil(scene);
  require(taker.empty(), "{}: {} would take a part of the recoil, which is the free target's",
          place, taker);
}

/// Bodies that move as prescribed fly straight from where a step begins to where it ends.
void check_motions(const Case& scene) {
  constexpr double most = 1.0 / 8;  // of a turn or a period: 3 % of a speed
  // What steps of that length do not see of an oscillation's turning points, of its range.
  const double turns_back = (1 - std::cos(pi * most)) / 2;
  for (const Group& group : scene.groups) {
    if (!group.motion) continue;
    const double turns = std::max(std::abs(group.motion->rate) / (2 * pi),
                                  group.motion->amplitude.isZero(0) ? 0 : 1 / group.motion->period);
    for (const Phase& phase : scene.phases) {
      require(phase.step * turns <= most,
              "{}.step = {:g} s is {:.3g} of a turn or an oscillation of {}.motion, which is gone "
              "through straight on: an eighth, {:g} s, is the most",
              phase.place, phase.step, phase.step * turns, group.place, most / turns);
      const double unseen = group.motion->unseen_by_steps(phase.step);
      require(
          unseen <= turns_back,
          "{}.step = {:g} s does not see {:.2g} of the range of {}.motion.table, where it turns "
          "back within a step: {:.2g} is the most",
          phase.place, phase.step, unseen, group.place, turns_back);
    }
  }
}

void check_gravity(const Case& scene) {
  if (scene.gravity.method == GravityMethod::none) return;
  if (const Group* held = find_held(scene))
    throw Error(
        fmt::format("{}.{}: self-gravity needs finite masses: leave it out, or gravity.method",
                    held->place, held->fixed ? "fixed" : "motion"));
  require(!has_fixed_sphere(scene),
          "{}: a fixed sphere: self-gravity needs finite masses: leave it out, or gravity.method",
          scene.file);
}

/// A wall that does not run along a direction in which space repeats itself would end at the
/// border.
void check_repeated_walls(const Case& scene) {
  constexpr double round_off = 1e-12;
  for (int k = 0; k < 3; ++k) {
    if (scene.period.size[k] == 0) continue;
    const auto runs_along = [&](const std::string& wall, double off) {
      require(off <= round_off,
              "{}: the wall \"{}\" does not run along {}, which [periodic] repeats", scene.file,
              wall, "xyz"[k]);
    };
    for (const Plane& plane : scene.planes) runs_along(plane.name, std::abs(plane.normal[k]));
    for (const Cylinder& cylinder : scene.cylinders)
      runs_along(cylinder.name, 1 - std::abs(cylinder.axis[k]));
  }
}

/// Bonds and stresses are what bodies have gone through by one method; another moves them without.
bool keeps_damage(const Case& scene, const Phase& phase) {
  return phase.engine->fields(scene, phase.settings).has(Field::damage);
}

/// Solids that were left for another method would be whole again.
void check_methods(const Case& scene) {
  for (auto later = scene.phases.begin(); later != scene.phases.end(); ++later) {
    if (!keeps_damage(scene, *later)) continue;
    const auto first = std::ranges::find(scene.phases, later->engine, &Phase::engine);
    const auto other = std::find_if(
        first, later, [&](const Phase& phase) { return phase.engine != later->engine; });
    require(other == later,
            "{}.method = \"{}\": phases.{} has moved the bodies of phases.{} by another method, "
            "without their bonds and stresses: what was broken would be whole again",
            later->place, later->engine->name, other->name, first->name);
    const auto former = std::find_if(scene.phases.begin(), later, [&](const Phase& phase) {
      return phase.engine != later->engine && keeps_damage(scene, phase);
    });
    require(former == later,
            "{}.method = \"{}\": it knows nothing of the bonds and stresses of phases.{}: what was "
            "broken would be whole again",
            later->place, later->engine->name, former == later ? "" : former->name);
  }
}

/// Spheres at the border of two grains overlap: contacts and bonds would blow them apart.
void check_grains(const Case& scene) {
  for (const Group& group : scene.groups) {
    if (!group.packing.grain) continue;
    require(!scene.period.any(), "{}.packing.grains: they do not go on at the border of [periodic]",
            group.place);
    for (const Phase& phase : scene.phases)
      require(phase.engine->fields(scene, phase.settings).has(Field::direct_stress),
              "{}.packing.grains: grains overlap where they meet, which bodies bear that carry a "
              "stress of their own: {}.method = \"solid\" is wanted, not \"{}\"",
              group.place, phase.place, phase.engine->name);
  }
}

}  // namespace

double duration_of(std::span<const Phase> phases) {
  double sum = 0;
  for (const Phase& phase : phases) sum += phase.lasts();
  return sum;
}

std::string taker_of_recoil(const Case& scene) {
  if (scene.walls().size() > 0) return "a wall";
  if (scene.period.any()) return "the box of [periodic]";
  const auto stores_fixed = [](const Group& group) {
    return std::ranges::any_of(group.packing.stored, &StoredBody::fixed);
  };
  const bool holds = find_held(scene) || has_fixed_sphere(scene) ||
                     std::ranges::any_of(scene.groups, stores_fixed);
  return holds ? "a held body" : "";
}

std::string warning_of_read_outs(const Case& scene) {
  if (scene.read_out.empty()) return "";
  const bool falls = !scene.uniform_gravity.isZero(0);
  const std::string taker = falls ? "gravity.uniform" : taker_of_recoil(scene);
  if (taker.empty()) return "";
  return fmt::format(
      "{} moves the target, too: dv, beta and ejecta are not the impact's alone, as they are of a "
      "free one",
      taker);
}

std::vector<std::string> warnings_of(const Case& scene) {
  std::vector<std::string> told;
  if (const std::string warning = warning_of_read_outs(scene); !warning.empty())
    told.push_back("WARNING: read_out: " + warning);
  for (std::size_t p = 1; p < scene.phases.size(); ++p) {
    const Phase &former = scene.phases[p - 1], &next = scene.phases[p];
    if (next.engine != former.engine && keeps_damage(scene, former))
      told.push_back(
          fmt::format("phases.{}: bonds and stresses of method = \"{}\" end here: its bodies go on "
                      "without them",
                      next.name, former.engine->name));
  }
  if (const auto phases = phases_of_impact(scene); !phases.empty()) {
    const Impactor& impactor = *phases.front().impactor;
    const double end = duration_of(phases);
    if (impactor.distance >= impactor.speed * end)
      told.push_back(fmt::format(
          "WARNING: phases.{}.impactor never arrives: it flies {:g} m at {:g} m/s, and phases end "
          "{:g} s after it is added",
          phases.front().name, impactor.distance, impactor.speed, end));
  }
  // Later ones of that method are refused.
  const auto solid = std::ranges::find_if(
      scene.phases, [&](const Phase& phase) { return keeps_damage(scene, phase); });
  if (solid != scene.phases.begin() && solid != scene.phases.end())
    told.push_back(
        fmt::format("WARNING: phases.{}: method = \"{}\" takes groups to be whole and at rest as "
                    "they are then, though phases.{} has moved their bodies one by one before",
                    solid->name, solid->engine->name, scene.phases.front().name));
  return told;
}

void check_stored_damage(const Case& scene) {
  for (const Group& group : scene.groups) {
    double damage = 0;
    for (const StoredBody& body : group.packing.stored) damage += body.damage;
    if (damage == 0) continue;
    for (const Phase& phase : scene.phases)
      require(
          !keeps_damage(scene, phase),
          "{}.packing.file = \"{}\": its bodies have damage, {:.3g} on average, which a packing "
          "does not take over: in {}.method = \"{}\" what was broken would be whole again",
          group.place, group.packing.file,
          damage / static_cast<double>(group.packing.stored.size()), phase.place,
          phase.engine->name);
  }
}

void check_consistency(const Case& scene, Groups groups) {
  check_read_outs(scene, groups);
  check_gravity(scene);
  check_repeated_walls(scene);
  check_methods(scene);
  check_motions(scene);
  check_grains(scene);
  for (const Phase& phase : scene.phases) check_settling(scene, phase);
  check_speeds(scene);
  for (const Phase& phase : scene.phases)
    if (phase.impactor) check_impactor(scene, phase, groups);
  for (const Phase& phase : scene.phases)
    if (phase.remove_drift) check_removal_of_drift(scene, phase);
  for (const Phase& phase : scene.phases)
    if (phase.impactor && phase.impactor->coupling) check_coupling(scene, phase);
  require(!scene.binary || std::ranges::any_of(scene.phases, &Phase::has_impactor),
          "{} asks for the orbit after an impact, but no phase has an impactor",
          scene.binary ? scene.binary->place : "");
  require(!scene.binary || !scene.read_out.empty(),
          "{} follows from the deflection: it needs read_out, times at which that is measured",
          scene.binary ? scene.binary->place : "");
  if (scene.binary) check_orbit(*scene.binary);
}

}  // namespace spall
