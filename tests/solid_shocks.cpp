// A bar of metal flies against a rigid wall: its shock and elastic precursor, against Hugoniots.
// A plate flies against a thicker one, which stays whole or parts.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <cmath>
#include <tuple>
#include <vector>

#include "plate_impact.hpp"
#include "solid/flow_stress.hpp"
#include "solid_worlds.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double d = 1e-3;  // m

struct Bar {
  Solid solid;
  Lab world;
  double length = 0;
  std::vector<int> layer;  ///< of each body at the start: a cell
};

/// A direction of fcc crystals along z; and along x and y, where they repeat after these (of d).
struct Axis {
  const char* name;
  Vec3 x, y, z;
  double repeats_x, repeats_y;
  double planes;  ///< of atoms, across z: their distance, of d
};
const Axis axes[] = {
    {"[100]", {0, 1, 0}, {0, 0, 1}, {1, 0, 0}, std::sqrt(2.0), std::sqrt(2.0), std::sqrt(0.5)},
    {"[110]", {0, 0, 1}, {1, -1, 0}, {1, 1, 0}, std::sqrt(2.0), 1, 0.5},
    {"[111]", {1, -1, 0}, {1, 1, -2}, {1, 1, 1}, 1, std::sqrt(3.0), std::sqrt(2.0 / 3)}};

/// An fcc bar, periodic across, of layers a cell thick. It flies at `speed` (m/s) against a wall at
/// z = 0; or the first layers, if there is a flyer, upwards against the others, which rest.
Bar bar_of(const std::string& material, double speed, int cells, int flyer = 0,
           const Axis& axis = axes[0]) {
  const double a = std::sqrt(2.0) * d;
  constexpr double across = 5.6;  // d, at least: more than twice the reach of a body
  const double wide_x = std::ceil(across / axis.repeats_x) * axis.repeats_x * d;
  const double wide_y = std::ceil(across / axis.repeats_y) * axis.repeats_y * d;
  const Material named = material_of_library(material);
  Bar bar;
  bar.solid = *named.solid;
  bar.length = cells * a;
  Eigen::Matrix3d turn;
  turn << axis.x.normalized().transpose(), axis.y.normalized().transpose(),
      axis.z.normalized().transpose();
  const double little = 1e-6 * d;  // so that round-off puts no plane of atoms on either side
  auto spheres =
      crystal(d, bar.solid.density, turn, bar.length + wide_x + wide_y, [&](const Vec3& x) {
        return x.minCoeff() > -little && x.x() < wide_x - little && x.y() < wide_y - little &&
               x.z() < bar.length - little;
      });
  for (Sphere& s : spheres) {
    const int layer = static_cast<int>((s.position.z() + little) / a);
    const bool flies = layer < flyer;
    const bool rests = flyer > 0 && !flies;
    s.position.z() += d / 2 + (rests ? (1 - axis.planes) * d : 0);
    s.velocity.z() = flies ? speed : rests ? 0 : -speed;
    bar.layer.push_back(layer);
  }
  bar.world = make_world(testing_world(), spheres, {});
  for (Index b = 0; b < bar.world.bodies.owned; ++b)
    bar.world.bodies.group[b] = bar.layer[bar.world.bodies.id[b]] < flyer;
  bar.world.materials = {named};
  bar.world.solid.laws = {solid_law(bar.solid, true, material)};
  if (flyer == 0) bar.world.planes.emplace_back();
  bar.world.period.size = {wide_x, wide_y, 0};
  return bar;
}

/// How far off a figure is stands in what `--gtest_output=xml:FILE` writes.
void tell(const std::string& what, double found, double expected) {
  testing::Test::RecordProperty(what, fmt::format("{:+.1f} %", 100 * (found / expected - 1)));
}

