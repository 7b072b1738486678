// One line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include "penalty_keys.hpp"

#include "spall/base/require.hpp"

namespace spall {
namespace {

using dimension::pressure, dimension::spring_constant;
constexpr Dimension surface_energy{0, 1, -2};
constexpr Choice<PenaltyModel> models[] = {{"hertz", PenaltyModel::hertz},
                                           {"hooke", PenaltyModel::hooke}};
constexpr Choice<Adhesion> adhesions[] = {
    {"none", Adhesion::none}, {"dmt", Adhesion::dmt}, {"jkr", Adhesion::jkr}};

}  // namespace

void read_penalty(Section& in, PenaltySettings& s) {
  in.take("model", "hertz: Hertz and Mindlin; hooke: linear", s.model, models);
  if (in.reads(s.model == PenaltyModel::hertz)) {
    in.need("young_modulus", "of both bodies: hertz", s.young_modulus, positive(pressure));
    in.take("poisson_ratio", "of both bodies: hertz", s.poisson_ratio, Quantity{{}, 0, 0.5});
    in.take("adhesion", "beside contact.cohesion: hertz", s.adhesion, adhesions);
  }
  if (in.reads(s.adhesion != Adhesion::none))
    in.need("work_of_adhesion", "of two surfaces, twice the surface energy: dmt, jkr",
            s.work_of_adhesion, positive(surface_energy));
  if (in.reads(s.model == PenaltyModel::hooke)) {
    in.need("stiffness", "of a pair: hooke", s.stiffness, positive(spring_constant));
    in.take("tangential_ratio", "tangential stiffness over stiffness: hooke", s.tangential_ratio,
            Quantity{{}, 0, 1, false});
  }
  in.take("rolling_friction", "largest rolling torque over R_eff and the normal force",
          s.rolling_friction, not_negative({}));
}

void read_walls(Section& in, Case& scene) {
  in.tables("boxes", "[[boxes]]: bodies are inside, between six planes", [&](Section& s) {
    Vec3 center = Vec3::Zero(), size = Vec3::Zero();
    s.take("center", "", center, any(dimension::length));
    s.need("size", "full widths", size, positive(dimension::length));
    for (int k = 0; k < 3; ++k)
      for (double side : {-1.0, 1.0})
        scene.planes.push_back(
            {center + side / 2 * size[k] * Vec3::Unit(k), -side * Vec3::Unit(k)});
  });
  in.tables("cylinders", "[[cylinders]]: endless, bodies are inside", [&](Section& s) {
    Cylinder& cylinder = scene.cylinders.emplace_back();
    s.take("point", "on the axis", cylinder.point, any(dimension::length));
    s.take("axis", "", cylinder.axis, any(dimension::number));
    s.radius("", cylinder.radius);
    s.check("axis", !cylinder.axis.isZero(0), "is zero");
    cylinder.axis.normalize();
  });
  in.table("periodic", "space repeats itself", [&](Section& s) {
    s.take("low", "corner of the box that repeats", scene.period.low, any(dimension::length));
    s.need("size", "of the box; 0: does not repeat in this direction", scene.period.size,
           not_negative(dimension::length));
  });
}

void check_penalty(const Case& scene, const Phase& phase) {
  require(scene.penalty.has_value(),
          "{}: phases.{}.method = \"penalty\" needs [penalty]: stiffness or young_modulus",
          scene.file, phase.name);
  require(scene.contact.restitution > 0,
          "{}: phases.{}.method = \"penalty\" needs contact.restitution > 0: it sets the damping",
          scene.file, phase.name);
  require(
      !scene.contact.cohesion_is_impulse,
      "{}: contact.cohesion_law = \"impulse\" is for phases of method = \"nonsmooth\" only, not "
      "for phases.{}",
      scene.file, phase.name);
  for (int k = 0; k < 3; ++k)
    require(scene.period.size[k] == 0 || scene.uniform_gravity[k] == 0,
            "{}: gravity.uniform points along {}, in which [periodic] repeats: nothing would end a "
            "body's fall",
            scene.file, "xyz"[k]);
  require(!scene.period.any() || scene.gravity.method == GravityMethod::none,
          "{}: [periodic] needs gravity.method = \"none\": images do not attract", scene.file);
  require(scene.penalty->rolling_friction == 0 || scene.contact.friction > 0,
          "{}: penalty.rolling_friction needs contact.friction > 0: bodies without it slide",
          scene.file);
  require(scene.read_out.empty(),
          "{}: read_out is for phases of method = \"nonsmooth\" only, not for phases.{}",
          scene.file, phase.name);
}

}  // namespace spall
