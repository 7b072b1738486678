// The formulas are those of the lanes; one pair is eight equal ones.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/pair_potential.hpp"

#include <algorithm>
#include <cmath>

#include "potential/laws.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Of sqrt(m/k). A lattice of Z = 12 is stable up to 0.7; compressed fourfold in stiffness by the
/// shock of an impact up to half of it, and there the energy must still be good to 1e-3.
constexpr double step_limit = 0.1;
/// Of sqrt(m/k) over the damping: a body among twelve loses its speed at up to 8 c/m, which its
/// velocity expected in the middle of a step follows up to 8 c h/m = 1.
constexpr double damped_limit = 0.06;
/// Of the distance of rest, flown in a step: the wall of the potential must be seen as it is.
constexpr double longest_flight = 0.1;

/// The first strain at which `measure`, which grows from 0 at first, reaches `value`.
template <class Measure>
double first_strain(double value, Measure&& measure) {
  constexpr double step = 1e-3;
  double low = 0, high = step;
  for (; measure(high) < value; low = high, high += step)
    if (high > 1) return 0;
  for (int halvings = 0; halvings < 50; ++halvings) {
    const double middle = (low + high) / 2;
    (measure(middle) < value ? low : high) = middle;
  }
  return high;
}

PairPotential without_end(PairPotential p) {
  p.breaking_strain = 0;
  p.cutoff = infinity;
  return p;
}

}  // namespace

double stiffness_pressed(const PairPotential& p) {
  const double d = p.distance;
  switch (p.law) {
    case PairLaw::lennard_jones:
    case PairLaw::mie:
    case PairLaw::steinhauser:
      return p.repulsive * p.attractive * p.depth / (d * d);
    case PairLaw::morse:
      return 2 * p.steepness * p.steepness * p.depth / (d * d);
    case PairLaw::program: {
      constexpr double strain = 1e-6;
      return (pair_force(p, (1 - strain) * d) - pair_force(p, d)) / (strain * d);
    }
  }
  return 0;
}

double stiffness(const PairPotential& p) {
  return std::max(stiffness_pressed(p), p.tension);
}

double pair_force(const PairPotential& p, double r) {
  if (r >= p.cutoff) return 0;
  return with_law(p,
                  [&](const auto& law) { return law.force_over_distance(spread(r * r))[0] * r; });
}

double pair_energy(const PairPotential& p, double r) {
  if (r >= p.cutoff) return 0;
  return with_law(p, [&](const auto& law) {
    return law.energy(spread(r * r))[0] - law.energy(spread(p.cutoff * p.cutoff))[0];
  });
}

double strain_of_force(const PairPotential& p, double force) {
  const PairPotential whole = without_end(p);
  return first_strain(force,
                      [&](double strain) { return -pair_force(whole, (1 + strain) * p.distance); });
}

double strain_of_energy(const PairPotential& p, double energy) {
  return with_law(without_end(p), [&](const auto& law) {
    const auto at = [&](double r) { return law.energy(spread(r * r))[0]; };
    return first_strain(
        energy, [&](double strain) { return at((1 + strain) * p.distance) - at(p.distance); });
  });
}

double longest_step(const PairPotential& p, double mass) {
  return std::min(step_limit, damped_limit / p.damping) * std::sqrt(mass / stiffness(p));
}

void check_step(const PairPotential& p, double h, const Encounter& encounter,
                const std::string& place) {
  const auto& [mass, reduced, speed] = encounter;
  const double k = stiffness(p), limit = longest_step(p, mass);
  require(
      h <= limit,
      "{}: step = {:g} s is too long for the pair potential: bodies of {:g} kg bound by {:g} N/m "
      "need at most {:.3g} sqrt(m/k) = {:.3g} s",
      place, h, mass, k, limit / std::sqrt(mass / k), limit);
  require(h * speed <= longest_flight * p.distance,
          "{}: in a step = {:g} s two bodies come {:.3g} m nearer at {:g} m/s; at most {:g} of "
          "pair_potential.distance may be, with a step of {:.3g} s",
          place, h, h * speed, speed, longest_flight, longest_flight * p.distance / speed);
  if (p.law == PairLaw::morse) {
    const double e = std::exp(p.steepness);
    const double wall = p.depth * (e * e - 2 * e), motion = reduced * speed * speed / 2;
    require(
        motion < wall,
        "{}: two bodies of reduced mass {:g} kg pass through each other at {:g} m/s: their energy, "
        "{:.3g} J, is more than the potential at distance 0, {:.3g} J; pair_potential.depth must "
        "be more than {:.3g} J",
        place, reduced, speed, motion, wall, p.depth * motion / wall);
  }
}

}  // namespace spall
