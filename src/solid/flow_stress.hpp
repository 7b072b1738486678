// The flow stress of metals, and how far they flow in a step; of one body or of lanes of bodies.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "solid/lane_bodies.hpp"
#include "solid/lane_root.hpp"

namespace spall {

/// Of the trial stress: what may be left between it and the flow stress.
inline constexpr double flow_error = 1e-10;

/// (a + b (from + by eps)^n, at most `most`)(1 + c ln rate)(1 - T*^m): Johnson and Cook's flow
/// stress, and that of Steinberg and Guinan at the stiffness 1, whose m is 0: they have no last
/// factor.
template <class T>
struct FlowStress {
  T a, b, n, c, m, from, by, most;
  T soft{};  ///< what heat leaves

  /// Pa; its slopes by the strain and by the logarithm of the rate.
  struct Value {
    T stress, by_strain, by_rate;
  };
  void heat_to(const T& homologous) {
    const T none{}, one = none + 1.0;
    const T powered = select(homologous > 0.0, power_of(homologous, m), none);
    soft = select(homologous < 1.0, select(m > 0.0, one - powered, one), none);
  }
  /// With this plastic strain and rate (1/s).
  Value at(const T& strain, const T& rate) const {
    const T none{}, one = none + 1.0;
    const T worked = from + by * strain;
    const T hard = select(worked > 0.0, b * power_of(worked, n), none);
    const T bound = smaller(a + hard, most);
    const T fast = soft * (one + c * logarithm(larger(rate, one)));
    const T slope = select(worked > 0.0, n * by * hard / worked, none);
    return {.stress = bound * fast,
            .by_strain = select(a + hard < most, slope * fast, none),
            .by_rate = select(rate > 1.0, bound * c * soft, none)};
  }
};

inline FlowStress<double> flow_stress_of(const SolidLaw& law) {
  if (const SteinbergGuinan& metal = law.steinberg; metal.known())
    return {.a = 0,
            .b = metal.y0,
            .n = metal.n,
            .c = 0,
            .m = 0,
            .from = 1,
            .by = metal.beta,
            .most = metal.ymax};
  const JohnsonCook& metal = law.flow;
  return {.a = metal.a,
          .b = metal.b,
          .n = metal.n,
          .c = metal.c,
          .m = metal.m,
          .from = 0,
          .by = 1,
          .most = infinity};
}

/// At this homologous temperature.
inline FlowStress<double> flow_stress_of(const SolidLaw& law, double homologous) {
  FlowStress<double> flow = flow_stress_of(law);
  flow.heat_to(homologous);
  return flow;
}
inline FlowStress<PairLanes> flow_stress_of(const LaneLaws& laws, const PairLanes& homologous) {
  const auto of = [&](double FlowStress<double>::*part) {
    return laws.of([part](const SolidLaw& law) { return flow_stress_of(law).*part; });
  };
  using One = FlowStress<double>;
  FlowStress<PairLanes> flow{.a = of(&One::a),
                             .b = of(&One::b),
                             .n = of(&One::n),
                             .c = of(&One::c),
                             .m = of(&One::m),
                             .from = of(&One::from),
                             .by = of(&One::by),
                             .most = of(&One::most)};
  flow.heat_to(homologous);
  return flow;
}

/// The plastic strains that bring von Mises' stresses `trial` (Pa, over the stiffness) back to the
/// flow stress within `h` (s), of bodies that are asked for; 0 of others. `shear`: Pa.
inline PairLanes plastic_increments(PairMask asked, const FlowStress<PairLanes>& flow,
                                    const PairLanes& shear, const PairLanes& trial,
                                    const PairLanes& strain, double h) {
  const PairLanes none{}, one = spread_pairs(1);
  const PairLanes slow = flow.at(strain, none).stress;
  asked &= trial > slow;
  if (!any_lane(asked)) return none;
  // What flow takes from the trial grows with the strain, and so does the flow stress: by strain
  // and rate. Each alone would need no less strain than both. Where the rate does most of it, that
  // is orders of magnitude less than without it.
  const PairLanes excess = trial - slow, by_shear = excess / (3.0 * shear);
  const PairLanes by_rate =
      h * exponential(smaller(excess / (slow * flow.c), logarithm(larger(by_shear / h, one))));
  const PairLanes most =
      select(asked, select(flow.c > 0.0, smaller(by_shear, by_rate), by_shear), none);
  FlowStress<PairLanes>::Value y;
  return root_within(
      asked, none, most, most, flow_error * trial,
      [&](const PairLanes& x) {
        y = flow.at(strain + x, x / h);
        return y.stress + 3.0 * shear * x - trial;
      },
      [&](const PairLanes& x) { return 3.0 * shear + y.by_strain + y.by_rate / x; });
}

}  // namespace spall
