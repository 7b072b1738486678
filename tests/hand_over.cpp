// What point-source theory launches, and what of it bodies get: closed forms, sums that close.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/hand_over.hpp"

#include <toml++/toml.h>

#include <cmath>
#include <filesystem>
#include <random>
#include <sstream>

#include "output/restart.hpp"
#include "run_series.hpp"
#include "testing.hpp"
#include "worlds.hpp"

namespace spall {
namespace {

/// Sand; its flow ends 12 m from the site.
PointSource sand() {
  return {.mu = 0.41,
          .C1 = 0.55,
          .k = 0.3,
          .n2 = 1.2,
          .density = 1500,
          .crater_radius = 10,
          .hand_over = 2};
}

Impactor kilograms_of_500() {
  Impactor impactor{.mass = 500, .radius = 0.5, .speed = 6000, .direction = -Vec3::UnitZ()};
  impactor.coupling = sand();
  return impactor;
}

TEST(LaunchFlow, sums_are_the_closed_forms_of_power_laws) {
  PointSource source = sand();
  source.crater_radius.reset();
  const double a = 0.5, delta = 1000, U = 6000;
  const LaunchFlow flow(source, a, delta, U);
  EXPECT_NEAR(flow.begin(), 0.6, 1e-15);
  EXPECT_EQ(flow.end(), infinity);
  // C1 U [(x/a) (rho/delta)^nu]^(-1/mu)
  EXPECT_NEAR(flow.speed(5) / (3300 * std::pow(10 * std::pow(1.5, 0.4), -1 / 0.41)), 1, 1e-13);

  const double from = 0.7, to = 40, rho = 1500;
  const Launched launched = flow.between(from, to);
  const auto power = [&](double n) { return (std::pow(to, n) - std::pow(from, n)) / n; };
  const double v1 = flow.speed(1), per_x2 = 3 * 0.3 * rho;
  EXPECT_NEAR(launched.mass / (0.3 * rho * (to * to * to - from * from * from)), 1, 1e-12);
  EXPECT_NEAR(launched.momentum / (per_x2 * v1 * power(3 - 1 / 0.41)), 1, 1e-12);
  EXPECT_NEAR(launched.energy / (per_x2 * v1 * v1 / 2 * power(3 - 2 / 0.41)), 1, 1e-12);
  // What a ring launches over its area.
  const double x = 3, dx = 1e-4;
  EXPECT_NEAR(flow.between(x - dx, x + dx).mass / (4 * pi * x * dx) / flow.column(x), 1, 1e-8);
  EXPECT_EQ(flow.between(2, 2).mass, 0);
}

TEST(LaunchFlow, slows_to_rest_at_the_rim_of_the_crater) {
  const LaunchFlow flow(sand(), 0.5, 1000, 6000);
  PointSource without = sand();
  without.crater_radius.reset();
  EXPECT_EQ(flow.end(), 12);
  EXPECT_NEAR(flow.speed(9) / LaunchFlow(without, 0.5, 1000, 6000).speed(9), std::pow(0.25, 0.3),
              1e-14);
  EXPECT_EQ(flow.speed(12), 0);
}

/// A layer of 40 x 40 m below z = 0 full of spheres, some of which move, and the impactor. A line
/// through it meets 15 spheres in the mean, so that one in 10^5 lacks the mass that is launched.
struct Layer {
  std::vector<Sphere> spheres;
  BodyId impactor;