/// Means over layers of a cell at the start: of `f(bodies, row)`.
template <class F>
std::vector<double> of_layers(const Bar& bar, F&& f) {
  const double a = std::sqrt(2.0) * d;
  const auto layers = static_cast<std::size_t>(std::lround(bar.length / a));
  std::vector<double> sums(2 * layers);
  const Bodies& bodies = bar.world.bodies;
  for (Index b = 0; b < bodies.owned; ++b) {
    const auto layer = static_cast<std::size_t>(bar.layer[bodies.id[b]]);
    sums[2 * layer] += 1;
    sums[2 * layer + 1] += f(bodies, b);
  }
  bar.world.comm.sum(sums);
  std::vector<double> means;
  for (std::size_t l = 0; l < layers; ++l) means.push_back(sums[2 * l + 1] / sums[2 * l]);
  return means;
}

TEST(SolidShock, runs_at_the_hugoniot_s_speed_to_its_density) {
  std::vector<std::tuple<const char*, double, Axis>> shocks;
  for (const char* material : {"aluminium_6061_t6", "copper", "steel_4340"}) {
    for (const double u : {200.0, 1000.0, 3350.0}) shocks.emplace_back(material, u, axes[0]);
    for (const Axis& axis : {axes[1], axes[2]}) shocks.emplace_back(material, 1000.0, axis);
  }
  for (const auto& [material, u, axis] : shocks) {
    Bar bar = bar_of(material, u, 26, 0, axis);
    const SolidLaw& law = bar.world.solid.laws[0];
    const double expected = bar.solid.sound_speed + bar.solid.hugoniot_slope * u;
    const double h = 0.7 * longest_step(law, d, 2 * u), a = std::sqrt(2.0) * d;
    std::vector<double> reached(26, 0.0);  // s, by half of the jump
    double time = 0;
    std::vector<double> before(reached.size(), -u);
    // Layers do not hold equal planes of atoms.
    const auto place =
        of_layers(bar, [](const Bodies& bodies, Index b) { return bodies.position[b].z(); });
    while (time < 22 * a / expected) {
      solid_steps(bar.world, h, 2);
      const auto now =
          of_layers(bar, [](const Bodies& bodies, Index b) { return bodies.velocity[b].z(); });
      for (std::size_t l = 0; l < reached.size(); ++l)
        if (reached[l] == 0 && now[l] > -u / 2)
          reached[l] = time + 2 * h * (-u / 2 - before[l]) / (now[l] - before[l]);
      before = now;
      time += 2 * h;
    }
    const double shock = (place[18] - place[8]) / (reached[18] - reached[8]);
    tell(fmt::format("shock of {} at {:g} m/s along {}", material, u, axis.name), shock, expected);
    EXPECT_NEAR(shock, expected, 0.03 * expected) << material << " " << u << " " << axis.name;
    const auto density =
        of_layers(bar, [](const Bodies& bodies, Index b) { return bodies.compression[b]; });
    double mean = 0;
    for (int l = 6; l < 14; ++l) mean += density[l] / 8;
    const double dense = expected / (expected - u);
    tell(fmt::format("density of {} at {:g} m/s along {}", material, u, axis.name), mean, dense);
    EXPECT_NEAR(mean, dense, 0.02 * dense) << material << " " << u << " " << axis.name;
  }
}

// Copper has none that is told from the plastic wave: it hardens from the first strain on.
TEST(SolidShock, has_a_precursor_of_the_elastic_limit) {
  for (const auto& [material, axis] : {std::pair("aluminium_6061_t6", axes[0]),
                                       {"aluminium_6061_t6", axes[1]},
                                       {"aluminium_6061_t6", axes[2]},
                                       {"steel_4340", axes[0]}}) {
    const double u = 100;
    Bar bar = bar_of(material, u, 80, 0, axis);
    const SolidLaw& law = bar.world.solid.laws[0];
    const double h = 0.7 * longest_step(law, d, 2 * u);
    const int steps = static_cast<int>(0.8 * bar.length / law.sound_speed() / h);
    solid_steps(bar.world, h, steps);
    const auto pressed = of_layers(bar, [](const Bodies& bodies, Index b) {
      return bodies.pressure[b] - bodies.direct_stress[b].z();
    });
    // Between the plastic front and the elastic one, which is three layers wide.
    const double time = steps * h, a = std::sqrt(2.0) * d;
    const double plastic = (bar.solid.sound_speed + bar.solid.hugoniot_slope * u) * time / a;
    const double first = law.sound_speed() * time / a;
    double plateau = 0;
    int layers = 0;
    for (int l = static_cast<int>(plastic + 0.6 * (first - plastic)); l < first - 3; ++l, ++layers)
      plateau += pressed[l];
    plateau /= layers;
    // Y of the rate at the precursor's front: of the order of its strain in the time of a spacing.
    const double rate = 0.005 * law.sound_speed() / d;
    const double yield = flow_stress_of(law, 0).at(0, rate).stress;
    const double limit = yield * (law.bulk / (2 * law.shear) + 2.0 / 3);
    tell(fmt::format("precursor of {} along {}", material, axis.name), plateau, limit);
    EXPECT_NEAR(plateau, limit, 0.1 * limit) << material << " " << axis.name;
  }
}

