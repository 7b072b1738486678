// From constants of a solid to its spheres: elastic constants, waves, strength, and how cases ask.
// SPDX-License-Identifier: BSD-3-Clause
#include "potential/constitutive.hpp"

#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "potential/embedding.hpp"
#include "potential/settings.hpp"
#include "run/run.hpp"
#include "scene/material_library.hpp"
#include "scene/scene.hpp"
#include "scene/shape.hpp"
#include "solid_worlds.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

const Solid aluminium{.density = 2703,
                      .sound_speed = 5350,
                      .hugoniot_slope = 1.34,
                      .gruneisen = 1.97,
                      .youngs_modulus = 68.9e9,
                      .poisson_ratio = 0.33,
                      .yield_strength = 276e6,
                      .tensile_strength = 310e6,
                      .spall_strength = 1.2e9,
                      .johnson_cook = {}};
const Lattice fcc{12, std::sqrt(0.5), 0.25e-3};

/// The twelve neighbours of a site.
std::vector<Vec3> neighbours() {
  std::vector<Vec3> all;
  for (int i = -1; i <= 1; ++i)
    for (int j = -1; j <= 1; ++j)
      for (int k = -1; k <= 1; ++k)
        if (std::abs(i) + std::abs(j) + std::abs(k) == 2)
          all.push_back(fcc.distance / std::sqrt(2.0) * Vec3(i, j, k));
  return all;
}

/// J/m^3 of the reference volume, of a crystal with this deformation gradient.
double energy_density(const PairPotential& p, const Eigen::Matrix3d& F) {
  double energy = 0;
  for (const Vec3& x : neighbours()) energy += pair_energy(p, (F * x).norm()) / 2;
  return energy / fcc.volume();
}

/// Without breaking: its bonds stretch as they are compressed.
PairPotential whole_law() {
  Solid solid = aluminium;
  solid.spall_strength = 0;
  return morse_law(solid, fcc, Match::bulk, "here");
}

TEST(Solid, warms_by_its_specific_heat_but_while_it_melts) {
  const Solid solid{
      .specific_heat = 900, .melting_point = 850, .melt_energy = 1e6, .johnson_cook = {}};
  EXPECT_EQ(temperature(solid, 0), 298);
  EXPECT_EQ(temperature(solid, 9e4), 398);
  EXPECT_EQ(temperature(solid, 6e5), 850);
  EXPECT_EQ(temperature(solid, 1e6), 850);
  EXPECT_EQ(temperature(solid, 1.09e6), 950);
  Solid untold = solid;  // no heat of fusion is known, so none is taken
  untold.melt_energy = 0;
  EXPECT_EQ(temperature(untold, 900 * (850 - 298) - 9), 849.99);
  EXPECT_NEAR(temperature(untold, 900 * (850 - 298) + 9), 850.01, 1e-9);
}

TEST(Constitutive, crystal_has_the_bulk_modulus_and_answers_shocks_with_the_slope_asked_for) {
  const PairPotential p = whole_law();
  const auto pressure = [&](double strain) {
    const auto energy = [&](double e) {
      return energy_density(p, (1 + e) * Eigen::Matrix3d::Identity());
    };
    const double de = 1e-4, volume = 3 * (1 + strain) * (1 + strain);  // dV/de of unit volume
    return -(energy(strain + de) - energy(strain - de)) / (2 * de * volume);
  };
  // K = -V dP/dV, dV/V = 3 de; K' by another difference.
  const auto modulus = [&](double strain) {
    const double de = 1e-3;
    return -(pressure(strain + de) - pressure(strain - de)) / (2 * de) * (1 + strain) / 3;
  };
  EXPECT_NEAR(modulus(0), aluminium.bulk_modulus(), 1e-4 * aluminium.bulk_modulus());
  const double de = 2e-3;
  const double slope = (modulus(-de) - modulus(de)) / (pressure(-de) - pressure(de));
  EXPECT_NEAR((slope + 1) / 4, aluminium.hugoniot_slope, 1e-3);
}

