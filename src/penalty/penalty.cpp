// The law of a case's settings, and the steps and stiffnesses that resolve a collision.
// SPDX-License-Identifier: BSD-3-Clause
#include "penalty/penalty.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "penalty/adhesions.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// C of h < C sqrt(m/k) (thesis eq. 2.3): some twenty steps a collision.
constexpr double step_limit = 0.15;
/// Of the time in which a surface wave crosses half a sphere.
constexpr double rayleigh_part = 0.2;
/// Of the smaller radius: no deeper may an impact press two bodies into each other.
constexpr double deepest = 0.5;

/// A body, or a sphere of a clump.
struct Member {
  double id;        ///< of the body
  double radius;    ///< m, of the sphere
  double mass;      ///< kg, of the body
  double material;  ///< a number of one
  double light;     ///< kg: a force on the sphere's centre moves it at once at least as this would
  double alone;     ///< kg, of the sphere without the rest
};

/// A pair as one body: R, m, and the smaller radius. A wall is a body without bounds.
struct Reduced {
  double radius, mass, light, smaller;
};
Reduced reduce(const Member& a, const Member& b) {
  return {1 / (1 / a.radius + 1 / b.radius), 1 / (1 / a.mass + 1 / b.mass),
          1 / (1 / a.light + 1 / b.light), std::min(a.radius, b.radius)};
}

/// What the bodies of a world are made of, each sphere in turn. The world must outlive it.
class MemberList {
 public:
  const Comm& comm;

  explicit MemberList(const World& world)
      : comm(world.comm), bodies_(world.bodies), shapes_(world.shapes) {
    if (shapes_.empty()) shapes_.emplace_back();
    for (const BodyShape& shape : shapes_) {
      std::vector<double>& turning = turning_.emplace_back();
      for (const ShapeSphere& sphere : shape.spheres) {
        // A force n on a sphere turns the body, which moves the sphere by (a x n)^T J^-1 (a x n)
        // along n, beside 1 of the body's own motion.
        Mat3 arm;
        for (int k = 0; k < 3; ++k) arm.col(k) = sphere.at.cross(Vec3::Unit(k));
        const Mat3 moved = arm.transpose() * shape.inertia.cwiseInverse().asDiagonal() * arm;
        turning.push_back(
            Eigen::SelfAdjointEigenSolver<Mat3>(moved, Eigen::EigenvaluesOnly).eigenvalues()[2]);
      }
    }
  }

  /// Calls `f(member)` for all of the owned bodies.
  template <class F>
  void for_each(F&& f) const {
    for (Index b = 0; b < bodies_.owned; ++b) {
      const std::int32_t shape = shapes_.size() > 1 ? bodies_.shape[b] : 0;
      const auto& spheres = shapes_[shape].spheres;
      for (std::size_t k = 0; k < spheres.size(); ++k) {
        const double mass = bodies_.mass[b], r = spheres[k].radius;
        f(Member{.id = static_cast<double>(bodies_.id[b]),
                 .radius = bodies_.radius[b] * r,
                 .mass = mass,
                 .material = static_cast<double>(bodies_.material[b]),
                 .light = mass / (1 + turning_[shape][k]),
                 .alone = mass * (4 * pi / 3 * r * r * r / shapes_[shape].volume)});
      }
    }
  }

 private:
  const Bodies& bodies_;
  BodyShapes shapes_;
  std::vector<std::vector<double>> turning_;  ///< of each sphere of each shape
};

/// m, that a collision at `speed` presses the pair together.
double deepest_overlap(const PenaltyLaw& law, const Reduced& p, double speed) {
  if (law.model == PenaltyModel::hooke) return speed * std::sqrt(p.mass / law.normal);
  return std::pow(15 * p.mass * speed * speed / (16 * law.normal * std::sqrt(p.radius)), 0.4);
}

