// Cases: what is read, what overrides change, and one clear message for each mistake.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/case.hpp"

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "potential/settings.hpp"
#include "solver/settings.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

const char* const good = R"(title = "two groups"
seed = 7
read_out = ["1 min", 90]
[materials.rock]
density = "1600 kg/m^3"
[materials.ice]
density = 917
[contact]
friction = 0.5
cohesion_range = "1 cm"
[[groups]]
name = "pile"
material = "rock"
volume = {shape = "hollow_sphere", radius = "80 m", inner_radius = "70 m", center = ["1 km", 0, 0]}
packing = {kind = "random", diameter = "3.4 m", count = 100}
spin = [0, 0, "1 rev/h"]
[[groups]]
name = "ball"
material = "ice"
volume = {radius = 2}
[[planes]]
point = [0, 0, -5]
normal = [0, 0, 2]
[gravity]
method = "auto"
uniform = [0, 0, "-9.81 m/s^2"]
[solver]
method = "sor"
tolerance = 1e-3
[[phases]]
name = "rest"
step = "10 s"
duration = "1 h"
until = "settled"
settled_speed = "1 mm/s"
[[phases]]
name = "hit"
step = 1e-4
duration = 100
cohesion = "500 N"
impactor = {mass = 500, diameter = 0.5, speed = "4 km/s", direction = [0, 3, 4], aim = "line"}
solver = {prox = 0}
[orbit]
separation = "1180 m"
speed = 0.17
parameter = 34.102
period = "12.1146 h"
)";

Case read(const std::vector<std::string>& overrides) {
  return parse_case(good, "x.toml", overrides);
}

std::string complaint(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return complaint_of([&] { parse_case(text, "x.toml", overrides); });
}

/// What is said of `good` with the first `was` replaced.
std::string complaint_with(const std::string& was, const std::string& is) {
  std::string text = good;
  const std::size_t at = text.find(was);
  EXPECT_NE(at, text.npos) << was;
  return complaint(text.replace(at, was.size(), is));
}

TEST(Case, fields_are_read_in_si_units) {
  const Case scene = read({});
  EXPECT_EQ(scene.title, "two groups");
  EXPECT_EQ(scene.seed, 7u);
  EXPECT_EQ(scene.read_out, (std::vector<double>{60, 90}));
  ASSERT_EQ(scene.groups.size(), 2u);
  const Group& pile = scene.groups[0];
  EXPECT_EQ(scene.materials[pile.material].density, 1600);
  EXPECT_EQ(pile.volume.shape, Shape::hollow_sphere);
  EXPECT_EQ(pile.volume.center, Vec3(1000, 0, 0));
  EXPECT_EQ(pile.packing.radius, 1.7);
  EXPECT_EQ(pile.packing.count, 100);
  EXPECT_DOUBLE_EQ(pile.spin.z(), 2 * pi / 3600);
  EXPECT_EQ(scene.groups[1].packing.radius, 2);  // single: the volume itself
  EXPECT_EQ(scene.planes[0].normal, Vec3::UnitZ());
  EXPECT_EQ(scene.gravity.method, GravityMethod::automatic);
  EXPECT_EQ(scene.uniform_gravity.z(), -9.81);
  EXPECT_EQ(scene.engines.get<SolverSettings>().method, SolverMethod::sor);
  EXPECT_EQ(scene.phases[0].until, PhaseEnd::settled);
  const Phase& hit = scene.phases[1];
  EXPECT_EQ(hit.cohesion, 500);
  EXPECT_EQ(hit.settings.get<SolverSettings>().prox, 0);
  EXPECT_EQ(hit.settings.get<SolverSettings>().tolerance, 1e-3);  // the rest is the case's
  EXPECT_EQ(hit.impactor->speed, 4000);
  EXPECT_EQ(hit.impactor->aim, Aiming::line);
  EXPECT_TRUE(hit.impactor->direction.isApprox(Vec3(0, 0.6, 0.8), 1e-15));
  EXPECT_DOUBLE_EQ(scene.materials[hit.impactor->material].density, 500 / (pi / 6 / 8));
  EXPECT_DOUBLE_EQ(scene.binary->period, 12.1146 * 3600);
}