TEST(Constitutive, elastic_constants_are_those_of_central_bonds) {
  const PairPotential p = whole_law();
  const double c11 = std::sqrt(2.0) * stiffness(p) / fcc.distance, e = 1e-4;
  const auto curvature = [&](const Eigen::Matrix3d& strain) {
    const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
    return (energy_density(p, one + e * strain) + energy_density(p, one - e * strain) -
            2 * energy_density(p, one)) /
           (e * e);
  };
  const Eigen::Matrix3d stretch = Vec3(1, 0, 0).asDiagonal();
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero();
  shear(0, 1) = shear(1, 0) = 0.5;
  EXPECT_NEAR(curvature(stretch), c11, 1e-4 * c11);
  EXPECT_NEAR(curvature(shear), c11 / 2, 1e-4 * c11);
  EXPECT_NEAR(c11, 1.5 * aluminium.bulk_modulus(), 1e-12 * c11);
}

TEST(Constitutive, solid_has_shear_stiffness_from_pairs_and_the_rest_of_its_bulk_modulus_embedded) {
  const Solid solid = aluminium;
  const PairPotential p = morse_law(solid, fcc, Match::solid, "here");
  const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
  // Crowding changes with the square of a shear, and at rest nothing presses: pairs are all, in a
  // shear half of them stretched.
  const double e = 1e-5;
  const auto modulus = [&](const Eigen::Matrix3d& strain) {
    return 2 * (energy_density(p, one + e * strain) - energy_density(p, one)) / (e * e);
  };
  Eigen::Matrix3d shear = Eigen::Matrix3d::Zero(), stretch = Vec3(1, 0, 0).asDiagonal();
  shear(0, 1) = shear(1, 0) = 0.5;
  // Voigt's mean for C11 = 2 C12 = 2 C44.
  EXPECT_NEAR(0.4 * modulus(-stretch), 0.18 * solid.shear_modulus(), 1e-3 * solid.shear_modulus());
  EXPECT_NEAR(modulus(stretch), 1.5 * solid.bulk_modulus(), 1e-3 * solid.bulk_modulus());
  const double c44 = modulus(shear);
  EXPECT_NEAR(c44, (modulus(stretch) + modulus(-stretch)) / 4, 1e-3 * c44);

  const EmbeddingLaw law(p);
  const auto energy = [&](double strain) {
    const double r = (1 + strain) * fcc.distance;
    const double weight = std::pow(1 - r / law.reach(), 2);
    return energy_density(p, (1 + strain) * one) + law.energy(12 * weight);
  };
  const double at = -1e-3, de = 1e-5, eta = 1 - std::pow(1 + at, 3);
  const double pressure = -(energy(at + de) - energy(at - de)) / (6 * de * (1 + at) * (1 + at));
  const double left = 1 - solid.hugoniot_slope * eta;
  EXPECT_NEAR(pressure, solid.bulk_modulus() * eta / (left * left), 2e-3 * pressure);
  const LatticeSpeeds c = sound_speeds(p, sphere_mass(solid, fcc));
  EXPECT_NEAR(c.bulk, solid.sound_speed, 1e-12 * c.bulk);
  EXPECT_NEAR(solid.density * c.shear_100 * c.shear_100, c44, 1e-3 * c44);
}