// Where two metals meet, velocity and pressure are those at which their Hugoniots cross, the
// flyer's mirrored at its speed.
TEST(SolidShock, plates_of_two_metals_meet_where_their_hugoniots_cross) {
  constexpr int flyer = 13, cells = 2 * flyer;
  for (const auto& [flies, rests, speed] : {std::tuple("copper", "aluminium_6061_t6", 1000.0),
                                            {"copper", "aluminium_6061_t6", 4000.0},
                                            {"steel_304", "aluminium_6061_t6", 2000.0},
                                            {"aluminium_6061_t6", "steel_4340", 2000.0},
                                            {"copper", "steel_304", 2000.0}}) {
    Bar bar = bar_of(rests, speed, cells, flyer);
    const Material of_flyer = material_of_library(flies);
    bar.world.materials.push_back(of_flyer);
    bar.world.solid.laws.push_back(solid_law(*of_flyer.solid, true, flies));
    Bodies& bodies = bar.world.bodies;
    for (Index b = 0; b < bodies.owned; ++b) {
      if (bar.layer[bodies.id[b]] >= flyer) continue;
      bodies.material[b] = 1;
      bodies.mass[b] *= of_flyer.solid->density / bar.solid.density;
    }
    const InterfaceState expected = impedance_match(*of_flyer.solid, bar.solid, speed);
    const double a = std::sqrt(2.0) * d, h = 0.4 * d / 3 / 8000;
    const double fastest = std::max(shock_speed(bar.solid, expected.velocity),
                                    shock_speed(*of_flyer.solid, speed - expected.velocity));
    solid_steps(bar.world, h, static_cast<int>(0.8 * flyer * a / fastest / h));
    const auto velocity =
        of_layers(bar, [](const Bodies& of, Index b) { return of.velocity[b].z(); });
    const auto pressed = of_layers(
        bar, [](const Bodies& of, Index b) { return of.pressure[b] - of.direct_stress[b].z(); });
    double u = 0, p = 0;
    for (const int l : {-4, -3, -2, 1, 2, 3}) {
      u += velocity[flyer + l] / 6;
      p += pressed[flyer + l] / 6;
    }
    const std::string what = fmt::format("{} on {} at {:g} m/s", flies, rests, speed);
    tell("interface of " + what, u, expected.velocity);
    tell("pressure of " + what, p, expected.pressure);
    EXPECT_NEAR(u, expected.velocity, 0.01 * expected.velocity) << what;
    EXPECT_NEAR(p, expected.pressure, 0.04 * expected.pressure) << what;
  }
}