  explicit Layer(double radius) {
    const double depth = 33 * radius, filled = 0.6;
    std::mt19937_64 draw(7);
    std::uniform_real_distribution<double> across(-20, 20), down(-depth, 0), speed(-1e-3, 1e-3);
    const double volume = 4 * pi / 3 * radius * radius * radius;
    const int count = static_cast<int>(filled * 40 * 40 * depth / volume);
    for (int k = 0; k < count; ++k)
      spheres.push_back({radius, 2500 * volume, Vec3(across(draw), across(draw), down(draw)),
                         Vec3(speed(draw), speed(draw), speed(draw))});
    impactor = count;
    spheres.push_back({0.5, 500, Vec3(0.3, -0.2, 3), Vec3(0, 0, -6000)});
  }
};

struct Handed {
  HandOver books;
  std::vector<Sphere> after;
};

Handed hand_over(const Comm& comm, const Layer& layer, const Impactor& impactor) {
  Lab world = make_world(comm, layer.spheres, {});
  const HandOver books = hand_over_flow(comm, impactor, layer.impactor, world.bodies);
  return {books, spheres_of(world)};
}

TEST(HandOver, closes_momentum_and_angular_momentum_and_gives_what_is_launched) {
  const Layer layer(0.7);
  const Impactor impactor = kilograms_of_500();
  const Handed handed = hand_over(testing_world(), layer, impactor);
  const HandOver& books = handed.books;
  Vec3 p = Vec3::Zero(), L = Vec3::Zero();
  double energy = 0;
  for (std::size_t k = 0; k < layer.spheres.size(); ++k) {
    const Sphere &one = handed.after[k], &was = layer.spheres[k];
    p += one.mass * (one.velocity - was.velocity);
    L += one.mass * one.position.cross(one.velocity - was.velocity) +
         0.4 * one.mass * one.radius * one.radius * one.spin;
    energy += one.mass * (one.velocity.squaredNorm() - was.velocity.squaredNorm()) / 2 +
              0.2 * one.mass * one.radius * one.radius * one.spin.squaredNorm();
  }
  const double unit = 500 * 6000;
  EXPECT_LT(p.norm(), 1e-12 * unit);
  EXPECT_LT(L.norm(), 1e-12 * unit * 20);
  EXPECT_LT(books.momentum_closure, 1e-12);
  EXPECT_LT(books.angular_closure, 1e-12);
  EXPECT_NEAR((energy + books.heat) / books.energy, 0, 1e-10);
  EXPECT_NEAR((books.flow_energy + books.carrier_energy + books.heat) / books.energy, 1, 1e-14);

  // The whole flow lies on the layer.
  const LaunchFlow flow(sand(), 0.5, 500 / (pi / 6), 6000);
  const Launched outer = flow.between(2, 12), inner = flow.between(flow.begin(), 2);
  EXPECT_EQ(books.reach, 12);
  EXPECT_NEAR(books.found_mass / outer.mass, 1, 1e-4);  // a line or two lack it
  EXPECT_NEAR(books.given_momentum / (outer.momentum * std::sqrt(0.5)), 1, 1e-4);
  EXPECT_NEAR(books.inner_momentum / (inner.momentum * std::sqrt(0.5)), 1, 1e-12);
  EXPECT_NEAR(handed.after.back().velocity.z(), books.inner_momentum / 500, 1e-2);
  EXPECT_LT(books.outer_energy + books.inner_energy, 0.1 * books.energy);
  // Bodies that are launched in part have less energy than their mass in the flow.
  EXPECT_GT(books.flow_energy, 0);
  EXPECT_LT(books.flow_energy, books.outer_energy);
}

TEST(HandOver, gives_the_same_momentum_at_any_radius_to_bodies_of_any_size) {
  const Handed first = hand_over(testing_world(), Layer(0.7), kilograms_of_500());
  const double all = first.books.inner_momentum + first.books.given_momentum;
  for (const double radius : {0.5, 1.0})
    for (const double at : {1.0, 5.0}) {
      Impactor impactor = kilograms_of_500();
      impactor.coupling->hand_over = at;
      const HandOver books = hand_over(testing_world(), Layer(radius), impactor).books;
      EXPECT_NEAR((books.inner_momentum + books.given_momentum) / all, 1, 5e-3)
          << radius << " " << at;
    }
}

TEST(HandOver, is_the_same_on_any_number_of_ranks) {
  const Layer layer(1);
  const Handed many = hand_over(testing_world(), layer, kilograms_of_500());
  const Handed one = hand_over(alone(), layer, kilograms_of_500());
  EXPECT_EQ(many.books.given_momentum, one.books.given_momentum);
  EXPECT_EQ(many.books.count, one.books.count);
  for (std::size_t k = 0; k < layer.spheres.size(); ++k)
    ASSERT_LT((many.after[k].velocity - one.after[k].velocity).norm(), 1e-12 * 6000) << k;
}

TEST(HandOver, launches_against_the_ellipsoid_where_it_is_asked_to) {
  Impactor impactor = kilograms_of_500();
  const Layer layer(1);
  const double plane = hand_over(testing_world(), layer, impactor).books.given_momentum;
  impactor.coupling->surface = LaunchSurface::ellipsoid;
  const double tilted = hand_over(testing_world(), layer, impactor).books.given_momentum;
  // All slopes of an ellipsoid fall away from its axis: launches lean outwards, by less than the
  // slope at the end of the flow, where tan = c/s x / sqrt(s^2 - x^2), with c 16.5 and s 20 m or
  // more times the ratio of a box's and an ellipsoid's moments.
  EXPECT_LT(tilted, plane);
  const double slope = std::atan(16.5 / 20 * 12 / std::sqrt(20 * 20 - 12 * 12));
  EXPECT_GT(tilted, std::sin(pi / 4 - slope) / std::sin(pi / 4) * plane);
}

TEST(HandOver, beyond_the_limb_of_the_ellipsoid_launches_along_the_flight_and_not_sideways) {
  Impactor impactor = kilograms_of_500();
  impactor.coupling->surface = LaunchSurface::ellipsoid;
  impactor.coupling->crater_radius = 54;
  const Layer layer(1);
  const Handed handed = hand_over(testing_world(), layer, impactor);
  // A layer of 40 x 40 m has an ellipsoid with semi-axes of sqrt(5/12) 40 = 25.8 m across; corners
  // lie 28.3 m from its axis.
  const double limb = std::sqrt(5.0 / 12) * 40;
  Vec3 recoil = Vec3::Zero();  // of what is launched nowhere: deep below
  int deep = 0, beyond = 0;
  for (std::size_t k = 0; k + 1 < layer.spheres.size(); ++k) {
    if (layer.spheres[k].position.z() > -20) continue;
    recoil += handed.after[k].velocity - layer.spheres[k].velocity;
    ++deep;
  }
  recoil /= deep;
  double sideways = 0, outwards = 0, along = 0;
  for (std::size_t k = 0; k + 1 < layer.spheres.size(); ++k) {
    const Vec3 x = layer.spheres[k].position;
    const double from_axis = x.head<2>().norm();
    const Vec3 v = handed.after[k].velocity - layer.spheres[k].velocity - recoil;
    if (from_axis < limb + 0.5 || v.norm() < 0.1 * recoil.norm()) continue;
    const Vec3 out = Vec3(x.x(), x.y(), 0) / from_axis, side = Vec3::UnitZ().cross(out);
    sideways += std::abs(v.dot(side));
    outwards += v.dot(out);
    along -= v.z();  // the impactor flies downwards
    ++beyond;
  }
  EXPECT_GT(beyond, 3);
  EXPECT_GT(outwards, 0);
  EXPECT_LT(sideways, 0.2 * outwards);
  EXPECT_GT(along, 0);  // faster than the recoil, which goes the same way
}

TEST(HandOver, leaves_what_does_not_hang_together_with_the_target_alone) {
  Layer layer(1);
  const Handed without = hand_over(testing_world(), layer, kilograms_of_500());
  const Sphere impactor = layer.spheres.back();
  layer.spheres.pop_back();
  const std::size_t pair = layer.spheres.size();
  // Below the layer, where rays go on, and aside, both beyond a gap; the last two hang together.
  layer.spheres.push_back({5, 1e6, Vec3(0, 0, -60), Vec3(1, 0, 0)});
  layer.spheres.push_back({20, 1e8, Vec3(400, 0, 0), Vec3(0, 2, 0)});
  layer.spheres.push_back({20, 1e8, Vec3(440, 0, 0), Vec3(0, 2, 0)});
  layer.impactor = static_cast<BodyId>(layer.spheres.size());
  layer.spheres.push_back(impactor);
  const Handed handed = hand_over(testing_world(), layer, kilograms_of_500());
  for (std::size_t k = pair; k < pair + 3; ++k) {
    EXPECT_EQ(handed.after[k].velocity, layer.spheres[k].velocity);
    EXPECT_EQ(handed.after[k].spin, Vec3::Zero());
  }
  // The others do as without them, to the round-off of sums that now hold these three, too.
  for (std::size_t k = 0; k < pair; ++k)
    ASSERT_LT((handed.after[k].velocity - without.after[k].velocity).norm(), 1e-6) << k;
  EXPECT_LT(handed.books.momentum_closure, 1e-10);
  EXPECT_EQ(handed.books.reach, without.books.reach);
}

TEST(HandOver, without_bodies_in_its_way_is_an_error) {
  Impactor impactor = kilograms_of_500();
  impactor.coupling->hand_over = 11.9;
  Layer layer(0.5);
  for (Sphere& one : layer.spheres)
    if (one.mass != 500) one.position *= 0.1;
  EXPECT_NE(complaint_of([&] { hand_over(alone(), layer, impactor); }).find("no body lies where"),
            std::string::npos);
}

std::string folder_of(const std::string& name) {
  return folder_of_run("hand_over_" + name);
}

/// A ball of 200 boulders of 8 t; `coupling` follows the impactor's keys.
std::string ball(const std::string& coupling) {
  return R"(read_out = ["1 s", "4 s"]
[materials.rock]
density = "2000 kg/m^3"
[contact]
friction = 0.5
restitution = 0.3
[gravity]
method = "direct"
[[groups]]
name = "ball"
material = "rock"
volume = {radius = "9 m"}
packing = {kind = "random", radius = "1 m", count = 200}
[[phases]]
name = "settling"
step = "10 s"
duration = "1500 s"
[[phases]]
name = "impact"
step = "1 ms"
duration = "50 ms"
remove_drift = true
impactor = {mass = "0.5 kg", diameter = "10 cm", speed = "6 km/s", direction = [1, 0, 0], distance = "0.1 m", aim = "line")" +
         coupling + R"(}
[[phases]]
name = "evolution"
step = "0.05 s"
duration = "4 s"
)";
}

const std::string coupled =
    ", coupling = {law = \"point_source\", ground = \"sand\", density = 1200, hand_over = 1}";

double value(const toml::table& results, const char* section, const char* key) {
  return results[section][key].value<double>().value();
}

TEST(CoupledRun, that_would_make_energy_is_refused) {
  const auto told = [](const std::string& hand_over) {
    std::string with = coupled;
    with.replace(with.find("hand_over = 1"), 13, "hand_over = " + hand_over);
    with.replace(with.find("sand"), 4, "rock");  // launches more near the site
    return complaint_of([&] { parse_case(ball(with), "ball.toml"); });
  };
  EXPECT_EQ(told("0.1"), "");
  const std::string message = told("8");
  EXPECT_TRUE(message.starts_with("ball.toml:")) << message;
  EXPECT_NE(message.find("phases.impact.impactor.coupling.hand_over = 8 m: "), message.npos)
      << message;
  EXPECT_NE(message.find("a smaller hand_over gives more to bodies"), message.npos) << message;
}

TEST(CoupledRun, closes_its_books_and_goes_on_after_a_stop) {
  const std::string folder = folder_of("ball"), again = folder_of("again");
  const std::string told = said_by([&] {
    run_case(testing_world(), parse_case(ball(coupled), "ball.toml"), folder, Former::overwrite);
  });
  const toml::table results = results_in(folder);
  if (testing_world().rank == 0) {
    const auto share = fmt::format("{:.4g} leave from within with its body",
                                   value(results, "coupling", "inner_momentum"));
    EXPECT_NE(told.find(share), told.npos) << told;
  }
  EXPECT_LT(value(results, "coupling", "momentum_closure"), 1e-12);
  EXPECT_LT(value(results, "coupling", "angular_closure"), 1e-12);
  EXPECT_LT(value(results, "deflection", "momentum_closure"), 1e-10);
  EXPECT_LT(value(results, "conservation", "linear"), 1e-10);
  EXPECT_LT(std::abs(value(results, "conservation", "energy_unexplained")), 1e-6);
  EXPECT_GT(value(results, "deflection", "beta"), 1.2);
  const double energy = 0.5 * 0.5 * 6000 * 6000;
  EXPECT_NEAR(value(results, "coupling", "carrier_energy") +
                  value(results, "coupling", "flow_energy") +
                  value(results, "coupling", "heat") / energy,
              1, 1e-6);
  EXPECT_FALSE(results["deflection"].as_table()->contains("struck_mass"));
  EXPECT_FALSE(results["deflection"].as_table()->contains("warning"));

  resume_case(testing_world(), folder + "/after_impact.h5",
              {.folder = again, .former = Former::overwrite, .overrides = {}});
  const toml::table resumed = results_in(again);
  const auto text = [](const toml::table& of, const char* section) {
    std::ostringstream written;
    written << *of[section].as_table();
    return written.str();
  };
  for (const char* section : {"deflection", "coupling", "ejecta", "read_out"})
    EXPECT_EQ(text(results, section), text(resumed, section));
}

TEST(RigidRun, warns_where_beta_is_that_of_a_bounce_alone) {
  const std::string folder = folder_of("bounce");
  run_case(testing_world(), parse_case(ball(""), "ball.toml"), folder, Former::overwrite);
  const toml::table results = results_in(folder);
  const auto warning = results["deflection"]["warning"].value<std::string>();
  ASSERT_TRUE(warning.has_value());  // 0.5 kg on boulders of 8 t
  EXPECT_NE(warning->find("a bounce alone"), std::string::npos) << *warning;
}

}  // namespace
}  // namespace spall
