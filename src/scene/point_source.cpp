// Power laws between the size of the impactor and that of the crater.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/point_source.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "keys/section.hpp"

namespace spall {
namespace {

/// Housen & Holsapple 2011, Table 3, as reprinted by Hirata & Ikeya 2021 (Icarus 364, 114474, Table
/// B1) and Cheng et al. 2020 (Icarus 352, 113989, Table 3). nu = 0.4 and n1 = 1.2 for all.
struct Ground {
  std::string_view name;
  double mu, k, C1, n2, p;
};
constexpr Ground grounds[] = {
    {"rock", 0.55, 0.3, 1.5, 1, 0.5},          {"weakly_cemented_basalt", 0.46, 0.3, 0.18, 1, 0.3},
    {"sand", 0.41, 0.3, 0.55, 1.3, 0.3},       {"glass_spheres", 0.45, 0.5, 1, 1.3, 0.3},
    {"sand_fly_ash", 0.40, 0.3, 0.55, 1, 0.3}, {"perlite_sand", 0.35, 0.32, 0.60, 1, 0.2},
};

enum class CouplingLaw { point_source };
constexpr Choice<CouplingLaw> laws[] = {{"point_source", CouplingLaw::point_source}};
constexpr Choice<LaunchSurface> surfaces[] = {{"plane", LaunchSurface::plane},
                                              {"ellipsoid", LaunchSurface::ellipsoid}};

std::string names_of_grounds() {
  std::string names;
  for (const Ground& ground : grounds)
    names += (names.empty() ? "" : ", ") + std::string(ground.name);
  return names;
}

}  // namespace

void read_point_source(Section& in, PointSource& source) {
  using namespace dimension;
  CouplingLaw law{};
  in.need("law", "the flow is that of Housen & Holsapple 2011, Icarus 211, 856", law, laws);
  in.take("ground", "constants of a line of their Table 3: " + names_of_grounds(), source.ground);
  const auto known = std::ranges::find(grounds, source.ground, &Ground::name);
  const bool is_known = known != std::end(grounds);
  in.check("ground", source.ground.empty() || is_known,
           "is none of " + names_of_grounds() + "; own constants are mu, k, C1");
  if (is_known) {
    source.mu = known->mu;
    source.k = known->k;
    source.C1 = known->C1;
    source.n2 = known->n2;
    source.p = known->p;
  }
  const auto constant = [&](const char* key, const char* meaning, double& value) {
    in.take(key, meaning, value, positive(number));
    in.check("law", value > 0, fmt::format("needs ground, or {}", key));
  };
  // Between momentum and energy: at these ends the sums of one of them have no power any more.
  constant("mu", "exponent of the impactor's speed in the coupling", source.mu);
  in.check("mu", 3 * source.mu > 1 && 3 * source.mu < 2,
           "is not between 1/3 and 2/3, where momentum or energy alone would count");
  constant("k", "of the launched mass, k rho x^3", source.k);
  constant("C1", "of the launch speeds", source.C1);
  in.take("nu", "exponent of the densities' ratio", source.nu, not_negative(number));
  in.take("n1", "nothing is launched within so many radii of the impactor", source.n1,
          positive(number));
  in.take("n2", "the flow ends at so many radii of the crater", source.n2, positive(number));
  in.take("p", "exponent with which it ends there", source.p, not_negative(number));
  in.need("density", "of the ground with its voids", source.density, positive(dimension::density));
  in.take("crater_radius", "left out: no rim slows the flow", source.crater_radius,
          positive(length));
  in.take("angle", "of launches above the surface", source.angle,
          Quantity{dimension::angle, 0, pi / 2});
  in.take("surface", "plane: across the flight; ellipsoid: with the target's moments of mass",
          source.surface, surfaces);
  in.need("hand_over", "distance from the site from which on bodies get the flow", source.hand_over,
          positive(length));
}

LaunchFlow::LaunchFlow(const PointSource& source, double a, double delta, double U)
    : k_rho_(source.k * source.density),
      scale_(source.C1 * U *
             std::pow(std::pow(source.density / delta, source.nu) / a, -1 / source.mu)),
      exponent_(1 / source.mu),
      begin_(source.n1 * a),
      end_(source.crater_radius ? source.n2 * *source.crater_radius : infinity),
      p_(source.p) {}

double LaunchFlow::speed(double x) const {
  return scale_ * std::pow(x, -exponent_) * std::pow(1 - x / end_, p_);
}

double LaunchFlow::column(double x) const {
  return 3 * k_rho_ * x / (2 * pi);
}

Launched LaunchFlow::between(double from, double to) const {
  Launched all;
  if (to <= from) return all;
  // Gauss's rule with five points on parts whose ends differ by a tenth at most, in ln x.
  constexpr std::array<double, 5> node{-0.9061798459386640, -0.5384693101056831, 0,
                                       0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 5> weight{0.2369268850561891, 0.4786286704993665, 0.5688888888888889,
                                         0.4786286704993665, 0.2369268850561891};
  const double length = std::log(to / from);
  const int parts = 1 + static_cast<int>(10 * length);
  for (int part = 0; part < parts; ++part)
    for (std::size_t q = 0; q < node.size(); ++q) {
      const double x = from * std::exp(length * (part + (1 + node[q]) / 2) / parts);
      const double v = speed(x), dm = 3 * k_rho_ * x * x * x * length / parts * weight[q] / 2;
      all.mass += dm;
      all.momentum += dm * v;
      all.energy += dm * v * v / 2;
    }
  return all;
}

}  // namespace spall