TEST(Case, overrides_reach_tables_array_elements_and_names) {
  const Case scene = read({"seed=9", "materials.rock.density=2 g/cm^3", "phases.0.duration=10 s",
                           "phases.hit.step = 1e-5", "groups.1.volume.radius=\"3 m\"",
                           "phases.rest.solver.max_iterations=7", "output.series_every=2 s",
                           "contact.cohesion_law=impulse", "read_out=[5]"});
  EXPECT_EQ(scene.seed, 9u);
  EXPECT_EQ(scene.materials[scene.groups[0].material].density, 2000);
  EXPECT_EQ(scene.phases[0].duration, 10);
  EXPECT_EQ(scene.phases[1].step, 1e-5);
  EXPECT_EQ(scene.groups[1].packing.radius, 3);
  EXPECT_EQ(scene.phases[0].settings.get<SolverSettings>().max_iterations, 7);
  EXPECT_EQ(scene.output.series_every, 2);
  EXPECT_EQ(scene.contact.common().cohesion_law, CohesionLaw::impulse);
  EXPECT_EQ(scene.read_out, std::vector<double>{5});
}

TEST(Case, mistakes_name_file_line_key_and_what_would_be_right) {
  const std::pair<std::pair<const char*, const char*>, const char*> mistakes[] = {
      {{"friction =", "frictoin ="},
       "x.toml:9:1: contact.frictoin is not a key here; did you mean contact.friction?"},
      {{"density = 917", "densty = 917"},
       "x.toml:7:1: materials.ice.densty is not a key here; did you mean materials.ice.density?"},
      {{"friction = 0.5", "q = 1"},
       "x.toml:9:1: contact.q is not a key here; the keys here are material, friction, "
       "restitution, cohesion, cohesion_range, cohesion_law, between"},
      {{"friction = 0.5", "friction = true"},
       "x.toml:9:12: contact.friction is true or false; a number such as 0.5 is wanted"},
      {{"friction = 0.5", "friction = -1"},
       "x.toml:9:12: contact.friction = -1: 0 or more is wanted"},
      {{"friction = 0.5", "friction = nan"},
       "x.toml:9:12: contact.friction = nan: a finite value is wanted"},
      {{"friction = 0.5", "restitution = 1.1"},
       "x.toml:9:15: contact.restitution = 1.1: 0 to 1 is wanted"},
      {{"density = 917", ""}, "x.toml:6:1: materials.ice.density is missing"},
      {{"\"1600 kg/m^3\"", "0"},
       "x.toml:5:11: materials.rock.density = 0 kg/m^3: more than 0 is wanted"},
      {{"\"1600 kg/m^3\"", "\"1600 kg\""},
       "x.toml:5:11: materials.rock.density = \"1600 kg\" is a mass; a density such as \"1600 "
       "kg/m^3\" is wanted"},
      {{"radius = 2}", "radius = -2}"},
       "x.toml:20:20: groups.ball.volume.radius = -2 m: more than 0 is wanted"},
      {{"radius = 2}", "radius = 2, height = 1}"},
       "x.toml:20:23: groups.ball.volume.height is not a key here; the keys here are shape, "
       "center, "
       "radius"},
      {{"radius = 2}", "radius = 2, diameter = 1}"},
       "x.toml:20:34: groups.ball.volume.diameter is given beside radius: give one of them"},
      {{"volume = {radius = 2}", "volume = 3"},
       "x.toml:20:10: groups.ball.volume is a number; a table is wanted: [groups.ball.volume] or "
       "volume = {...}"},
      {{"volume = {radius = 2}", "volume = {shape = \"box\", size = [1, 1, 1]}"},
       "x.toml:20:10: groups.ball.volume is not a sphere: a single packing is one sphere"},
      {{"volume = {radius = 2}", ""},
       "x.toml:17:1: groups.ball.volume is missing, such as {shape = \"sphere\", radius = \"95 "
       "m\"}"},
      {{"inner_radius = \"70 m\"", "inner_radius = \"90 m\""},
       "x.toml:14:68: groups.pile.volume.inner_radius is not smaller than radius"},
      {{"[\"1 km\", 0, 0]", "[\"1 km\", 0]"},
       "x.toml:14:85: groups.pile.volume.center is an array of 2; three components are wanted, "
       "each "
       "a length such as \"0.237 mm\""},
      {{"\"ice\"\nvolume", "\"iron\"\nvolume"},
       "x.toml:19:12: groups.ball.material = \"iron\" is not in [materials]"},
      {{"\"random\"", "\"dense\""},
       "x.toml:15:19: groups.pile.packing.kind = \"dense\": one of \"single\", \"random\", "
       "\"simple_cubic\", \"fcc\", \"hcp\", \"graded\", \"file\" is wanted"},
      {{"\"random\", diameter = \"3.4 m\", count = 100", "\"fcc\", radius = 2, spacing = 3"},
       "x.toml:15:48: groups.pile.packing.spacing = 3 m is less than the spheres' diameter, 4 m"},
      {{"count = 100", "count = 1.5"},
       "x.toml:15:57: groups.pile.packing.count is not whole; a whole number is wanted"},
      {{"count = 100", "count = 0"},
       "x.toml:15:57: groups.pile.packing.count = 0: 1 or more is wanted"},
      {{"normal = [0, 0, 2]", "normal = [0, 0, 0]"}, "x.toml:23:10: planes.0.normal is zero"},
      {{"step = \"10 s\"", "step = \"10 m\""},
       "x.toml:32:8: phases.rest.step = \"10 m\" is a length; a time such as \"10 s\" or \"12 h\" "
       "is "
       "wanted"},
      {{"until = \"settled\"", "until = \"time\""},
       "x.toml:35:1: phases.rest.settled_speed is not a key here; the keys here are name, method, "
       "step, "
       "duration, until, cohesion, remove_drift, impactor, solver"},
      {{"step = 1e-4", "step = 200"}, "x.toml:38:8: phases.hit.step is longer than the duration"},
      {{"impactor = {", "# "},
       "x.toml:3:12: read_out tells times after the impact, but no phase has an impactor"},
      {{"name = \"hit\"", "name = \"rest\""},
       "x.toml:36:1: phases.rest: two phases are named \"rest\""},
      {{"cohesion_range = \"1 cm\"", ""},
       "x.toml:36:1: phases.hit.cohesion needs contact.cohesion_range: the gap up to which it "
       "acts"},
      {{"title = \"two groups\"", "title = 2"},
       "x.toml:1:9: title is a number; a text in quotes is wanted"},
      {{"[[planes]]", "[planes]"}, "x.toml:21:1: planes is a table; tables are wanted: [[planes]]"},
  };
  for (const auto& [change, message] : mistakes)
    EXPECT_EQ(complaint_with(change.first, change.second), message) << change.second;
}