/// N/m, the largest that a collision at `speed` meets, and at least that of a pair that adhesion
/// has pulled together.
double largest_stiffness(const PenaltyLaw& law, const Reduced& p, double speed) {
  if (law.model == PenaltyModel::hooke) return law.normal;
  const double at_rest = with_adhesion(law.adhesion, [&]<template <class> class Law>() {
    return Law<double>::resting_contact(law, p.radius);
  });
  return 2 * law.normal * std::max(std::sqrt(p.radius * deepest_overlap(law, p, speed)), at_rest);
}

constexpr double any_material = -1;

/// The owned body of all ranks of that material, `without` that id, for which `value` is least;
/// `held`: those that never move, too. Collective.
template <class Value>
std::optional<Member> least(const MemberList& members, double material, double without, bool held,
                            Value&& value) {
  constexpr std::size_t numbers = 7;
  std::array<double, numbers> best{infinity};
  members.for_each([&](const Member& m) {
    if (m.id == without || (!held && !std::isfinite(m.mass))) return;
    if (material != any_material && material != m.material) return;
    const double v = value(m);
    if (v < best[0]) best = {v, m.id, m.radius, m.mass, m.material, m.light, m.alone};
  });
  const std::vector<double> all = members.comm.all_gather(best);
  for (std::size_t k = 0; k < all.size(); k += numbers)
    if (all[k] < best[0] || (all[k] == best[0] && all[k + 1] < best[1]))
      std::copy_n(&all[k], numbers, best.begin());
  if (!std::isfinite(best[0])) return std::nullopt;
  return Member{best[1], best[2], best[3], best[4], best[5], best[6]};
}

struct Meeting {
  Member a, b;
};

/// The two bodies of all for which `value(a, b)` is least, as far as it grows with the size of
/// either: for each pair of materials that is `there` with a law of its own the least of the first,
/// then its worst partner, or a wall, for want of a body of any. Nothing where no body moves.
/// Collective.
template <class Value>
std::optional<Meeting> least_meeting(const MemberList& members, const std::vector<double>& there,
                                     const Walls& walls, Value&& value) {
  const auto is_wall = [&](double material, double of_body) {
    for (std::size_t w = 0; w < walls.size(); ++w)
      if (material == any_material || material == walls.material(w) ||
          (walls.material(w) == same_material && material == of_body))
        return true;
    return false;
  };
  std::optional<Meeting> best;
  for (double a : there)
    for (double b : there) {
      const auto as_partner = [&](Member m) {
        if (b != any_material) m.material = b;
        return m;
      };
      const auto first =
          least(members, a, -1, false, [&](const Member& m) { return value(m, as_partner(m)); });
      if (!first) continue;
      const Member wall = as_partner({-1, infinity, infinity, first->material, infinity, infinity});
      const auto beside = [&](const Member& m) { return value(*first, m); };
      Meeting met{*first, least(members, b, first->id, true, beside).value_or(wall)};
      if (is_wall(b, first->material) && beside(wall) < beside(met.b)) met.b = wall;
      if (!best || value(met.a, met.b) < value(best->a, best->b)) best = met;
    }
  return best;
}

std::string name_of(const Member& m) {
  if (!std::isfinite(m.radius)) return "a wall";
  const bool whole = m.alone == m.mass;
  return fmt::format("{}body {:.0f} ({}radius {:.4g} m, {:.4g} kg)", whole ? "" : "a sphere of ",
                     m.id, whole ? "" : "its ", m.radius, m.mass);
}

/// Of two stiffnesses in series; exact for equal ones.
double in_series(double a, double b) {
  return a / (1 + a / b);
}
double plane_modulus(const Material& m) {
  return m.youngs_modulus / (1 - m.poisson_ratio * m.poisson_ratio);
}
/// 2 G*, if both bodies were of it.
double sliding_modulus(const Material& m) {
  return m.youngs_modulus / ((2 - m.poisson_ratio) * (1 + m.poisson_ratio));
}

