// What a run would else do wrong without a word: it ends, or says so.
// SPDX-License-Identifier: BSD-3-Clause
#include "run_series.hpp"
#include "scene/consistency.hpp"

namespace spall {
namespace {

const std::string rock = "[materials.rock]\ndensity = 1600\n";

std::string folder_of(const std::string& name) {
  return folder_of_run("told_" + name);
}
/// What the run says.
std::string said(const std::string& name, const std::string& text) {
  return said_by([&] {
    run_case(testing_world(), parse_case(text, "x.toml"), folder_of(name), Former::overwrite);
  });
}

TEST(Told, a_phase_that_has_not_settled) {
  const auto settling = [](const char* restitution) {
    return said("settled", rock + "[contact]\nrestitution = " + restitution + R"(
[[groups]]
name = "a"
material = "rock"
volume = {radius = 1, center = [0, 0, 1.5]}
[[groups]]
name = "b"
material = "rock"
volume = {radius = 1, center = [9, 0, 1.5]}
[[planes]]
[gravity]
uniform = [0, 0, -9.81]
[[phases]]
name = "settling"
step = 0.01
duration = 3
until = "settled"
settled_speed = 1e-3
)");
  };
  const auto kept = [] {
    return results_in(folder_of("settled"))["settling"]["warning"].value_or(std::string());
  };
  const std::string bounces = settling("1"), told = kept();
  const std::string rests = settling("0");
  EXPECT_EQ(told.substr(0, 35), "phase settling has not settled: its");
  EXPECT_EQ(kept(), "");
  if (testing_world().rank > 0) return;  // the first one speaks
  EXPECT_NE(bounces.find("WARNING: phase settling has not settled"), bounces.npos);
  EXPECT_EQ(rests.find("has not settled"), rests.npos);
}

const std::string lone_bodies = R"(
[[groups]]
name = "a"
material = "rock"
volume = {radius = 1, center = [0, 0, 0]}
[[groups]]
name = "b"
material = "rock"
volume = {radius = 1, center = [9, 0, 0]}
[[groups]]
name = "c"
material = "rock"
volume = {radius = 1, center = [-9, 0, 0]}
)";

TEST(Told, that_a_phase_before_has_not_settled_where_a_run_goes_on) {
  const std::string text = rock + lone_bodies + R"(
[[phases]]
name = "settling"
step = 1
duration = 2
until = "settled"
settled_speed = 1e-3
[[phases]]
name = "on"
step = 1
duration = 2
)";
  const std::string folder = folder_of("goes_on"), other = folder_of("goes_on_elsewhere");
  said_by([&] {
    run_case(testing_world(), parse_case(text, "y.toml", {"groups.a.velocity=[0,0,1]"}), folder,
             Former::overwrite);
  });
  const std::string file = folder + "/after_settling.h5";
  ResumeOptions how{.folder = other, .former = Former::overwrite, .overrides = {}};
  said_by([&] { resume_case(testing_world(), file, how); });
  const auto told = results_in(other)["settling"]["warning"].value_or(std::string());
  EXPECT_EQ(told.substr(0, 35), "phase settling has not settled: its");

  // In the folder of the run that has ended it would take the place of what was found.
  how = {};
  how.overrides = {"phases.on.duration=3"};
  const std::string refused = complaint_of([&] { resume_case(testing_world(), file, how); });
  EXPECT_NE(refused.find("holds a run that has ended"), refused.npos) << refused;
  said_by([&] { resume_case(testing_world(), file, {}); });  // ends as it did
  how.former = Former::overwrite;
  said_by([&] { resume_case(testing_world(), file, how); });
}

TEST(Told, that_a_target_is_shattered) {
  const std::string text = "read_out = [1]\n" + rock + lone_bodies + R"(
[[phases]]
name = "hit"
step = 0.01
duration = 1
impactor = {mass = 1000, radius = 0.5, speed = 20, distance = 0.1}
)";
  said("shattered", text);
  const toml::table results = results_in(folder_of("shattered"));
  const auto told = results["deflection"]["warning"].value_or(std::string());
  EXPECT_EQ(told.substr(0, 70),
            "WARNING: the target is shattered: its largest clump has 0.33 of its ma");
}