TEST(Constitutive, waves_run_at_the_lattice_s_sound_speeds) {
  const PairPotential p = whole_law();
  const double d = fcc.distance, m = sphere_mass(aluminium, fcc);
  const LatticeSpeeds c = sound_speeds(p, m);
  EXPECT_NEAR(c.along_100, std::sqrt(1.5) * aluminium.sound_speed, 1e-9 * c.along_100);
  const struct {
    Vec3 direction, motion;
    double speed;
  } waves[] = {{{1, 0, 0}, {1, 0, 0}, c.along_100},
               {{1, 1, 0}, {1, 1, 0}, c.along_110},
               {{1, 1, 1}, {1, 1, 1}, c.along_111},
               {{1, 0, 0}, {0, 1, 0}, c.shear_100}};
  for (const auto& wave : waves) {
    // A standing wave: its crest, in the middle of a ball, falls through zero after a quarter of a
    // period, before the ball's surface is heard of.
    const double length = 14 * d, amplitude = 1e-4 * d, radius = 9 * d;
    const Vec3 q = 2 * pi / length * wave.direction.normalized();
    std::vector<Sphere> spheres;
    std::vector<Vec3> rest;
    std::size_t middle = 0;
    const int n = 13;
    for (int i = -n; i <= n; ++i)
      for (int j = -n; j <= n; ++j)
        for (int k = -n; k <= n; ++k) {
          const Vec3 x = d / std::sqrt(2.0) * Vec3(i, j, k);
          if ((i + j + k) % 2 != 0 || x.norm() > radius) continue;
          if (x.isZero(0)) middle = spheres.size();
          const Vec3 moved = x + amplitude * std::cos(q.dot(x)) * wave.motion.normalized();
          spheres.push_back({.radius = d / 2, .mass = m, .position = moved});
          rest.push_back(x);
        }
    Lab world = make_world(testing_world(), spheres, {});
    world.potential.law = p;
    const auto height = [&] {
      return spheres_of(world)[middle].position.dot(wave.motion.normalized());
    };
    const double h = 0.1 * std::sqrt(m / stiffness(p));
    double before = height(), now = before, time = 0;
    while (now > 0 && time < length / wave.speed) {
      potential_steps(world, h, 1);
      before = now;
      now = height();
      time += h;
    }
    const double quarter = time - h * now / (now - before);
    // Waves of fourteen spacings run up to 0.6 % slower than long ones.
    EXPECT_NEAR(length / (4 * quarter), wave.speed, 0.01 * wave.speed) << wave.direction;
  }
}

/// Pa, largest that the crystal bears while it is stretched along a direction and held across it.
double plane_strength_along(const PairPotential& p, const Vec3& direction) {
  double strongest = 0;
  for (double e = 0; e < 8 * p.breaking_strain; e += 0.01 * p.breaking_strain) {
    double stress = 0;
    for (const Vec3& x : neighbours()) {
      const double along = x.dot(direction);
      const double r = (x + e * along * direction).norm();
      // Half of each bond is a site's; terms of second order in the strain left out.
      stress -= pair_force(p, r) * along * along / r / (2 * fcc.volume());
    }
    strongest = std::max(strongest, stress);
  }
  return strongest;
}

TEST(Constitutive, crystals_tear_in_plane_tension_at_the_strength_asked_for) {
  const PairPotential p = morse_law(aluminium, fcc, Match::solid, "here");
  const double asked = aluminium.spall_strength;
  EXPECT_NEAR(plane_strength(p, fcc), asked, 1e-9 * asked);
  constexpr int directions = 400;
  double mean = 0;
  for (int k = 0; k < directions; ++k) {
    // Fibonacci's points: as many everywhere on the sphere.
    const double z = 1 - (2 * k + 1.0) / directions, turn = k * pi * (3 - std::sqrt(5.0));
    const double r = std::sqrt(1 - z * z);
    mean += plane_strength_along(p, {r * std::cos(turn), r * std::sin(turn), z}) / directions;
  }
  EXPECT_NEAR(mean, asked, 0.02 * asked);
  EXPECT_GT(plane_strength_along(p, {0, 0, 1}), 1.3 * asked);
}

TEST(Constitutive, rigid_spheres_hold_the_tensile_strength) {
  // Simple cubic: a contact for each d^2 of the cross-section.
  const Lattice cubic{6, 1, 0.2e-3};
  const Cohesion c = cohesion_of(aluminium, cubic, "here");
  EXPECT_NEAR(c.force / (0.2e-3 * 0.2e-3), aluminium.tensile_strength,
              1e-12 * aluminium.tensile_strength);
  EXPECT_NEAR(c.range / 0.2e-3, 310e6 / 68.9e9, 1e-15);
  EXPECT_NEAR(c.friction, 276 / (std::sqrt(3.0) * 310), 1e-12);
  Solid jelly = aluminium;
  jelly.youngs_modulus = 0.5;
  jelly.tensile_strength = 0.1;
  EXPECT_NEAR(cohesion_of(jelly, cubic, "here").range / 0.2e-3, 0.2, 1e-15);
}