/// Places in the materials, of owned bodies and of walls. Collective.
std::vector<int> materials_there(const World& world) {
  if (world.materials.size() <= 1) return {0};
  std::vector<double> seen(world.materials.size(), 0);
  for (Index b = 0; b < world.bodies.owned; ++b) seen[world.bodies.material[b]] = 1;
  const Walls walls = world.walls();
  for (std::size_t w = 0; w < walls.size(); ++w)
    if (walls.material(w) != same_material) seen[walls.material(w)] = 1;
  world.comm.max(seen);
  std::vector<int> there;
  for (std::size_t m = 0; m < seen.size(); ++m)
    if (seen[m] > 0) there.push_back(static_cast<int>(m));
  return there;
}

/// What the stiffness must be for overlaps that are `reached` of the deepest.
std::string stiffer(const World& world, const ByPair<PenaltyLaw>& laws, const Meeting& met,
                    double reached) {
  const int a = static_cast<int>(met.a.material), b = static_cast<int>(met.b.material);
  if (laws.common().model == PenaltyModel::hooke)
    return fmt::format("penalty.stiffness must be at least {:.3g} N/m",
                       laws(a, b).normal * reached * reached);
  const auto of = [&](int m) {
    const Material& material = world.materials[m];
    return fmt::format("materials.{}.youngs_modulus must be at least {:.3g} Pa", material.name,
                       material.youngs_modulus * std::pow(reached, 2.5));
  };
  return a == b ? of(a) : of(a) + " and " + of(b);
}

/// Throws Error where `h` (s) does not resolve surface waves on elastic bodies. Collective.
void check_waves(const World& world, const MemberList& members, PenaltyModel model, double h,
                 const std::string& place) {
  if (model == PenaltyModel::hooke) return;
  // pi r sqrt(rho/G)/(0.1631 nu + 0.8766) (Thornton 2015, eq. 5.14); sqrt(rho r^3) is the body's.
  const auto crossing = [&](const Member& m) {
    const Material& of = world.materials[static_cast<std::size_t>(m.material)];
    const double nu = of.poisson_ratio, shear = of.youngs_modulus / (2 * (1 + nu));
    return pi * std::sqrt(m.alone / (4 / 3.0 * pi * m.radius * shear)) / (0.1631 * nu + 0.8766);
  };
  const std::optional<Member> slow = least(members, any_material, -1, false, crossing);
  if (!slow) return;  // nothing moves
  const double time = crossing(*slow), longest = rayleigh_part * time;
  require(h <= longest,
          "{}: step = {:g} s is too long for penalty contact: surface waves cross {} in {:.4g} s "
          "(Rayleigh), of which {:g} may pass in a step: {:.3g} s",
          place, h, name_of(*slow), time, rayleigh_part, longest);
}

}  // namespace

PenaltyLaw penalty_law(const PenaltySettings& s, const ContactLaw& contact, const Material& a,
                       const Material& b) {
  PenaltyLaw law;
  law.model = s.model;
  law.adhesion = s.adhesion;
  law.friction = contact.friction;
  law.rolling_friction = s.rolling_friction;
  law.cohesion = contact.cohesion;
  law.cohesion_range = contact.cohesion > 0 ? contact.cohesion_range : 0;
  const double log_e = std::log(contact.restitution);
  const double beta = -log_e / std::sqrt(pi * pi + log_e * log_e);
  switch (s.model) {
    case PenaltyModel::hooke:
      law.normal = s.stiffness;
      law.tangential = s.tangential_ratio * s.stiffness;
      law.damping = 2 * beta;
      law.tangential_damping = std::sqrt(s.tangential_ratio);
      break;
    case PenaltyModel::hertz:
      law.normal = in_series(plane_modulus(a), plane_modulus(b));
      law.tangential = 4 * in_series(sliding_modulus(a), sliding_modulus(b));
      law.damping = 2 * std::sqrt(5 / 6.0) * beta;
      law.tangential_damping = std::sqrt(law.tangential / (2 * law.normal));
      break;
  }
  if (s.tangential_damping) law.tangential_damping = *s.tangential_damping;
  with_adhesion(s.adhesion, [&]<template <class> class Law>() {
    Law<double>::derive(s.adhesion_strength, law);
  });
  return law;
}

