// The law of a case's settings, and the steps and stiffnesses that resolve a collision.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/penalty.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "spall/base/require.hpp"
#include "spall/force/penalty_laws.hpp"
#include "spall/scene/case.hpp"

namespace spall {
namespace {

/// C of h < C sqrt(m/k) (thesis eq. 2.3): some twenty steps a collision.
constexpr double step_limit = 0.15;
/// Of the time in which a surface wave crosses half a sphere.
constexpr double rayleigh_part = 0.2;
/// Of the smaller radius: no deeper may an impact press two bodies into each other.
constexpr double deepest = 0.5;

double contact_modulus(const PenaltySettings& s) {
  return s.young_modulus / (2 * (1 - s.poisson_ratio * s.poisson_ratio));
}

struct Member {
  double id, radius, mass;
};

/// A pair as one body: R, m, and the smaller radius. A wall is a body without bounds.
struct Reduced {
  double radius, mass, smaller;
};
Reduced reduce(const Member& a, const Member& b) {
  return {1 / (1 / a.radius + 1 / b.radius), 1 / (1 / a.mass + 1 / b.mass),
          std::min(a.radius, b.radius)};
}

/// m, that a collision at `speed` presses the pair together.
double deepest_overlap(const PenaltySettings& s, const Reduced& p, double speed) {
  if (s.model == PenaltyModel::hooke) return speed * std::sqrt(p.mass / s.stiffness);
  return std::pow(15 * p.mass * speed * speed / (16 * contact_modulus(s) * std::sqrt(p.radius)),
                  0.4);
}

/// N/m, the largest that a collision at `speed` meets; for jkr at least that of a pair at rest.
double largest_stiffness(const PenaltySettings& s, const Reduced& p, double speed) {
  if (s.model == PenaltyModel::hooke) return s.stiffness;
  const double modulus = contact_modulus(s);
  double a = std::sqrt(p.radius * deepest_overlap(s, p, speed));
  if (s.adhesion == Adhesion::jkr)
    a = std::max(a, std::cbrt(4.5 * pi * s.work_of_adhesion * p.radius * p.radius / modulus));
  return 2 * modulus * a;
}

/// The owned body of all ranks, `without` that id, for which `value` is least. Collective.
template <class Value>
std::optional<Member> least(const Comm& comm, const Bodies& bodies, double without, Value&& value) {
  std::array<double, 4> best{infinity, 0, 0, 0};
  for (Index b = 0; b < bodies.owned; ++b) {
    const Member member{static_cast<double>(bodies.id[b]), bodies.radius[b], bodies.mass[b]};
    if (member.id == without || !std::isfinite(member.mass)) continue;
    const double v = value(member);
    if (v < best[0]) best = {v, member.id, member.radius, member.mass};
  }
  const std::vector<double> all = comm.all_gather(best);
  for (std::size_t k = 0; k < all.size(); k += 4)
    if (all[k] < best[0] || (all[k] == best[0] && all[k + 1] < best[1]))
      best = {all[k], all[k + 1], all[k + 2], all[k + 3]};
  if (!std::isfinite(best[0])) return std::nullopt;
  return Member{best[1], best[2], best[3]};
}

std::string name_of(const Member& m) {
  return std::isfinite(m.radius)
             ? fmt::format("body {:.0f} (radius {:.4g} m, {:.4g} kg)", m.id, m.radius, m.mass)
             : "a wall";
}

}  // namespace

PenaltyLaw penalty_law(const PenaltySettings& s, const ContactLaw& contact) {
  PenaltyLaw law{.model = s.model,
                 .adhesion = s.adhesion,
                 .friction = contact.friction,
                 .rolling_friction = s.rolling_friction,
                 .cohesion = contact.cohesion,
                 .cohesion_range = contact.cohesion > 0 ? contact.cohesion_range : 0,
                 .work_of_adhesion = s.work_of_adhesion};
  const double log_e = std::log(contact.restitution);
  const double beta = -log_e / std::sqrt(pi * pi + log_e * log_e);
  if (s.model == PenaltyModel::hooke) {
    law.normal = s.stiffness;
    law.tangential = s.tangential_ratio * s.stiffness;
    law.damping = 2 * beta;
    law.tangential_damping = std::sqrt(s.tangential_ratio);
  } else {
    law.normal = contact_modulus(s);
    law.tangential = 2 * s.young_modulus / ((2 - s.poisson_ratio) * (1 + s.poisson_ratio));
    law.damping = 2 * std::sqrt(5 / 6.0) * beta;
    law.tangential_damping = std::sqrt(law.tangential / (2 * law.normal));
  }
  return law;
}

double widest_gap(const PenaltyLaw& law, double radius) {
  // Two of the largest bodies have the longest neck: it grows with R^(1/3).
  const double neck =
      law.adhesion == Adhesion::jkr ? -JkrLanes(law).end_overlap(spread(radius / 2))[0] : 0;
  return std::max(neck, law.cohesion_range);
}

void check_penalty_step(const Comm& comm, const Bodies& bodies, const PenaltySettings& s,
                        const ContactLaw& contact, double h, double speed,
                        const std::string& place) {
  require(contact.restitution > 0,
          "{}: penalty contact needs contact.restitution > 0: no damping gives {:g}", place,
          contact.restitution);
  const auto limit = [&](const Member& a, const Member& b) {
    const Reduced pair = reduce(a, b);
    return std::sqrt(pair.mass / largest_stiffness(s, pair, speed));
  };
  const auto twice = [&](const Member& m) { return limit(m, m); };
  const std::optional<Member> first = least(comm, bodies, -1, twice);
  if (!first) return;  // nothing moves
  const Member wall{-1, infinity, infinity};
  const Member second = least(comm, bodies, first->id, [&](const Member& m) {
                          return limit(*first, m);
                        }).value_or(wall);
  const Reduced pair = reduce(*first, second);
  const std::string names = name_of(*first) + " and " + name_of(second);

  // The deepest impact of all: of the heaviest for its size on another.
  const auto depth = [&](const Member& a, const Member& b) {
    const Reduced p = reduce(a, b);
    return -deepest_overlap(s, p, speed) / p.smaller;
  };
  const Member deep = *least(comm, bodies, -1, [&](const Member& m) { return depth(m, m); });
  const Member other =
      least(comm, bodies, deep.id, [&](const Member& m) { return depth(deep, m); }).value_or(wall);
  const double reached = -depth(deep, other) / deepest;
  const bool hooke = s.model == PenaltyModel::hooke;
  require(reached <= 1,
          "{}: {} and {} would pass into each other by {:.3g} of the smaller radius at {:g} m/s, "
          "at most {:g} may be: penalty.{} must be at least {:.3g} {}",
          place, name_of(deep), name_of(other), reached * deepest, speed, deepest,
          hooke ? "stiffness" : "young_modulus",
          hooke ? s.stiffness * reached * reached : s.young_modulus * std::pow(reached, 2.5),
          hooke ? "N/m" : "Pa");

  const double k = largest_stiffness(s, pair, speed);
  const double longest = step_limit * std::sqrt(pair.mass / k);
  require(h <= longest,
          "{}: step = {:g} s is too long for penalty contact: {} meet with m = {:.4g} kg, k = "
          "{:.4g} N/m at {:g} m/s and need at most {:g} sqrt(m/k) = {:.3g} s",
          place, h, names, pair.mass, k, speed, step_limit, longest);
  if (hooke) return;
  // pi r sqrt(rho/G)/(0.1631 nu + 0.8766) (Thornton 2015, eq. 5.14); sqrt(rho r^3) is the body's.
  const double nu = s.poisson_ratio, shear = s.young_modulus / (2 * (1 + nu));
  const auto crossing = [&](const Member& m) {
    return pi * std::sqrt(m.mass / (4 / 3.0 * pi * m.radius * shear)) / (0.1631 * nu + 0.8766);
  };
  const Member slow = *least(comm, bodies, -1, crossing);
  require(h <= rayleigh_part * crossing(slow),
          "{}: step = {:g} s is too long for penalty contact: surface waves cross {} in {:.4g} s "
          "(Rayleigh), of which {:g} may pass in a step: {:.3g} s",
          place, h, name_of(slow), crossing(slow), rayleigh_part, rayleigh_part * crossing(slow));
}

}  // namespace spall