TEST(Told, that_a_phase_pushes_apart_what_a_solid_bore_overlapping) {
  said("pushed", R"([materials.al]
library = "aluminium_6061_t6"
[solid]
courant = 0.2
[contact]
restitution = 0.5
[penalty]
model = "hertz"
[[groups]]
name = "plate"
material = "al"
volume = {shape = "box", size = ["4 mm", "4 mm", "1 mm"]}
packing = {kind = "fcc", diameter = "0.5 mm"}
[[groups]]
name = "ball"
material = "al"
volume = {shape = "sphere", diameter = "2 mm", center = [0, 0, "1.6 mm"]}
packing = {kind = "fcc", diameter = "0.5 mm"}
velocity = [0, 0, "-300 m/s"]
[[phases]]
name = "hit"
method = "solid"
step = "0.1 us"
duration = "3 us"
[[phases]]
name = "fly"
method = "penalty"
step = "2 ns"
duration = "20 ns"
)");
  const auto told = results_in(folder_of("pushed"))["overlap"]["warning"].value_or(std::string());
  EXPECT_EQ(
      told.substr(0, 86),
      "phase fly pushes apart bodies that overlap as the method before it bore them: its pair");
}

TEST(Told, margins_of_a_wall_though_no_snapshot_falls_into_the_phase) {
  said("margins", R"([output]
snapshot_every = "1 ms"
[materials.al]
library = "aluminium_6061_t6"
[[groups]]
name = "wall"
material = "al"
volume = {shape = "cylinder", diameter = "20 mm", height = "2 mm"}
packing = {kind = "fcc", diameter = "1 mm", orientation = "random"}
[[groups]]
name = "ball"
material = "al"
volume = {shape = "sphere", diameter = "4 mm", center = [0, 0, "3.3 mm"]}
packing = {kind = "fcc", diameter = "1 mm"}
velocity = [0, 0, "-500 m/s"]
[[phases]]
name = "hit"
method = "solid"
step = "8 ns"
duration = "0.4 us"
[[shields]]
wall = "wall"
)");
  const toml::table results = results_in(folder_of("margins"));
  ASSERT_TRUE(results["shield_wall"]["times"].is_array());
  EXPECT_EQ(results["shield_wall"]["times"].as_array()->size(), 10u);
}

TEST(Told, that_what_leaves_forwards_makes_beta_less_than_that_of_a_bounce) {
  said("forwards", "read_out = [10]\n" + rock + R"([contact]
restitution = 0.5
[[groups]]
name = "large"
material = "rock"
volume = {radius = 10}
[[groups]]
name = "behind"
material = "rock"
volume = {radius = 5, center = [15.05, 0, 0]}
[[phases]]
name = "hit"
step = 0.01
duration = 10
impactor = {mass = 1e4, radius = 0.5, speed = 20, distance = 0.1}
)");
  const toml::table results = results_in(folder_of("forwards"));
  const auto deflection = [&](const char* key) {
    return results["deflection"][key].value_or(std::nan(""));
  };
  EXPECT_LT(deflection("dv_ejecta"), -0.1 * deflection("dv_impactor"));
  EXPECT_LT(deflection("beta_along"), 1.4);
  const auto told = results["deflection"]["warning"].value_or(std::string());
  EXPECT_NE(told.find("less than a bounce alone would give: what left forwards took 0.2"),
            std::string::npos)
      << told;
}

TEST(Told, how_deep_springs_let_bodies_go) {
  // v sqrt(m / k) without losses, over the smaller radius.
  const double k = 1e8, v = 0.2, a = 1, b = 0.5;
  const auto mass = [](double r) { return 1600 * 4 / 3.0 * pi * r * r * r; };
  const auto deepest = [&](const std::string& more) {
    said("soft", rock + fmt::format(R"(youngs_modulus = 1e9
poisson_ratio = 0.3
[contact]
restitution = 1
[penalty]
model = "hooke"
stiffness = {}
[[groups]]
name = "a"
material = "rock"
volume = {{radius = {}, center = [0, 0, 1.01]}}
velocity = [0, 0, {}]
{}
[[phases]]
name = "hit"
method = "penalty"
step = 1e-4
duration = 0.12
)",
                                    k, a, -v, more));
    return results_in(folder_of("soft"))["penalty"]["overlap_max"].value_or(0.0);
  };
  const double reduced = mass(a) * mass(b) / (mass(a) + mass(b));
  const double pair = v * std::sqrt(reduced / k) / b, wall = v * std::sqrt(mass(a) / k) / a;
  EXPECT_NEAR(deepest("[[groups]]\nname = \"b\"\nmaterial = \"rock\"\n"
                      "volume = {radius = 0.5, center = [0, 0, -0.5]}\n"),
              pair, 1e-3 * pair);
  EXPECT_NEAR(deepest("[[groups]]\nname = \"b\"\nmaterial = \"rock\"\n"
                      "volume = {radius = 0.5, center = [9, 0, 0.6]}\n[[planes]]\n"),
              wall, 1e-3 * wall);
}

