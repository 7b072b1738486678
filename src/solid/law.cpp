// The laws of Johnson and Cook, of Steinberg and Guinan, and what they need.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/law.hpp"

#include <algorithm>
#include <cmath>

#include "spall/error.hpp"

namespace spall {

double SolidLaw::sound_speed() const {
  return std::sqrt((bulk + 4 * shear / 3) / density);
}

double SolidLaw::melting_heat() const {
  if (specific_heat == 0 || melting == 0) return infinity;
  return specific_heat * (melting - room_temperature);
}

double SolidLaw::stiffness(double compression, double pressure, double heat) const {
  const double warmed = specific_heat > 0 ? heat / specific_heat : 0;
  return std::max(0.0, 1 + steinberg.a * pressure / std::cbrt(compression) - steinberg.b * warmed);
}

double SolidLaw::least_flow_stress(double homologous) const {
  if (steinberg.known()) return homologous < 1 ? steinberg.y0 : 0;
  return flow.a * (flow.m >= 1 ? 1 - homologous : 0);
}

double SolidLaw::failure_strain(double triaxiality, double rate, double homologous) const {
  const auto& d = flow.d;
  const double fast = rate > 1 ? 1 + d[3] * std::log(rate) : 1;
  const double notched = d[1] == 0 ? 0 : d[1] * std::exp(d[2] * triaxiality);
  return (d[0] + notched) * fast * (1 + d[4] * homologous);
}

namespace {

// The shares of the volume at which voids begin to join, and at which they have: Tvergaard &
// Needleman, Acta Metallurgica 32 (1984) 157.
constexpr double voids_join = 0.15, voids_part = 0.25;

/// The plastic strain in which voids grow from the one to the other: their radius by 0.283
/// exp(1.5 sigma*) of itself a strain (Rice & Tracey, J. Mech. Phys. Solids 17 (1969) 201).
double joining_strain(double triaxiality) {
  return std::log(voids_part / voids_join) / (3 * 0.283 * std::exp(1.5 * triaxiality));
}

}  // namespace

double SolidLaw::parting_strain(double triaxiality, double flow_stress, double rest_volume) const {
  // The stress falls in proportion to the strain, as in `most_voids` the tension.
  const double by_energy = 2 * fracture_energy / (flow_stress * std::cbrt(rest_volume));
  return std::min(by_energy, joining_strain(triaxiality));
}

double SolidLaw::most_voids(double rest_volume) const {
  if (fracture_energy == 0) return voids_part;
  // A layer of bodies is a band whose opening takes the fracture energy (Bazant & Oh, Matériaux et
  // Constructions 16 (1983) 155): the tension falls in proportion to it.
  return std::min(voids_part, 2 * fracture_energy / (strength * std::cbrt(rest_volume)));
}

double SolidLaw::intact_strength(double pressure) const {
  const double rubbed = rock.friction * std::max(0.0, pressure);
  return std::sqrt(3.0) * (rock.cohesion + rubbed / (1 + rubbed / (rock.limit - rock.cohesion)));
}

double SolidLaw::sliding_strength(double pressure) const {
  if (rock.failed_friction == 0 || pressure <= 0) return 0;
  const double intact = rock.known() ? intact_strength(pressure) : flow.a;
  return std::min(std::sqrt(3.0) * rock.failed_friction * pressure, intact);
}

namespace {

/// Two measurements of one bulk modulus: metals of the library are within 1.2, plastics within 1.6.
/// What is farther apart is a slip of units.
constexpr double most_apart = 3;

/// What solids with Weibull's flaws need, and cannot have.
void check_rock(const SolidLaw& law, const Solid& solid, const std::string& place) {
  const auto both = [&](bool metal, const char* key, const char* other) {
    require(!metal, "{}: {} and {}: a solid breaks by its flaws, or as metals do; leave one out",
            place, key, other);
  };
  both(solid.johnson_cook.fails(), "weibull_k", "johnson_cook_d1 ...");
  both(solid.spall_strength > 0, "weibull_k", "spall_strength");
  both(solid.fracture_energy > 0, "weibull_k", "fracture_energy");
  both(solid.steinberg.known(), "weibull_k", "steinberg_y0");
  if (!law.rock.known()) return;
  both(solid.johnson_cook.a > 0, "lundborg_limit", "johnson_cook_a");
  require(law.rock.limit > law.rock.cohesion,
          "{}: lundborg_limit = {:g} Pa must be more than lundborg_cohesion = {:g} Pa", place,
          law.rock.limit, law.rock.cohesion);
}

/// Slips of units that no other constant contradicts: bounds that no solid comes near.
void check_magnitudes(const Solid& solid, const std::string& place) {
  const auto below = [&](double value, const char* key, double bound, const char* of) {
    require(value <= bound, "{}: {} = {:.3g} is more than {:.3g}, {}: a slip of units", place, key,
            value, bound, of);
  };
  if (!solid.pores.any()) {  // a foam's own modulus may be far below its matter's
    const char* shear = "the shear modulus (Pa)";
    below(solid.johnson_cook.a + solid.johnson_cook.b, "johnson_cook_a + johnson_cook_b",
          solid.shear_modulus(), shear);
    below(solid.yield_strength, "yield_strength", solid.shear_modulus(), shear);
    below(solid.steinberg.ymax, "steinberg_ymax", solid.shear_modulus(), shear);
    below(solid.spall_strength, "spall_strength", solid.bulk_modulus(), "the bulk modulus (Pa)");
  }
  const JohnsonCook& flow = solid.johnson_cook;
  below(flow.n, "johnson_cook_n", 2, "twice what is known of metals");
  below(flow.c, "johnson_cook_c", 1, "ten times what is known of metals");
  below(flow.m, "johnson_cook_m", 10, "several times what is known of metals");
  below(solid.rock.failed_friction, "failed_friction", 10, "several times what is known");
  below(solid.hugoniot_slope, "hugoniot_slope", 4, "twice what is known of solids");
  constexpr double most_gruneisen = 10, least_heat = 10, most_heat = 2e4;
  below(solid.gruneisen, "gruneisen", most_gruneisen, "three times what is known of solids");
  below(solid.specific_heat, "specific_heat", most_heat, "that of hydrogen (J/(kg K))");
  require(solid.specific_heat == 0 || solid.specific_heat >= least_heat,
          "{}: specific_heat = {:.3g} J/(kg K) is less than {:g}, a tenth of that of the heaviest "
          "metals: a slip of units",
          place, solid.specific_heat, least_heat);
  constexpr double most_energy = 1e7;  // J/m^2
  below(solid.fracture_energy, "fracture_energy", most_energy,
        "ten times that of the toughest steels (J/m^2)");
  below(solid.pores.compacted, "compaction_pressure", solid.bulk_modulus(),
        "the bulk modulus of its matter (Pa)");
}

/// Strains at failure that no metal has: other conventions, and per cent.
void check_failure_strain(const JohnsonCook& metal, const std::string& place) {
  if (!metal.fails()) return;
  const auto& [d1, d2, d3, d4, d5] = metal.d;
  constexpr double most = 20, most_by_rate = 1;
  require(d1 + d2 > 0 && d1 + d2 <= most,
          "{}: johnson_cook_d1 + johnson_cook_d2 = {:g}, the strain at failure in shear: more than "
          "0 to {:g} is wanted, several times what is known of metals",
          place, d1 + d2, most);
  require(d2 * d3 <= 0,
          "{}: johnson_cook_d3 = {:g} lets it bear more strain where it is pulled: here it is "
          "exp(D3 triaxiality), so of a D3 of exp(-D3 triaxiality) give the negative",
          place, d3);
  require(std::abs(d4) <= most_by_rate,
          "{}: johnson_cook_d4 = {:g}: -{:g} to {:g} is wanted, tens of times what is known of "
          "metals",
          place, d4, most_by_rate, most_by_rate);
  require(d5 > -1,
          "{}: johnson_cook_d5 = {:g} leaves no strain at failure near the melting point: more "
          "than -1 is wanted",
          place, d5);
}

}  // namespace

SolidLaw solid_law(const Solid& solid, bool yields, const std::string& place) {
  const auto need = [&](double value, const char* key) {
    require(value > 0, "{}: a solid with a stress needs {}", place, key);
  };
  need(solid.sound_speed, "sound_speed");
  need(solid.hugoniot_slope, "hugoniot_slope");
  need(solid.gruneisen, "gruneisen");
  need(solid.youngs_modulus, "youngs_modulus");
  require(solid.poisson_ratio != 0, "{}: a solid with a stress needs poisson_ratio", place);
  const Pores& pores = solid.pores;
  if (pores.any() || pores.elastic > 0 || pores.compacted > 0) {
    require(pores.any(),
            "{}: distension must be more than 1 beside elastic_pressure and "
            "compaction_pressure",
            place);
    need(pores.elastic, "elastic_pressure beside distension");
    need(pores.compacted, "compaction_pressure beside distension");
    require(pores.compacted > pores.elastic,
            "{}: compaction_pressure = {:g} Pa must be more than elastic_pressure = {:g} Pa", place,
            pores.compacted, pores.elastic);
  }
  const double of_sound = solid.bulk_modulus();
  const double of_youngs = solid.youngs_modulus / (3 * (1 - 2 * solid.poisson_ratio));
  // A foam's own modulus may be a hundredth of its matter's.
  require(pores.any() || (of_sound <= most_apart * of_youngs && of_youngs <= most_apart * of_sound),
          "{}: the bulk modulus is {:.3g} Pa by density and sound_speed, and {:.3g} Pa by "
          "youngs_modulus and poisson_ratio: more than {:g} times apart",
          place, of_sound, of_youngs, most_apart);
  check_magnitudes(solid, place);
  check_failure_strain(solid.johnson_cook, place);
  SolidLaw law{.density = solid.bulk_density(),
               .bulk = solid.bulk_modulus() / pores.distension,
               .shear = solid.shear_modulus(),
               .slope = solid.hugoniot_slope,
               .gruneisen = solid.gruneisen,
               .specific_heat = solid.specific_heat,
               .melting = solid.melting_point,
               .yields = yields,
               .flow = solid.johnson_cook,
               .steinberg = solid.steinberg,
               .flaws = solid.weibull,
               .rock = solid.rock,
               .pores = pores,
               .filled = 1 / pores.distension,
               .cold = ColdCurve(solid)};
  if (!yields) {
    law.flaws = {};
    law.steinberg = {};
    return law;
  }
  if (solid.spall_strength > 0) law.strength = solid.spall_strength;
  if (solid.fracture_energy > 0 && !solid.weibull.known())
    need(solid.spall_strength, "spall_strength beside fracture_energy");
  law.fracture_energy = solid.fracture_energy;
  const RockStrength& rock = solid.rock;
  if (rock.known() || rock.cohesion > 0 || rock.friction > 0) {
    need(rock.cohesion, "lundborg_cohesion beside the others of Lundborg");
    need(rock.friction, "lundborg_friction beside the others of Lundborg");
    need(rock.limit, "lundborg_limit beside the others of Lundborg");
  }
  if (rock.known()) need(solid.weibull.k, "weibull_k beside lundborg_limit");
  const SteinbergGuinan& steinberg = solid.steinberg;
  if (steinberg.known()) {
    require(law.flow.a == 0, "{}: johnson_cook_a and steinberg_y0: leave one out", place);
    need(steinberg.ymax, "steinberg_ymax beside steinberg_y0");
    require(steinberg.ymax >= steinberg.y0,
            "{}: steinberg_ymax = {:g} Pa must not be less than steinberg_y0 = {:g} Pa", place,
            steinberg.ymax, steinberg.y0);
    require(!pores.any(), "{}: distension and steinberg_y0: leave one out", place);
    if (steinberg.b > 0) need(solid.specific_heat, "specific_heat beside steinberg_b");
  } else {
    require(steinberg == SteinbergGuinan{},
            "{}: steinberg_ymax, beta, n, a and b need steinberg_y0 beside them", place);
  }
  if (law.flow.a == 0) {
    const JohnsonCook none{.d = law.flow.d};
    require(law.flow == none, "{}: johnson_cook_b, c, n and m need johnson_cook_a beside them",
            place);
    law.flow.a = steinberg.known() ? steinberg.y0 : solid.yield_strength;
  }
  if (!rock.known())
    need(law.flow.a, "johnson_cook_a, steinberg_y0, yield_strength or lundborg_limit");
  if (law.flow.m != 1 || law.flow.fails()) {
    need(solid.specific_heat, "specific_heat");
    need(solid.melting_point, "melting_point");
  }
  require(solid.melting_point == 0 || solid.melting_point > room_temperature,
          "{}: melting_point = {:g} K: solids begin at {:g} K, and would be liquid", place,
          solid.melting_point, room_temperature);
  if (solid.weibull.m > 0) need(solid.weibull.k, "weibull_k beside weibull_m");
  if (law.brittle()) {
    need(solid.weibull.m, "weibull_m beside weibull_k");
    check_rock(law, solid, place);
  }
  return law;
}

}  // namespace spall