ByPair<PenaltyLaw> penalty_laws(const World& world, const ByPair<PenaltySettings>& settings) {
  const auto material = [&](int m) {
    return world.materials.empty() ? Material{} : world.materials[m];
  };
  PenaltyLaw none;
  none.model = settings.common().model;
  none.adhesion = settings.common().adhesion;
  ByPair<PenaltyLaw> laws(static_cast<int>(world.materials.size()), none);
  std::optional<PenaltyLaw> first;
  bool one_law = true;
  const std::vector<int> there = materials_there(world);
  for (int a : there)
    for (int b : there) {
      if (b < a) continue;
      const PenaltyLaw law =
          penalty_law(settings(a, b), world.contact(a, b), material(a), material(b));
      if (!first) first = law;
      one_law = one_law && law == *first;
      if (!world.materials.empty()) laws.set(a, b, law);
    }
  return one_law ? first.value_or(none) : laws;
}

double widest_gap(const PenaltyLaw& law, double radius) {
  // The largest body on a wall has the longest neck: it grows with R.
  const double neck = with_adhesion(
      law.adhesion, [&]<template <class> class Law>() { return Law<double>::reach(law, radius); });
  return std::max(neck, law.cohesion_range);
}
double widest_gap(const ByPair<PenaltyLaw>& laws, double radius) {
  double widest = 0;
  laws.for_each([&](const PenaltyLaw& law) { widest = std::max(widest, widest_gap(law, radius)); });
  return widest;
}

bool resists_rolling(const ByPair<PenaltyLaw>& laws) {
  return laws.any(
      [](const PenaltyLaw& law) { return law.friction > 0 && law.rolling_friction > 0; });
}

void check_penalty_step(const World& world, const ByPair<PenaltySettings>& settings, double h,
                        double speed, const std::string& place) {
  const std::vector<int> present = materials_there(world);
  const ByPair<PenaltyLaw> laws = penalty_laws(world, settings);
  const std::vector<double> there = laws.uniform()
                                        ? std::vector<double>{any_material}
                                        : std::vector<double>(present.begin(), present.end());
  const auto law_of = [&](const Member& a, const Member& b) -> const PenaltyLaw& {
    return laws(static_cast<int>(a.material), static_cast<int>(b.material));
  };
  const auto limit = [&](const Member& a, const Member& b) {
    const Reduced pair = reduce(a, b);
    return std::sqrt(pair.light / largest_stiffness(law_of(a, b), pair, speed));
  };
  const MemberList members(world);
  const std::optional<Meeting> tight = least_meeting(members, there, world.walls(), limit);
  // At rest springs of Hertz have no stiffness yet, but a time in which waves cross.
  if (!tight) return check_waves(world, members, laws.common().model, h, place);

  const auto depth = [&](const Member& a, const Member& b) {
    const Reduced p = reduce(a, b);
    return -deepest_overlap(law_of(a, b), p, speed) / p.smaller;
  };
  // The deepest impact of all: of the heaviest for its size on another.
  const Meeting deep = *least_meeting(members, there, world.walls(), depth);
  const double reached = -depth(deep.a, deep.b) / deepest;
  require(reached <= 1,
          "{}: {} and {} would pass into each other by {:.3g} of the smaller radius at {:g} m/s, "
          "at most {:g} may be: {}",
          place, name_of(deep.a), name_of(deep.b), reached * deepest, speed, deepest,
          stiffer(world, laws, deep, reached));

  const Reduced pair = reduce(tight->a, tight->b);
  const double k = largest_stiffness(law_of(tight->a, tight->b), pair, speed);
  const double longest = step_limit * std::sqrt(pair.light / k);
  require(h <= longest,
          "{}: step = {:g} s is too long for penalty contact: {} and {} meet with m = {:.4g} kg, k "
          "= {:.4g} N/m at {:g} m/s and need at most {:g} sqrt(m/k) = {:.3g} s",
          place, h, name_of(tight->a), name_of(tight->b), pair.light, k, speed, step_limit,
          longest);
  check_waves(world, members, laws.common().model, h, place);
}

}  // namespace spall