TEST(Told, that_pieces_fly_apart_where_nothing_attracts_them) {
  const auto deflection = [](const std::string& gravity) {
    said("apart", "read_out = [100]\n" + rock + gravity + R"([contact]
restitution = 0.5
[[groups]]
name = "large"
material = "rock"
volume = {radius = 10}
[[groups]]
name = "small"
material = "rock"
volume = {radius = 1, center = [0, 20, 0]}
[[phases]]
name = "hit"
step = 0.01
duration = 100
impactor = {mass = 1000, radius = 0.5, speed = 0.02, distance = 0.1, offset = [0, 20, 0]}
)");
    const toml::table results = results_in(folder_of("apart"));
    return std::pair(*results["ejecta"]["count"].value<std::int64_t>(),
                     *results["deflection"]["dv"].value<double>());
  };
  EXPECT_EQ(deflection(""), std::pair(std::int64_t{1}, 0.0));
  EXPECT_EQ(deflection("[gravity]\nmethod = \"direct\"\nconstant = 1e-30\n").first, 1);
}

TEST(Told, that_bodies_have_become_too_fast_for_their_law) {
  const auto falling = [](double height) {
    return complaint_of([&] {
      said("falls", rock + fmt::format(R"([pair_potential]
law = "morse"
depth = 1e3
distance = 2
steepness = 4
cutoff = 3
[[groups]]
name = "a"
material = "rock"
volume = {{radius = 1, center = [0, 0, {}]}}
[[groups]]
name = "b"
material = "rock"
volume = {{radius = 1, center = [90, 0, 3]}}
[[planes]]
[gravity]
uniform = [0, 0, -9.81]
[[phases]]
name = "falls"
method = "potential"
step = 1e-2
duration = 4
)",
                                       height));
    });
  };
  EXPECT_EQ(falling(5), "");
  EXPECT_EQ(falling(60).substr(0, 26), "bodies have become faster:");
}

TEST(Told, that_what_was_broken_in_a_file_would_be_whole_again) {
  const std::string group = R"([[groups]]
name = "a"
material = "rock"
volume = {radius = 9}
packing = {kind = "file", file = "none.h5"}
)";
  const std::string phase = "[[phases]]\nname = \"p\"\nstep = 1e-6\nduration = 1e-5\n";
  const std::string law =
      "[pair_potential]\nlaw = \"morse\"\ndepth = 1\ndistance = 1\n"
      "steepness = 4\nbreaking_strain = 0.1\n";
  const auto complaint = [&](const std::string& text, double damage) {
    Case scene = parse_case(rock + text, "x.toml");
    scene.groups[0].packing.stored.resize(2);
    scene.groups[0].packing.stored[1].damage = damage;
    return complaint_of([&] { check_stored_damage(scene); });
  };
  const std::string bonded = law + group + phase + "method = \"potential\"\n";
  EXPECT_EQ(complaint(bonded, 0), "");
  EXPECT_EQ(complaint(group + phase, 0.5), "");  // contacts know no bonds
  EXPECT_NE(complaint(bonded, 0.5).find("have damage, 0.25 on average"), std::string::npos);
}

TEST(Told, that_the_bodies_of_a_file_were_broken) {
  const auto torn = [](const std::string& groups) {
    return rock + R"([pair_potential]
law = "morse"
depth = 1e6
distance = 2
steepness = 4
breaking_strain = 0.1
)" + groups +
           "[[phases]]\nname = \"p\"\nmethod = \"potential\"\nstep = 1e-4\nduration = 0.1\n";
  };
  said("torn", torn(R"([[groups]]
name = "two that spin"
material = "rock"
volume = {shape = "box", size = [4, 2, 2]}
packing = {kind = "simple_cubic", radius = 1}
spin = [0, 0, 200]
)"));
  const std::string again = R"([[groups]]
name = "a"
material = "rock"
volume = {radius = 99}
packing = {kind = "file", file = ")" +
                            folder_of("torn") + "/after_p.h5\"}\n";
  EXPECT_NE(complaint_of([&] { said("again", torn(again)); }).find("have damage, 1 on average"),
            std::string::npos);
}

}  // namespace
}  // namespace spall