// Shocks run out and come back as releases: they meet as far from the free surface as the flyer is
// thick. There the tension is what the impact's pressure was. What parts sends a shock to the
// surface, which is then slower by the strength only.
TEST(SolidShock, a_plate_that_is_hit_parts_where_releases_meet) {
  constexpr int flyer = 10, cells = 3 * flyer;
  for (const char* material : {"copper", "aluminium_6061_t6", "steel_304"})
    for (double share : {0.7, 5.0}) {  // of the speed that gives the strength
      Bar bar = bar_of(material, 0, cells, flyer);
      const SolidLaw law = bar.world.solid.laws[0];
      const double pulled = 2 * law.strength / (law.density * law.bulk_speed());
      const double speed = share * pulled;
      bar = bar_of(material, speed, cells, flyer);
      // As bodies of a tenth of a millimetre part: of coarse ones that part at once several layers
      // do, and the surface feels less of it.
      bar.world.solid.laws[0].fracture_energy *= 10;
      const double h = 0.7 * longest_step(law, d, speed), a = std::sqrt(2.0) * d;
      double fastest = 0, slowest = infinity;
      bool back = false;
      for (double time = 0; time < 6 * flyer * a / law.bulk_speed(); time += 4 * h) {
        solid_steps(bar.world, h, 4);
        const double surface = of_layers(bar, [](const Bodies& bodies, Index b) {
                                 return bodies.velocity[b].z();
                               }).back();
        if (back) continue;
        if (surface > fastest) fastest = slowest = surface;
        slowest = std::min(slowest, surface);
        back = fastest - slowest > pulled / 2 && surface > slowest + 0.05 * pulled;
      }
      const auto damage =
          of_layers(bar, [](const Bodies& bodies, Index b) { return bodies.damage[b]; });
      const auto torn = std::max_element(damage.begin(), damage.end());
      if (share < 1) {
        EXPECT_LT(*torn, 0.2) << material;
      } else {
        tell(fmt::format("pull-back of {}", material), fastest - slowest, pulled);
        EXPECT_GT(*torn, 0.95) << material;
        EXPECT_NEAR(static_cast<double>(damage.end() - torn) - 0.5, flyer, 2) << material;
        EXPECT_NEAR(fastest - slowest, pulled, 0.15 * pulled) << material;
      }
    }
}

// Copper stays whole at 190 m/s, whatever peaks of stress the edge of its foot has, even if it tore
// where voids are a twelfth of the volume.
TEST(SolidShock, a_copper_cylinder_that_hits_a_wall_stays_whole) {
  constexpr double radius = 3.81e-3, length = 25.4e-3, spacing = 2 * radius / 8;
  const double volume = std::pow(spacing, 3) / std::sqrt(2.0);
  SolidLaw law = bar_of("copper", 0, 4).world.solid.laws[0];
  for (const auto& [turn, voids] : {std::pair(Vec3(0.5, -0.9, 0.3), 0.25),
                                    {Vec3(0.5, -0.9, 0.3), 1. / 12},
                                    {Vec3(-0.2, 0.4, 1.3), 1. / 12}}) {
    law.fracture_energy = voids / 2 * law.strength * std::cbrt(volume);
    const Eigen::Matrix3d R = Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix();
    std::vector<Sphere> spheres;
    const int n = static_cast<int>(length / spacing) + 2;
    for (int i = -n; i <= n; ++i)
      for (int j = -n; j <= n; ++j)
        for (int k = -n; k <= n; ++k) {
          const Vec3 x = spacing / std::sqrt(2.0) * (R * Vec3(i, j, k));
          if ((i + j + k) % 2 != 0 || std::hypot(x.x(), x.y()) > radius ||
              std::abs(x.z()) > length / 2)
            continue;
          spheres.push_back({.radius = spacing / 2,
                             .mass = law.density * std::pow(spacing, 3) / std::sqrt(2.0),
                             .position = x + Vec3(0, 0, length / 2 + spacing / 2),
                             .velocity = {0, 0, -190}});
        }
    Lab world = make_world(testing_world(), spheres, {});
    world.materials = {{.name = "copper"}};
    world.solid.laws = {law};
    world.planes.emplace_back();
    solid_steps(world, 31e-9, 1000);  // by then the foot is nearly as wide as it gets
    double failed = 0;
    for (Index b = 0; b < world.bodies.owned; ++b) failed += world.bodies.damage[b] >= 1;
    EXPECT_LE(world.comm.sum(failed), 0.001 * spheres.size()) << turn.transpose();
  }
}

}  // namespace
}  // namespace spall