TEST(Case, what_contact_tells_itself_no_material_replaces) {
  const auto law_with = [](const std::string& told) {
    return parse_case(R"([materials.rock]
library = "aluminium_6061_t6"
[contact]
material = "rock"
)" + told + R"(
[[groups]]
name = "block"
material = "rock"
volume = {shape = "box", size = [4, 4, 4]}
packing = {kind = "fcc", radius = 0.5}
[[phases]]
name = "only"
step = 0.01
duration = 1
)",
                      "x.toml")
        .contact.common();
  };
  const ContactLaw derived = law_with("");
  EXPECT_GT(derived.friction, 0);
  EXPECT_GT(derived.cohesion, 0);
  EXPECT_EQ(law_with("friction = 0").friction, 0);
  EXPECT_EQ(law_with("friction = 0").cohesion, derived.cohesion);
  EXPECT_EQ(law_with("cohesion = 0").cohesion, 0);
  EXPECT_EQ(law_with("cohesion = 0").friction, derived.friction);
  EXPECT_EQ(law_with("cohesion = 0\ncohesion_range = 0").cohesion_range, 0);
  EXPECT_TRUE(complaint_of([&] {
                law_with("cohesion_range = 0");
              }).starts_with("x.toml:4:12: contact.material gives a cohesion of 1.096e+08 N"));
}

