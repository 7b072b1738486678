// One line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include "penalty_keys.hpp"

#include "spall/base/require.hpp"

namespace spall {
namespace {

constexpr Dimension pressure{-1, 1, -2}, spring_constant{0, 1, -2}, surface_energy{0, 1, -2};
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
  require(scene.penalty->rolling_friction == 0 || scene.contact.friction > 0,
          "{}: penalty.rolling_friction needs contact.friction > 0: bodies without it slide",
          scene.file);
  require(scene.read_out.empty(),
          "{}: read_out is for phases of method = \"nonsmooth\" only, not for phases.{}",
          scene.file, phase.name);
}

}  // namespace spall
