// Volumes, lattices and random packings, by brute force and by their exact counts.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/packing.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "base/random.hpp"
#include "scene/shape.hpp"
#include "scene/sizes.hpp"
#include "testing.hpp"

namespace spall {
namespace {

Volume ball(double radius) {
  return {.shape = Shape::sphere, .radius = radius};
}
Volume box(const Vec3& size) {
  return {.shape = Shape::box, .extents = size};
}

std::vector<Vec3> lattice(LatticeKind kind, const Volume& volume, const Packing& packing) {
  std::vector<Vec3> sites;
  place_lattice(kind, volume, packing, [&](const Vec3& site) { sites.push_back(site); });
  return sites;
}

std::vector<Vec3> random_spheres(const Volume& volume, double radius, std::int64_t count,
                                 std::uint64_t seed) {
  std::vector<Vec3> centers;
  place_at_random(
      testing_world(), volume, {}, {count, {radius}}, seed,
      [](const Vec3&, double) { return true; },
      [&](const Vec3& center, double) { centers.push_back(center); });
  return centers;
}

double nearest_distance(const std::vector<Vec3>& centers) {
  double nearest = infinity;
  for (std::size_t a = 0; a < centers.size(); ++a)
    for (std::size_t b = 0; b < a; ++b)
      nearest = std::min(nearest, (centers[a] - centers[b]).norm());
  return nearest;
}

const Mat3 some_turn = Eigen::AngleAxisd(0.7, Vec3(1, -2, 3).normalized()).toRotationMatrix();

const std::vector<Volume> all_shapes = {
    ball(2),
    box({3, 4, 5}),
    {.shape = Shape::box, .center = {1, 0, 2}, .axes = some_turn, .extents = {3, 4, 5}},
    {.shape = Shape::ellipsoid, .axes = some_turn, .extents = {6, 4, 3}},
    {.shape = Shape::ellipsoid, .center = {1, 2, 3}, .extents = {6, 4, 3}},
    {.shape = Shape::hollow_sphere, .center = {0, 1, 0}, .radius = 3, .inner_radius = 1.5},
    {.shape = Shape::cylinder, .extents = {4, 4, 6}},
};

TEST(Shape, volume_is_the_share_of_the_bounding_box_that_lies_inside) {
  std::mt19937_64 engine(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  for (const Volume& volume : all_shapes) {
    const Vec3 half = half_widths(volume);
    const int tries = 100000;
    int inside = 0;
    for (int t = 0; t < tries; ++t) {
      const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
      inside += depth(volume, volume.center + volume.axes * half.cwiseProduct(Vec3(x, y, z))) > 0;
    }
    const double share = volume_of(volume) / (8 * half.prod());
    // Four standard deviations of the count.
    EXPECT_NEAR(inside, share * tries, 4 * std::sqrt(tries * share * (1 - share)) + 1e-9 * tries);
  }
}

TEST(Shape, depth_is_the_distance_to_the_surface) {
  // A sphere as large as the depth just fits: no point of it lies outside, some nearly does.
  std::mt19937_64 engine(2);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> normal;
  std::vector<Vec3> directions(20000);
  for (Vec3& n : directions) {
    const double x = normal(engine), y = normal(engine), z = normal(engine);
    n = Vec3(x, y, z).normalized();
  }
  for (const Volume& volume : all_shapes)
    for (int t = 0; t < 20; ++t) {
      Vec3 offset;
      for (double& x : offset) x = uniform(engine);
      if (t % 4 == 0) offset.z() = 0;  // the ellipsoid's degenerate plane, across its shortest axis
      if (t % 4 == 1) offset.z() = 1e-15;
      const Vec3 p = volume.center + volume.axes * offset.cwiseProduct(half_widths(volume));
      const double d = depth(volume, p);
      if (d <= 0) continue;
      double least = infinity;
      for (const Vec3& n : directions) least = std::min(least, depth(volume, p + d * n));
      EXPECT_GT(least, -1e-9) << static_cast<int>(volume.shape);
      EXPECT_LT(least, 0.01 * d) << static_cast<int>(volume.shape);
    }
}

TEST(Shape, does_not_contain_its_surface) {
  for (const Volume& volume : all_shapes) {
    const Vec3 up = volume.axes.col(2), top = volume.center + half_widths(volume).z() * up;
    const double outside = volume.axes.isIdentity(0) ? 0 : 1e-12;  // turning rounds
    EXPECT_FALSE(contains(volume, top + outside * up)) << static_cast<int>(volume.shape);
    EXPECT_TRUE(contains(volume, top - 0.5 * up)) << static_cast<int>(volume.shape);
  }
}

TEST(Shape, of_a_turned_box_reaches_as_far_as_its_corners) {
  const Volume turned{.shape = Shape::box, .axes = some_turn, .extents = {3, 4, 5}};
  Eigen::AlignedBox3d corners;
  for (int k = 0; k < 8; ++k)
    corners.extend(some_turn * Vec3(k & 1 ? 1.5 : -1.5, k & 2 ? 2 : -2, k & 4 ? 2.5 : -2.5));
  EXPECT_LE((half_widths_in_world(turned) - corners.max()).norm(), 1e-14);
  EXPECT_EQ(half_widths(turned), Vec3(1.5, 2, 2.5));
}

/// What fills a turned volume is what fills the same volume unturned, turned.
void expect_turned(const std::vector<Vec3>& turned, const std::vector<Vec3>& upright,
                   const Vec3& center) {
  ASSERT_EQ(turned.size(), upright.size());
  for (std::size_t k = 0; k < turned.size(); ++k)
    EXPECT_LE((turned[k] - center - some_turn * (upright[k] - center)).norm(), 1e-12);
}

std::vector<Vec3> polycrystal(const Volume& volume, const Packing& packing, std::uint64_t seed) {
  std::vector<Vec3> sites;
  place_grains(LatticeKind::fcc, volume, packing, seed,
               [&](const Vec3& site) { sites.push_back(site); });
  return sites;
}

TEST(Packing, of_grains_fills_its_volume_with_crystals) {
  const double side = 20;  // spacings
  const Volume volume = box({side, side, side});
  const Packing packing{.radius = 0.5, .grain = 6};
  for (const std::uint64_t seed : {1, 2, 3}) {
    const std::vector<Vec3> sites = polycrystal(volume, packing, seed);
    EXPECT_NEAR(static_cast<double>(sites.size()), std::sqrt(2) * std::pow(side, 3),
                0.015 * std::sqrt(2) * std::pow(side, 3));
    SphereGrid grid(Vec3::Zero(), Vec3::Constant(side / 2), 0.5, std::ssize(sites));
    for (const Vec3& site : sites) grid.add(site);
    // No place is without a site: in fcc the farthest is 1/sqrt 2 away, between grains about 1.
    std::mt19937_64 engine(seed);
    for (int t = 0; t < 20000; ++t) {
      const double x = uniform(engine), y = uniform(engine), z = uniform(engine);
      const Vec3 point = (side - 2) * (Vec3(x, y, z) - Vec3::Constant(0.5));
      EXPECT_GE(grid.find_nearer(point, 1.4), 0) << point.transpose();
    }
    // Within a grain a site has twelve neighbours; at six spacings some quarter of them is.
    int inner = 0, whole = 0;
    for (std::size_t k = 0; k < sites.size(); k += 10) {
      if (sites[k].cwiseAbs().maxCoeff() > side / 2 - 1.1) continue;
      const auto touching = std::ranges::count_if(
          sites, [&](const Vec3& other) { return std::abs((other - sites[k]).norm() - 1) < 1e-9; });
      EXPECT_LE(touching, 12);
      whole += touching == 12;
      ++inner;
    }
    EXPECT_GT(whole, 0.2 * inner);
    EXPECT_LT(whole, 0.4 * inner);
  }
  EXPECT_NE(polycrystal(volume, packing, 1), polycrystal(volume, packing, 2));
}

TEST(Packing, of_grains_has_as_many_bodies_as_its_volume_has_room_for) {
  if (testing_world().size > 1) return;  // one rank does it
  for (const double grain : {2.0, 3.0, 5.0}) {
    const auto sites = polycrystal(box({24, 24, 24}), {.radius = 0.5, .grain = grain}, 4);
    const double expected = std::sqrt(2) * std::pow(24, 3);
    EXPECT_NEAR(static_cast<double>(sites.size()), expected, 0.015 * expected) << grain;
  }
  // Far larger than the volume: one crystal, and no longer to place.
  const auto sheet = polycrystal(box({100, 100, 3}), {.radius = 0.5, .grain = 1e9}, 4);
  EXPECT_NEAR(static_cast<double>(sheet.size()), std::sqrt(2) * 3e4, 0.03 * std::sqrt(2) * 3e4);
}

TEST(Packing, of_one_grain_is_a_crystal) {
  // The cell reaches over the whole box: a bound on cells must not cut it.
  const Volume volume = box({30, 4, 4});
  const std::vector<Vec3> sites = polycrystal(volume, {.radius = 0.5, .grain = 9.7}, 7);
  EXPECT_NEAR(static_cast<double>(sites.size()), std::sqrt(2) * 30 * 16, 0.05 * 30 * 16);
  std::vector<double> off;
  for (const Vec3& site : sites) off.push_back((site - sites.front()).squaredNorm());
  for (const double square : off) EXPECT_NEAR(square, std::round(square), 1e-9);
}

TEST(Packing, of_a_turned_volume_turns_along) {
  Volume upright = box({7, 9, 3});
  upright.center = {1, -2, 3};
  Volume turned = upright;
  turned.axes = some_turn;
  for (const LatticeKind kind : {LatticeKind::simple_cubic, LatticeKind::fcc, LatticeKind::hcp})
    for (const Vec3& rotation : {Vec3(0, 0, 0), Vec3(0.3, -0.5, 0.2)}) {
      const Packing packing{.radius = 0.49, .rotation = rotation};
      expect_turned(lattice(kind, turned, packing), lattice(kind, upright, packing),
                    upright.center);
    }
  expect_turned(random_spheres(turned, 0.4, 200, 7), random_spheres(upright, 0.4, 200, 7),
                upright.center);
  const Packing grains{.radius = 0.4, .grain = 3};
  expect_turned(polycrystal(turned, grains, 7), polycrystal(upright, grains, 7), upright.center);
}

TEST(Lattice, inner_sites_have_the_neighbours_of_their_kind_and_no_nearer_ones) {
  for (const auto& [kind, expected] :
       {std::pair{LatticeKind::simple_cubic, 6}, {LatticeKind::fcc, 12}, {LatticeKind::hcp, 12}})
    for (const Vec3& rotation : {Vec3(0, 0, 0), Vec3(0.3, -0.5, 0.2)}) {
      const auto sites = lattice(kind, ball(4), {.radius = 0.5, .rotation = rotation});
      EXPECT_GT(nearest_distance(sites), 1 - 1e-12);
      for (const Vec3& site : sites) {
        if (site.norm() > 2.9) continue;
        const auto touching = std::ranges::count_if(
            sites, [&](const Vec3& other) { return std::abs((other - site).norm() - 1) < 1e-9; });
        EXPECT_EQ(touching, expected);
      }
    }
}

TEST(Lattice, mass_goes_with_volume) {
  const double close = pi / (3 * std::sqrt(2.0));
  for (const auto& [kind, density] : {std::pair{LatticeKind::simple_cubic, pi / 6},
                                      {LatticeKind::fcc, close},
                                      {LatticeKind::hcp, close}}) {
    const Volume volume = ball(20);
    const auto sites = lattice(kind, volume, {.radius = 0.5});
    // The surface holds ~5,000 of the ~34,000 cells; their rounding errors are random.
    EXPECT_NEAR(static_cast<double>(sites.size()) * pi / 6 / volume_of(volume), density,
                0.005 * density);
  }
}

TEST(Lattice, a_box_n_diameters_wide_holds_n_layers_flush_with_its_faces) {
  const double d = 0.23686e-3;
  const Volume plate = box({3 * d, 8 * d, 9 * d});
  const auto sites = lattice(LatticeKind::simple_cubic, plate, {.radius = d / 2});
  EXPECT_EQ(sites.size(), 3u * 8 * 9);
  for (const Vec3& site : sites) EXPECT_GT(depth(plate, site), d / 2 * (1 - 1e-9));
}

TEST(Lattice, the_thesis_projectile_has_the_reference_engines_count) {
  // 40 particles across; with the plate of 17 x 204 x 204 the 741,024 bodies of that engine's grid.
  const auto sites = lattice(LatticeKind::simple_cubic, ball(20), {.radius = 0.5});
  EXPECT_EQ(sites.size(), 741024u - 17 * 204 * 204);
}

TEST(RandomPacking, spheres_lie_wholly_inside_and_clear_of_each_other) {
  for (const Volume& volume : all_shapes) {
    const double radius = 0.2;
    const auto count = static_cast<std::int64_t>(0.2 * volume_of(volume) / (ball_volume(radius)));
    const auto centers = random_spheres(volume, radius, count, 3);
    EXPECT_EQ(std::ssize(centers), count);
    EXPECT_GE(nearest_distance(centers), 2 * radius);
    for (const Vec3& center : centers) EXPECT_GE(depth(volume, center), radius);
  }
}

TEST(RandomPacking, fills_evenly) {
  const auto centers = random_spheres(ball(1), 0.02, 8000, 5);
  const auto within = std::ranges::count_if(centers, [](const Vec3& c) { return c.norm() < 0.49; });
  // Half the radius that centres may have: an eighth of them, four standard deviations.
  EXPECT_NEAR(static_cast<double>(within), 1000, 4 * std::sqrt(1000.0));
  Vec3 mean = Vec3::Zero();
  for (const Vec3& center : centers) mean += center / 8000;
  EXPECT_LT(mean.norm(), 4 * std::sqrt(0.6 / 8000));
}

TEST(RandomPacking, ends_when_places_run_out) {
  const auto centers = random_spheres(ball(1), 0.3, 20, 1);
  EXPECT_GT(centers.size(), 6u);
  EXPECT_LT(centers.size(), 14u);  // 14 would be 0.38 of the volume, which has walls besides
  EXPECT_TRUE(random_spheres(ball(1), 1.1, 1, 1).empty());
}

TEST(RandomPacking, a_scene_in_other_units_is_the_same_to_the_bit) {
  const auto one = random_spheres(ball(1), 0.1, 200, 9);
  const auto other = random_spheres(ball(0x1p20), 0.1 * 0x1p20, 200, 9);
  for (std::size_t k = 0; k < one.size(); ++k) EXPECT_EQ(Vec3(one[k] * 0x1p20), other[k]);
}

TEST(RandomPacking, that_cannot_fit_is_known_before_it_is_tried) {
  const auto most = [](const Volume& volume, double radius) {
    return most_filled_at_random(volume, {1, {radius}});
  };
  // What did find a place is never more; in small volumes walls make a difference.
  for (double radius : {0.1, 0.3, 1.0}) {
    const auto centers = random_spheres(ball(1), radius, 10000, 2);
    EXPECT_LT(static_cast<double>(centers.size()) * std::pow(radius, 3), most(ball(1), radius));
  }
  // A row of spheres that fill a tube as a random line: Renyi's 0.7476 of its length.
  const Volume tube{.shape = Shape::cylinder, .extents = {2, 2, 2000}};
  EXPECT_GT(most(tube, 1 - 1e-9), 0.7476 * 2 / 3);
  // In large volumes it is the known end of such packings.
  EXPECT_NEAR(most(ball(1), 0.002), 0.384, 0.006);
}

double largest_gap_between(std::vector<double> drawn, const std::function<double(double)>& below) {
  std::ranges::sort(drawn);
  double gap = 0;
  const auto count = static_cast<double>(drawn.size());
  for (std::size_t k = 0; k < drawn.size(); ++k)
    gap = std::max({gap, std::abs(below(drawn[k]) - static_cast<double>(k) / count),
                    std::abs(below(drawn[k]) - static_cast<double>(k + 1) / count)});
  return gap;
}

// Kolmogorov and Smirnov: one sample in a thousand has a larger gap.
constexpr double ks_1_in_1000 = 1.95;
constexpr std::int64_t many = 20000;

TEST(Sizes, of_a_power_law_lie_between_their_limits_as_it_says) {
  for (double exponent : {-1.0, 0.0, 2.5, 3.0}) {
    const Sizes sizes{.law = SizeLaw::power, .smallest = 0.5, .largest = 4, .exponent = exponent};
    const auto radii = draw_radii(sizes, many, 7);
    EXPECT_TRUE(std::ranges::is_sorted(radii, std::greater()));
    EXPECT_LE(radii.front(), 4);
    EXPECT_GE(radii.back(), 0.5);
    const double gap = largest_gap_between(radii, [&](double r) {
      const double a = exponent;
      if (a == 0) return std::log(r / 0.5) / std::log(8.0);
      return (std::pow(0.5, -a) - std::pow(r, -a)) / (std::pow(0.5, -a) - std::pow(4.0, -a));
    });
    EXPECT_LT(gap, ks_1_in_1000 / std::sqrt(many)) << exponent;
  }
}

TEST(Sizes, of_a_lognormal_law_are_those_between_its_limits) {
  const Sizes sizes{
      .law = SizeLaw::lognormal, .smallest = 0.8, .largest = 3, .median = 1, .spread = 0.4};
  const auto normal_below = [](double z) { return std::erfc(-z / std::sqrt(2.0)) / 2; };
  const auto below = [&](double r) { return normal_below(std::log(r) / 0.4); };
  const auto radii = draw_radii(sizes, many, 3);
  EXPECT_LE(radii.front(), 3);
  EXPECT_GE(radii.back(), 0.8);
  const double gap = largest_gap_between(
      radii, [&](double r) { return (below(r) - below(0.8)) / (below(3) - below(0.8)); });
  EXPECT_LT(gap, ks_1_in_1000 / std::sqrt(many));
}

TEST(Sizes, of_a_list_are_as_many_as_their_shares) {
  const Sizes sizes{.law = SizeLaw::list, .radii = {1, 3, 2}, .shares = {0.7, 0.1, 0.2}};
  EXPECT_EQ(draw_radii(sizes, 10, 1), (std::vector<double>{3, 2, 2, 1, 1, 1, 1, 1, 1, 1}));
  const auto eleven = draw_radii(sizes, 11, 1);  // 7.7, 1.1, 2.2: the first is rounded up
  EXPECT_EQ(std::ranges::count(eleven, 1.0), 8);
  EXPECT_EQ(std::ranges::count(eleven, 2.0), 2);
}

TEST(Sizes, in_other_units_are_the_same_to_the_bit) {
  for (SizeLaw law : {SizeLaw::power, SizeLaw::lognormal}) {
    Sizes sizes{.law = law, .smallest = 0.5, .largest = 4, .exponent = 3, .median = 1, .spread = 1};
    const auto one = draw_radii(sizes, 100, 7);
    for (double* length : {&sizes.smallest, &sizes.largest, &sizes.median}) *length *= 0x1p-20;
    const auto other = draw_radii(sizes, 100, 7);
    for (std::size_t k = 0; k < one.size(); ++k) EXPECT_EQ(one[k] * 0x1p-20, other[k]);
  }
}

struct Boulder {
  Vec3 center;
  double radius;
};

std::vector<Boulder> graded_boulders(const Volume& volume, double largest, const Grading& grading) {
  std::vector<Boulder> boulders;
  place_graded(volume, largest, grading, 5, "", [&](const Vec3& center, double radius) {
    boulders.push_back({center, radius});
  });
  return boulders;
}

TEST(RandomPacking, of_unequal_spheres_holds_all_of_them_clear_of_each_other) {
  const Sizes sizes{.law = SizeLaw::power, .smallest = 0.1, .largest = 1, .exponent = 2};
  const std::vector<double> radii = draw_radii(sizes, 700, 4);
  const Volume volume = box({10, 8, 6});
  std::vector<Boulder> boulders;
  place_at_random(
      testing_world(), volume, {}, {700, radii}, 5,
      [](const Vec3& x, double r) { return x.z() > r; },
      [&](const Vec3& center, double radius) {
        boulders.push_back({center, radius});
      });
  ASSERT_EQ(boulders.size(), radii.size());
  for (std::size_t a = 0; a < boulders.size(); ++a) {
    const auto& [x, r] = boulders[a];
    EXPECT_EQ(r, radii[a]);
    EXPECT_GE(depth(volume, x), r);
    EXPECT_GT(x.z(), r);
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_GE((x - boulders[b].center).norm(), (r + boulders[b].radius) * (1 - 1e-12));
  }
}

/// Tried one after another, each against all before.
std::vector<Boulder> added_one_by_one(const Volume& volume, const Period& period,
                                      const Radii& radii, std::uint64_t seed,
                                      const std::function<bool(const Vec3&, double)>& is_free) {
  std::mt19937_64 engine(seed);
  std::vector<Boulder> boulders;
  const auto coordinate = [&] { return 2 * uniform(engine) - 1; };
  while (std::ssize(boulders) < radii.count) {
    const double r = radii[std::ssize(boulders)];
    const double x = coordinate(), y = coordinate(), z = coordinate();
    const Vec3 half = half_widths(volume) - Vec3::Constant(r);
    const Vec3 center = volume.center + half.cwiseProduct(Vec3(x, y, z));
    const auto meets = [&](const Boulder& other) {
      return (period.nearest(other.center, center) - center).norm() < r + other.radius;
    };
    if (depth(volume, center) >= r && is_free(center, r) && std::ranges::none_of(boulders, meets))
      boulders.push_back({center, r});
  }
  return boulders;
}

TEST(RandomPacking, is_that_of_one_sphere_after_another_on_any_ranks) {
  struct Scene {
    Volume volume;
    Radii radii;
    Period period = {};
    double floor = -infinity;  // m, along z
  };
  const auto drawn = [](const Sizes& sizes, std::int64_t count) {
    return Radii{count, draw_radii(sizes, count, 4)};
  };
  const Sizes power{.law = SizeLaw::power, .smallest = 0.2, .largest = 1, .exponent = 2};
  const Sizes narrow{.law = SizeLaw::power, .smallest = 0.3, .largest = 1, .exponent = 2};
  const Sizes lognormal{
      .law = SizeLaw::lognormal, .smallest = 0.3, .largest = 1, .median = 0.7, .spread = 0.5};
  const Sizes list{.law = SizeLaw::list, .radii = {1, 0.3}, .shares = {0.1, 0.9}};
  // Less than the volumes: spheres meet images of each other.
  const Period along_x_and_z{.low = {-6, 0, -5}, .size = {12, 0, 10}};
  const Scene scenes[] = {
      {.volume = box({14, 13, 15}), .radii = {1500, {0.45}}},  // 0.21 of it
      {.volume = box({9, 8, 10}), .radii = {580, {0.45}}},     // 0.31: near where places run out
      {.volume = {.shape = Shape::sphere, .center = {3, 2, 1}, .radius = 8},
       .radii = {1000, {0.5}},
       .floor = -2},
      {.volume = {.shape = Shape::cylinder, .extents = {3, 3, 90}}, .radii = {300, {0.5}}},
      {.volume = box({15, 8, 12}), .radii = {400, {0.5}}, .period = along_x_and_z},
      {.volume = box({14, 13, 15}), .radii = drawn(power, 2000), .floor = -7},
      {.volume = ball(7), .radii = drawn(lognormal, 300)},
      {.volume = box({15, 8, 12}), .radii = drawn(narrow, 600), .period = along_x_and_z},
      {.volume = box({9, 9, 9}), .radii = drawn(list, 300)},
  };
  for (const Scene& scene : scenes) {
    const auto above = [&](const Vec3& x, double r) { return x.z() - r > scene.floor; };
    const auto expected = added_one_by_one(scene.volume, scene.period, scene.radii, 7, above);
    std::vector<Boulder> boulders;
    place_at_random(testing_world(), scene.volume, scene.period, scene.radii, 7, above,
                    [&](const Vec3& center, double radius) {
                      boulders.push_back({center, radius});
                    });
    ASSERT_EQ(boulders.size(), expected.size());
    for (std::size_t k = 0; k < expected.size(); ++k) {
      ASSERT_EQ(boulders[k].center, expected[k].center) << k;
      ASSERT_EQ(boulders[k].radius, expected[k].radius) << k;
    }
  }
}

TEST(GradedPacking, is_fine_at_its_site_coarse_elsewhere_and_clear_of_itself) {
  if (testing_world().size > 1) return;  // one rank does it
  const Volume volume{.shape = Shape::ellipsoid, .extents = {60, 50, 40}};
  const Grading grading{.site = {-30, 0, 0}, .smallest = 0.8, .growth = 0.2};
  const auto boulders = graded_boulders(volume, 4, grading);
  double solid = 0;
  for (std::size_t a = 0; a < boulders.size(); ++a) {
    const auto& [x, r] = boulders[a];
    const double largest = std::clamp(0.2 * (x - grading.site).norm(), 0.8, 4.0) * (1 + 1e-9);
    EXPECT_GE(depth(volume, x), r);
    EXPECT_LE(r, largest);
    EXPECT_GT(r, largest / 4 * (1 - 1e-8));
    for (std::size_t b = 0; b < a; ++b)
      EXPECT_GE((x - boulders[b].center).norm(), (r + boulders[b].radius) * (1 - 1e-12));
    solid += ball_volume(r);
  }
  EXPECT_NEAR(solid / volume_of(volume), 0.5, 0.05);  // boulders keep whole from the surface
  EXPECT_EQ(graded_boulders(volume, 4, grading).back().center, boulders.back().center);
}

TEST(GradedPacking, of_one_largest_size_follows_its_power_law) {
  if (testing_world().size > 1) return;  // one rank does it
  const auto boulders = graded_boulders(box(Vec3::Constant(36)), 1,
                                        {.smallest = 1, .growth = 1, .exponent = 2.5, .fill = 0.4});
  const auto above = [&](double r) {
    return static_cast<double>(std::ranges::count_if(
        boulders, [&](const Boulder& one) { return one.radius > r * (1 - 1e-9); }));
  };
  // Six sizes lie in a factor of 4; each has 2^(2.5/3) times as many as the next larger one.
  const double ratio = std::exp2(2.5 / 3);
  for (int k = 1; k < 6; ++k)
    EXPECT_NEAR(above(std::exp2(-k / 3.0)) / above(1), (std::pow(ratio, k + 1) - 1) / (ratio - 1),
                0.1 * std::pow(ratio, k));
}

TEST(SphereSet, finds_overlaps_that_brute_force_finds) {
  std::mt19937_64 engine(3);
  std::uniform_real_distribution<double> uniform(-1, 1), power(-7, -1);
  const auto sphere = [&]() -> Boulder {
    return {{uniform(engine), uniform(engine), uniform(engine)}, std::exp2(power(engine))};
  };
  SphereSet set(Vec3::Zero(), Vec3::Constant(0.8), 1000);  // some lie beyond its box
  std::vector<Boulder> boulders;
  for (int k = 0; k < 300; ++k) {
    boulders.push_back(sphere());
    set.add(boulders.back().center, boulders.back().radius);
  }
  int found = 0;
  for (int k = 0; k < 3000; ++k) {
    const Boulder probe = sphere();
    const auto depth_in = [&](const Boulder& other) {
      return probe.radius + other.radius - (probe.center - other.center).norm();
    };
    const bool any = std::ranges::any_of(boulders, [&](const Boulder& other) {
      return depth_in(other) > 0.1 * std::min(probe.radius, other.radius);
    });
    const auto hit = set.find_overlap(probe.center, probe.radius, 0.1);
    ASSERT_EQ(hit.has_value(), any);
    if (hit) {
      EXPECT_NEAR(hit->depth, depth_in(boulders[hit->sphere]), 1e-15);
      ++found;
    }
  }
  EXPECT_GT(found, 300);
  EXPECT_LT(found, 2700);
}

TEST(SphereGrid, finds_what_brute_force_finds) {
  const auto centers = random_spheres(ball(1), 0.05, 500, 4);
  SphereGrid grid(Vec3::Zero(), Vec3::Constant(0.8), 0.05, 500);  // some lie beyond its box
  for (const Vec3& center : centers) grid.add(center);
  const auto points = random_spheres(ball(1.5), 0.01, 2000, 6);
  for (const Vec3& point : points)
    for (double distance : {0.06, 0.3}) {
      const bool near = std::ranges::any_of(
          centers, [&](const Vec3& center) { return (center - point).norm() < distance; });
      EXPECT_EQ(grid.find_nearer(point, distance) >= 0, near);
    }
}

}  // namespace
}  // namespace spall