TEST(Case, what_is_not_toml_is_told_with_its_line) {
  EXPECT_TRUE(complaint_with("friction = 0.5", "friction = ").starts_with("x.toml:9:12: "));
  EXPECT_TRUE(complaint_with("seed = 7", "title = \"again\"").starts_with("x.toml:2:"));
}

TEST(Case, mistakes_in_overrides_name_the_override) {
  EXPECT_EQ(complaint(good, {"contact.frictoin=1"}),
            "--set contact.frictoin=1: contact.frictoin is not a key here; did you mean "
            "contact.friction?");
  EXPECT_EQ(complaint(good, {"contcat.friction=1"}),
            "--set contcat.friction=1: contcat is not a key here; did you mean contact?");
  EXPECT_EQ(
      complaint(good, {"phases.hit.step=4 m"}),
      "--set phases.hit.step=4 m: phases.hit.step = \"4 m\" is a length; a time such as \"10 s\" "
      "or \"12 h\" is wanted");
  EXPECT_EQ(complaint(good, {"phases.hot.step=4"}),
            "--set phases.hot.step=4: phases has no element hot to change the keys of");
  EXPECT_EQ(complaint(good, {"seed"}), "--set seed: key.path=value is wanted");
}

TEST(Case, nothing_to_simulate_is_an_error) {
  EXPECT_EQ(complaint(""), "x.toml: no bodies: it has no [[groups]]");
  EXPECT_EQ(complaint(good, {"phases=[]"}), "x.toml: nothing to run: it has no [[phases]]");
}

TEST(Case, a_missing_file_and_a_folder_are_errors) {
  EXPECT_THROW(read_case("no/such/case.toml"), Error);
  EXPECT_THROW(read_case("."), Error);
}

TEST(Case, a_reference_lies_beside_the_case_and_must_be_there) {
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("spall_reference_{}", getpid());
  std::filesystem::create_directories(folder);
  const std::string file = (folder / "case.toml").string();
  const std::string reference = (folder / "source.toml").string();
  std::ofstream(file) << "reference = \"source.toml\"\n" << good;
  const auto complaint = [&](const std::vector<std::string>& overrides) {
    return complaint_of([&] { read_case(file, overrides); });
  };
  EXPECT_EQ(complaint({}),
            fmt::format("{}:1:13: reference: there is no file '{}'", file, reference));
  std::ofstream(reference) << "title = \"a source\"\n";
  EXPECT_EQ(read_case(file).reference, reference);
  EXPECT_EQ(find_cases(folder.string()), std::vector<std::string>{file});
  EXPECT_EQ(complaint({"reference=none.toml"}),
            fmt::format("--set reference=none.toml: reference: there is no file '{}'",
                        (folder / "none.toml").string()));
  std::filesystem::remove_all(folder);
}

TEST(Case, a_material_s_file_goes_on_with_the_case_whatever_its_name_and_texts) {
  const std::string file = fmt::format("material_{}.toml", getpid());
  std::ofstream(file) << "title = \"\"\"say \"6061\"\nT6\"\"\"\ndensity = \"2.7 g/cm^3\"\n";
  const std::string text = fmt::format(R"([materials."aluminium 6061"]
file = "{}"
[materials."a.b = \"c\""]
file = "{}"
[[groups]]
name = "ball"
material = "aluminium 6061"
volume = {{radius = 1}}
[[phases]]
name = "fly"
step = 1
duration = 1
)",
                                       file, file);
  const Case first = parse_case(text, "x.toml");
  std::filesystem::remove(file);
  // As a restart file keeps it.
  const Case again = parse_case(text, "x.toml", {}, Groups::needed, {}, first.constants);
  EXPECT_EQ(again.constants, first.constants);
  EXPECT_TRUE(first.overrides.empty());
  ASSERT_EQ(again.materials.size(), 2u);
  for (const Material& material : again.materials) EXPECT_EQ(material.density, 2700);
}

