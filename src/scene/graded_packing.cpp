// Boulders graded towards a site: random sequential addition, from the largest to the smallest.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "base/random.hpp"
#include "scene/packing.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double span = 4;     // of the sizes at one place: a boulder, and what fills its gaps
constexpr int sizes_of_2 = 3;  // sizes from one radius to half of it

/// What the grading wants of one size at a distance from the site.
class Wanted {
 public:
  Wanted(const Grading& grading, double coarsest) : grading_(grading), coarsest_(coarsest) {
    for (double s = 1; s > 1 / span * (1 + 1e-9); s *= std::exp2(-1.0 / sizes_of_2))
      all_ += share(s);
  }
  /// Part of the volume around a point that spheres of `radius` are to fill.
  double fill(double distance, double radius) const {
    const double largest =
        std::clamp(grading_.growth * distance, grading_.smallest, coarsest_) * (1 + 1e-9);
    const double s = radius / largest;
    return s <= 1 && s > 1 / span ? grading_.fill * share(s) / all_ : 0;
  }
  /// From the site: beyond it there are none of `radius`.
  double reach(double radius) const {
    return span * radius >= coarsest_ ? infinity : span * radius / grading_.growth;
  }

 private:
  /// N(>s) ~ s^-exponent puts the volume s^(3 - exponent) into each ratio of sizes.
  double share(double s) const { return std::pow(s, 3 - grading_.exponent); }

  Grading grading_;
  double coarsest_, all_ = 0;
};

void read(Section& in, Packing& packing) {
  using namespace dimension;
  Grading grading;
  in.take("site", "of graded: where spheres are smallest", grading.site, any(length));
  in.need("smallest", "of graded: largest radius at the site", grading.smallest, positive(length));
  in.need("growth", "of graded: largest radius over distance from the site", grading.growth,
          positive(number));
  in.take("exponent", "of graded: N(>r) ~ r^-exponent over a factor of 4 below the largest",
          grading.exponent, any(number));
  in.take("fill", "of graded: part of the volume, 0.5 is near the most", grading.fill,
          Quantity{number, 0, 1, false});
  in.check("smallest", grading.smallest <= packing.radius, "is more than radius");
  packing.own = grading;
}

void place(const PackingRequest& request) {
  place_graded(request.volume, request.packing.radius,
               std::any_cast<const Grading&>(request.packing.own), request.seed, request.place,
               [&](const Vec3& center, double radius) {
                 request.put({.center = center, .radius = radius});
               });
}

}  // namespace

extern const PackingType graded_packing;
const PackingType graded_packing{
    .name = "graded", .read = read, .unequal = [](const Packing&) { return true; }, .place = place};

void place_graded(const Volume& volume, double largest, const Grading& grading, std::uint64_t seed,
                  std::string_view asked_at,
                  const std::function<void(const Vec3&, double)>& place) {
  const Wanted wanted(grading, largest);
  const Vec3 half = half_widths_in_world(volume), site = grading.site;
  std::mt19937_64 engine(seed);
  const auto uniform = [&] { return spall::uniform(engine); };

  const std::int64_t expected = 1 << 20;
  SphereSet spheres(volume.center, half, expected);
  for (double r = largest; r > grading.smallest / span; r *= std::exp2(-1.0 / sizes_of_2)) {
    const double reach = wanted.reach(r);
    const Vec3 low = (volume.center - half).cwiseMax(site - Vec3::Constant(reach));
    const Vec3 room = (volume.center + half).cwiseMin(site + Vec3::Constant(reach)) - low;
    if ((room.array() <= 0).any()) continue;
    const auto draw = [&]() -> Vec3 {
      const double x = uniform(), y = uniform(), z = uniform();
      return low + room.cwiseProduct(Vec3(x, y, z));
    };
    const auto fill_at = [&](const Vec3& x) {
      return contains(volume, x) ? wanted.fill((x - site).norm(), r) : 0.0;
    };
    // How many there are to be: the mean of the wanted number density over the box.
    constexpr int samples = 20'000;
    double mean = 0, highest = 0;
    for (int k = 0; k < samples; ++k) {
      const double fill = fill_at(draw());
      mean += fill / samples;
      highest = std::max(highest, fill);
    }
    const double wanted_here = mean * room.prod() / ball_volume(r);
    require(
        wanted_here <= most_spheres,
        "{}: about {:.2g} spheres of radius {:.3g} m are wanted; at most {:.0f} can be: enlarge "
        "packing.smallest",
        asked_at, wanted_here, r, most_spheres);
    auto missing = static_cast<std::int64_t>(std::llround(wanted_here));
    constexpr std::int64_t most_tries_in_vain = 100'000;
    for (std::int64_t in_vain = 0; missing > 0 && in_vain < most_tries_in_vain; ++in_vain) {
      const Vec3 center = draw();
      if (uniform() * highest > fill_at(center)) continue;
      if (spheres.find_overlap(center, r, 0) || depth(volume, center) < r) continue;
      spheres.add(center, r);
      place(center, r);
      --missing;
      in_vain = 0;
    }
  }
}

}  // namespace spall