// How cases ask for it.

const char* const bodies = R"(
[[groups]]
name = "plate"
material = "al"
volume = {shape = "box", size = ["10 mm", "10 mm", "3 mm"]}
packing = {kind = "fcc", diameter = "0.25 mm", orientation = "random"}
[[phases]]
name = "only"
method = "potential"
step = "1 ns"
duration = "2 ns"
[pair_potential]
material = "al"
damping = 0.4
)";
const char* const constants =
    "density = 2703\nsound_speed = 5350\nhugoniot_slope = 1.34\nspall_strength = \"1.2 GPa\"\n"
    "gruneisen = 1.97\nyoungs_modulus = \"68.9 GPa\"\npoisson_ratio = 0.33\n";

std::string complaint(const std::string& text) {
  return complaint_of([&] { parse_case(text, "x.toml"); });
}

TEST(Constitutive, a_case_gets_law_and_masses_from_its_material) {
  const Case scene =
      parse_case(std::string("[materials.al.solid]\n") + constants + bodies, "x.toml");
  const PairPotential expected = morse_law(aluminium, fcc, Match::solid, "");
  EXPECT_EQ(scene.engines.find<PotentialSettings>()->law.common().depth, expected.depth);
  EXPECT_EQ(scene.engines.find<PotentialSettings>()->law.common().cutoff, expected.cutoff);
  EXPECT_EQ(scene.engines.find<PotentialSettings>()->law.common().damping, 0.4);
  const Bodies made = make_bodies(scene, Comm(MPI_COMM_SELF));
  double mass = 0;
  for (double m : made.mass) mass += m;
  // What the surface of a turned lattice cuts evens out.
  EXPECT_NEAR(mass, 2703 * volume_of(scene.groups[0].volume), 0.01 * mass);
  EXPECT_NE(describe_phases(scene, measure_groups(scene)).find("[111] 5612 m/s"),
            std::string::npos);
}

TEST(Constitutive, orientations_follow_the_seed) {
  const auto rotation = [&](const std::string& seed) {
    return parse_case(seed + "[materials.al.solid]\n" + constants + bodies, "x.toml")
        .groups[0]
        .packing.rotation;
  };
  EXPECT_EQ(rotation("seed = 2\n"), rotation("seed = 2\n"));
  EXPECT_GT((rotation("seed = 2\n") - rotation("seed = 3\n")).norm(), 1e-3);
}

TEST(Constitutive, a_material_s_file_is_read_once_and_named_in_messages) {
  const Comm comm = testing_world();
  if (comm.rank != 0) return;
  const auto folder =
      std::filesystem::temp_directory_path() / fmt::format("spall_materials_{}", getpid());
  std::filesystem::create_directories(folder);
  const auto write = [&](const std::string& text) { std::ofstream(folder / "al.toml") << text; };
  write(constants);
  const std::string file = (folder / "case.toml").string();
  const std::string text = std::string("[materials.al]\nfile = \"al.toml\"\n") + bodies;
  const Case scene = parse_case(text, file);
  EXPECT_EQ(scene.materials[0].solid->sound_speed, 5350);
  write("density = 2703\nsound_sped = 5350\n");
  try {
    parse_case(text, file);
    FAIL();
  } catch (const Error& error) {
    const std::string place = (folder / "al.toml").string() + ":2:1";
    EXPECT_EQ(std::string(error.what()).find(place), 0u) << error.what();
    EXPECT_NE(std::string(error.what()).find("did you mean"), std::string::npos);
  }
  // A restart has the case as it was read, and its overrides.
  std::filesystem::remove_all(folder);
  const Case again =
      parse_case(scene.text, scene.file, scene.overrides, Groups::needed, {}, scene.constants);
  EXPECT_EQ(again.engines.find<PotentialSettings>()->law.common().depth,
            scene.engines.find<PotentialSettings>()->law.common().depth);
  EXPECT_EQ(again.materials[0].density, 2703);
  EXPECT_EQ(complaint(text), "x.toml:2: materials.al.file: there is no file 'al.toml'");
}

