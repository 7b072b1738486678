// The law of Johnson and Cook, and what it needs.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/law.hpp"

#include <algorithm>
#include <cmath>

#include "spall/error.hpp"

namespace spall {

double SolidLaw::sound_speed() const {
  return std::sqrt((bulk + 4 * shear / 3) / density);
}

double SolidLaw::homologous(double heat) const {
  constexpr double room = 298;
  if (specific_heat == 0 || melting == 0) return 0;
  return std::max(0.0, heat / specific_heat / (melting - room));
}

SolidLaw::Flow SolidLaw::flow_stress(double strain, double rate, double homologous) const {
  if (homologous >= 1) return {};
  const double soft = homologous > 0 ? 1 - std::pow(homologous, flow.m) : 1;
  const double hard = flow.b > 0 && strain > 0 ? flow.b * std::pow(strain, flow.n) : 0;
  const bool counts = flow.c > 0 && rate > 1;
  const double fast = counts ? 1 + flow.c * std::log(rate) : 1;
  return {.stress = (flow.a + hard) * fast * soft,
          .by_strain = strain > 0 ? flow.n * hard / strain * fast * soft : 0,
          .by_rate = counts ? (flow.a + hard) * flow.c * soft : 0};
}

double SolidLaw::failure_strain(double triaxiality, double rate, double homologous) const {
  const auto& d = flow.d;
  const double fast = rate > 1 ? 1 + d[3] * std::log(rate) : 1;
  return (d[0] + d[1] * std::exp(d[2] * triaxiality)) * fast * (1 + d[4] * homologous);
}

double SolidLaw::plastic_increment(double trial, double strain, double h, double homologous) const {
  // What is left, trial - 3 G x - Y(strain + x, x/h), falls with x: Newton's steps in a bracket.
  const double slow = flow_stress(strain, 0, homologous).stress;
  if (trial <= slow) return 0;
  double low = 0, high = (trial - slow) / (3 * shear), x = high;
  for (int iteration = 0; iteration < 40; ++iteration) {
    const Flow y = flow_stress(strain + x, x / h, homologous);
    const double left = trial - 3 * shear * x - y.stress;
    if (std::abs(left) <= 1e-7 * y.stress) break;
    (left > 0 ? low : high) = x;
    const double next = x + left / (3 * shear + y.by_strain + y.by_rate / x);
    x = next > low && next < high ? next : (low + high) / 2;
  }
  return x;
}

SolidLaw solid_law(const Solid& solid, bool yields, const std::string& place) {
  const auto need = [&](double value, const char* key) {
    require(value > 0, "{}: a solid with a stress needs {}", place, key);
  };
  need(solid.sound_speed, "sound_speed");
  need(solid.hugoniot_slope, "hugoniot_slope");
  need(solid.gruneisen, "gruneisen");
  need(solid.youngs_modulus, "youngs_modulus");
  SolidLaw law{.density = solid.density,
               .bulk = solid.bulk_modulus(),
               .shear = solid.shear_modulus(),
               .slope = solid.hugoniot_slope,
               .gruneisen = solid.gruneisen,
               .specific_heat = solid.specific_heat,
               .melting = solid.melting_point,
               .melt_energy = solid.melt_energy,
               .yields = yields,
               .flow = solid.johnson_cook,
               .flaws = solid.weibull,
               .cold = ColdCurve(solid)};
  if (!yields) {
    law.flaws = {};
    return law;
  }
  if (solid.spall_strength > 0) law.strength = solid.spall_strength;
  if (law.flow.a == 0) law.flow = {.a = solid.yield_strength, .d = law.flow.d};
  need(law.flow.a, "johnson_cook_a or yield_strength");
  if (law.flow.m != 1 || law.flow.fails()) {
    need(solid.specific_heat, "specific_heat");
    need(solid.melting_point, "melting_point");
  }
  if (solid.weibull.m > 0) need(solid.weibull.k, "weibull_k beside weibull_m");
  if (law.flaws.known()) {
    need(solid.weibull.m, "weibull_m beside weibull_k");
    require(!law.flow.fails() && solid.spall_strength == 0,
            "{}: weibull_k and {}: a solid breaks by its flaws, or as metals do; leave one out",
            place, law.flow.fails() ? "johnson_cook_d1 ..." : "spall_strength");
  }
  return law;
}

}  // namespace spall
