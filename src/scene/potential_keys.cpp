// One line a key, with its unit, its range and its meaning.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential_keys.hpp"

#include "materials.hpp"
#include "spall/base/require.hpp"

namespace spall {
namespace {

using namespace dimension;  // energy, length ...: the units of the keys

constexpr Choice<PairLaw> pair_laws[] = {{"lennard_jones", PairLaw::lennard_jones},
                                         {"mie", PairLaw::mie},
                                         {"morse", PairLaw::morse},
                                         {"steinhauser", PairLaw::steinhauser}};
constexpr Choice<Match> matches[] = {{"solid", Match::solid}, {"bulk", Match::bulk}};

void read_exponent(Section& in, std::string_view key, std::string_view meaning, int& exponent) {
  std::int64_t value = exponent;
  in.take(key, meaning, value, 1);
  in.check(key, value <= 100, "is more than 100");
  exponent = static_cast<int>(value);
}

/// Bonds that break at a force or an energy, as strains.
void read_strength(Section& in, PairPotential& p) {
  double most = 0;
  const auto take = [&](std::string_view key, std::string_view meaning, Dimension dimension,
                        double (*strain_of)(const PairPotential&, double)) {
    if (!in.reads(p.breaking_strain == 0)) return;
    in.take(key, meaning, most, positive(dimension));
    if (!in.has(key)) return;
    p.breaking_strain = strain_of(p, most);
    in.check(key, p.breaking_strain > 0, "is more than the law bears");
  };
  take("breaking_force", "instead of breaking_strain: where the law pulls as much", force,
       strain_of_force);
  take("breaking_energy", "instead of breaking_strain: where the law has stored as much", energy,
       strain_of_energy);
}

}  // namespace

void read_pair_potential(Section& in, PairPotential& p, std::optional<DerivedLaw>& derived) {
  read_derived_law(in, "the law is morse's and follows from its constants", derived);
  if (derived)
    in.take(
        "match",
        "solid: moduli, shocks and pressure of heat; bulk: pairs alone, bulk modulus and its slope",
        derived->match, matches);
  const auto by_hand = [&](bool asked) { return in.reads(!derived && asked); };
  if (by_hand(true)) {
    in.need("law", "", p.law, pair_laws);
    in.need("depth", "energy that parts a pair", p.depth, positive(energy));
    in.need("distance", "of the centres of a pair at rest", p.distance, positive(length));
  }
  if (by_hand(p.law == PairLaw::mie)) {
    read_exponent(in, "repulsive", "m of mie", p.repulsive);
    read_exponent(in, "attractive", "n of mie", p.attractive);
    in.check("repulsive", p.repulsive > p.attractive, "is not more than attractive");
  }
  if (by_hand(p.law == PairLaw::morse)) {
    in.need("steepness", "a d of morse; (4 s - 2) for a Hugoniot slope s", p.steepness,
            positive(number));
    in.check("steepness", p.steepness <= 100, "is more than 100");
  }
  if (by_hand(p.law == PairLaw::steinhauser))
    in.need("tension", "stiffness of steinhauser beyond distance", p.tension,
            positive(spring_constant));
  in.take("breaking_strain", "the force falls from this strain to none at twice of it",
          p.breaking_strain, Quantity{number, 0, 1});
  if (by_hand(p.breaking_strain == 0)) read_strength(in, p);
  if (by_hand(p.breaking_strain == 0)) {
    in.need("cutoff", "distance beyond which there is no force; follows from breaking_strain",
            p.cutoff, positive(length));
    in.check("cutoff", p.cutoff > p.distance && p.cutoff <= 6 * p.distance,
             "is not between distance and six times of it");
  }
  if (p.breaking_strain > 0) p.cutoff = (1 + 2 * p.breaking_strain) * p.distance;
  in.take("damping", "of approaching and parting while nearer than distance; 1: critical",
          p.damping, not_negative(number));
}

void check_potential(const Case& scene, const Phase& phase) {
  require(scene.potential.has_value(),
          "{}: phases.{}.method = \"potential\" needs [pair_potential]: the law between two bodies",
          scene.file, phase.name);
  require(scene.planes.empty(),
          "{}: [[planes]] do not act in phases of method = \"potential\", as phases.{}", scene.file,
          phase.name);
  require(scene.read_out.empty(),
          "{}: read_out is for phases of method = \"nonsmooth\" only, not for phases.{}",
          scene.file, phase.name);
}

}  // namespace spall