TEST(Constitutive, what_a_case_says_comes_before_its_library) {
  const auto copper = [](const std::string& own, const std::vector<std::string>& overrides = {}) {
    return parse_case("[materials.al]\nlibrary = \"copper\"\n" + own + bodies, "x.toml", overrides);
  };
  const Solid known = *copper("").materials[0].solid;
  EXPECT_EQ(known.density, 8930);
  EXPECT_EQ(known.yield_strength, 90e6);
  const Case changed = copper("solid = {yield_strength = \"300 MPa\"}\n");
  EXPECT_EQ(changed.materials[0].solid->yield_strength, 300e6);
  EXPECT_EQ(changed.materials[0].solid->density, known.density);
  EXPECT_EQ(changed.materials[0].density, known.density);
  const Case set = copper("", {"materials.al.solid.yield_strength=300 MPa"});
  EXPECT_EQ(set.materials[0].solid->yield_strength, 300e6);
  // What goes on keeps its constants whatever the library says then; so does the resolved case.
  std::string text = set.text;
  text.replace(text.find("copper"), 6, "no_longer_there");
  const Solid again = *parse_case(text, set.file, set.overrides, Groups::needed, {}, set.constants)
                           .materials[0]
                           .solid;
  EXPECT_EQ(again.yield_strength, 300e6);
  EXPECT_EQ(again.johnson_cook.d, known.johnson_cook.d);
  EXPECT_EQ(parse_case(set.resolved, set.file).materials[0].solid->yield_strength, 300e6);
  RestartState state;
  state.case_text = text, state.case_file = set.file, state.overrides = set.overrides,
  state.constants = set.constants;
  const auto goes_on = [&](const std::string& change) {
    return case_to_go_on(testing_world(), state, {change}, {}).materials[0].solid->yield_strength;
  };
  EXPECT_EQ(goes_on("materials.al.solid.yield_strength=200 MPa"), 200e6);
  for (const char* change : {"materials.al.library=lead", "materials.al.file=lead.toml",
                             "materials={al={library=\"lead\"}}"})
    EXPECT_THROW(goes_on(change), Error) << change;
}

TEST(Constitutive, every_material_of_the_library_is_one) {
  EXPECT_GE(material_library().size(), 16u);
  for (const LibraryMaterial& material : material_library()) {
    const Solid solid = *material_of_library(material.name).solid;
    // Two ways to the bulk modulus: shocks, and elastic constants. They differ most for polymers.
    // Elastic constants are those of the whole, with its pores.
    const double elastic = solid.youngs_modulus / (3 * (1 - 2 * solid.poisson_ratio));
    EXPECT_NEAR(elastic * solid.pores.distension / solid.bulk_modulus(), 1, 0.4) << material.name;
    // By Dugdale & MacDonald and by Slater, Gruneisen's parameter is 2 s - 1 but for some tenths.
    // Nylon's is far smaller: shocks press its chains together, heat shakes them along themselves.
    if (material.name == "nylon_66")
      EXPECT_LT(solid.gruneisen, 2 * solid.hugoniot_slope - 1);
    else
      EXPECT_NEAR(solid.gruneisen, 2 * solid.hugoniot_slope - 1, 0.9) << material.name;
  }
}

TEST(Constitutive, what_a_law_lacks_is_told) {
  EXPECT_NE(complaint(std::string("[materials.al.solid]\ndensity = 2703\n") + bodies)
                .find("needs the material's sound_speed"),
            std::string::npos);
  EXPECT_NE(complaint(std::string("[materials.al]\ndensity = 2703\n") + bodies)
                .find("is not a solid of [materials]"),
            std::string::npos);
  std::string cubic = std::string("[materials.al.solid]\n") + constants + bodies;
  cubic.replace(cubic.find("\"fcc\""), 5, "\"simple_cubic\"");
  EXPECT_NE(complaint(cubic).find("no shear stiffness"), std::string::npos);
  std::string strong = std::string("[materials.al.solid]\n") + constants + bodies;
  strong.replace(strong.find("1.2 GPa"), 7, "40 GPa");
  EXPECT_NE(complaint(strong).find("can bear"), std::string::npos);
}

}  // namespace
}  // namespace spall