TEST(Case, phases_by_a_pair_potential_need_one_and_nothing_else) {
  const std::string bodies = R"([materials.rock]
density = 1600
[[groups]]
name = "ball"
material = "rock"
volume = {radius = 1}
[[phases]]
name = "hit"
method = "potential"
step = 1e-4
duration = 1
)";
  const std::string law = R"([pair_potential]
law = "morse"
depth = "2 J"
distance = 2
steepness = 3
breaking_strain = "5 %"
)";
  const Case scene = parse_case(bodies + law, "x.toml");
  EXPECT_EQ(scene.phases[0].engine->name, "potential");
  EXPECT_EQ(scene.engines.find<PotentialSettings>()->law.common().depth, 2);
  EXPECT_DOUBLE_EQ(scene.engines.find<PotentialSettings>()->law.common().cutoff, 2.2);
  // F = (2 D a/d) (e - e^2) at e = exp(-a eps); not more than its largest, 1.5 N.
  const std::string strong = law.substr(0, law.rfind("breaking_strain"));
  EXPECT_NEAR(parse_case(bodies + strong + "breaking_force = \"1.44 N\"\n", "x.toml")
                  .engines.find<PotentialSettings>()
                  ->law.common()
                  .breaking_strain,
              -std::log(0.6) / 3, 1e-12);
  EXPECT_NEAR(parse_case(bodies + strong + "breaking_energy = \"0.5 J\"\n", "x.toml")
                  .engines.find<PotentialSettings>()
                  ->law.common()
                  .breaking_strain,
              -std::log(0.5) / 3, 1e-12);
  EXPECT_EQ(complaint(bodies + strong + "breaking_force = 1.6\n").substr(0, 64),
            "x.toml:17:18: pair_potential.breaking_force is more than the law");
  EXPECT_EQ(
      complaint(bodies),
      "x.toml:7:1: phases.hit.method = \"potential\" needs [pair_potential]: the law between two "
      "bodies");
  EXPECT_EQ(complaint(bodies + law + "cutoff = 3\n").substr(0, 49),
            "x.toml:18:1: pair_potential.cutoff is not a key h");
  EXPECT_EQ(
      complaint(bodies + law + "[periodic]\nsize = [9, 9, 9]\n[gravity]\nmethod = \"direct\"\n"),
      "x.toml:7:1: phases.hit: [periodic] needs gravity.method = \"none\": images do not attract");
}

TEST(Case, a_key_behind_a_condition_that_hides_it_from_the_reference_cannot_be_read) {
  double value = 0;
  const auto hides = [&](Section& in) {
    std::string kind;
    in.need("kind", "", kind);
    if (kind == "rare") in.take("secret", "", value, any(dimension::number));
  };
  const auto read_rare = [&](const Section::Reader& read) {
    Section::read_all(toml::parse("kind = \"rare\"\nsecret = 1"), "x.toml", read,
                      Section::reference(read));
  };
  EXPECT_THROW(read_rare(hides), std::logic_error);
  read_rare([&](Section& in) {
    std::string kind;
    in.need("kind", "", kind);
    if (in.reads(kind == "rare")) in.take("secret", "", value, any(dimension::number));
  });
  EXPECT_EQ(value, 1);
}

TEST(Case, the_reference_lists_every_key) {
  const std::string reference = case_reference();
  for (const char* key : {"inner_radius", "height", "spacing", "settled_speed", "cohesion_law",
                          "relaxation", "restart_every", "parameter", "read_out"})
    EXPECT_NE(reference.find(key), reference.npos) << key;
}

}  // namespace
}  // namespace spall
