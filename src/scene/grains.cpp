// Crystals in Voronoi cells: a lattice of many grains.
// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "scene/packing.hpp"
#include "scene/shape.hpp"

namespace spall {
namespace {

constexpr double slack = 1e-9;  // of a spacing, as lattices have it

/// The middles of grains in the bounding box of the volume, as many as their mean size wants.
std::vector<Vec3> draw_middles(const Volume& volume, double grain, std::mt19937_64& engine) {
  const Vec3 half = half_widths(volume);
  const auto count = std::max<std::int64_t>(1, std::llround(grains_of(volume, grain)));
  std::vector<Vec3> middles;
  for (std::int64_t g = 0; g < count; ++g) {
    const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
    middles.push_back(volume.center +
                      volume.axes * (2 * Vec3(x, y, z) - Vec3::Ones()).cwiseProduct(half));
  }
  return middles;
}

/// Spacings after which a lattice repeats itself along its axes.
Vec3 period_of(LatticeKind kind) {
  switch (kind) {
    case LatticeKind::simple_cubic:
      return {1, 1, 1};
    case LatticeKind::fcc:
      return Vec3::Constant(std::sqrt(2.0));
    case LatticeKind::hcp:
      return {1, std::sqrt(3.0), std::sqrt(8.0 / 3)};
  }
  return Vec3::Zero();
}

}  // namespace

double grains_of(const Volume& volume, double grain) {
  return 8 * half_widths(volume).prod() / ball_volume(grain / 2);
}

void place_grains(LatticeKind kind, const Volume& volume, const Packing& packing,
                  std::uint64_t seed, const std::function<void(const Vec3&)>& place) {
  const double d = spacing_of(packing), grain = *packing.grain;
  std::mt19937_64 engine(seed);
  const std::vector<Vec3> middles = draw_middles(volume, grain, engine);
  const Vec3 half = half_widths(volume);
  SphereGrid grid(volume.center, half_widths_in_world(volume), grain / 2, std::ssize(middles));
  for (const Vec3& middle : middles) grid.add(middle);

  const Vec3 box = half.array() + slack * d;
  const double diagonal = 2 * half.norm();
  Packing crystal = packing;
  std::vector<std::pair<double, Vec3>> rivals;  // of which one may be nearer to a site
  std::vector<Vec3> sites;
  for (const Vec3& middle : middles) {
    crystal.rotation = random_rotation(engine());
    // The lattice does not know where the middle is: else small grains had too many sites or few.
    const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
    const Vec3 shift = d * period_of(kind).cwiseProduct(Vec3(x, y, z) - Vec3::Constant(0.5));
    const Vec3 center = middle + volume.axes * (turn_by(crystal.rotation) * shift);
    // Sites of the cell in a ball about its middle. One cell in a million reaches beyond the first:
    // about a corner so far away a ball with room for 15 middles would have to be without. A cell
    // is convex: where the ball's shell is empty it ends, but for slivers.
    constexpr double first_reach = 1.25;  // grains
    for (double reach = std::min(first_reach * grain, diagonal);; reach *= 1.5) {
      rivals.clear();
      grid.find(middle, 2 * reach, [&](std::int64_t g) {
        const Vec3& other = grid.center(g);
        if (const double apart = (other - middle).norm(); apart > 0)
          rivals.emplace_back(apart, other);
        return false;
      });
      std::ranges::sort(rivals, {}, &std::pair<double, Vec3>::first);
      sites.clear();
      double farthest = 0;
      const Volume ball{
          .shape = Shape::sphere, .center = center, .axes = volume.axes, .radius = reach + 2 * d};
      const auto take = [&](const Vec3& site) {
        const double own = (site - middle).norm();
        for (const auto& [apart, rival] : rivals) {
          if (apart > 2 * own) break;
          if ((site - rival).norm() < own) return;
        }
        const Vec3 inside = volume.axes.transpose() * (site - volume.center);
        if ((inside.cwiseAbs() - box).maxCoeff() > 0) return;
        farthest = std::max(farthest, own);
        if (depth(volume, site) >= -slack * d) sites.push_back(site);
      };
      place_lattice(kind, ball, crystal, take, &volume);
      if (farthest < reach - 2 * d || reach >= diagonal) break;
    }
    for (const Vec3& site : sites) place(site);
  }
}

}  // namespace spall
