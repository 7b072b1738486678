// What is not modelled or contradicts itself: refused alike by check and by run, before any step.
// SPDX-License-Identifier: BSD-3-Clause
#include <unistd.h>

#include <filesystem>

#include "run/run.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// Two spheres, a metre apart, that do not move.
const std::string bodies = R"([materials.rock]
density = 1600
[[groups]]
name = "a"
material = "rock"
volume = {radius = 1}
[[groups]]
name = "b"
material = "rock"
volume = {radius = 1, center = [3, 0, 0]}
)";
const std::string phase = R"([[phases]]
name = "only"
step = "1 ms"
duration = "10 s"
)";
const std::string impactor =
    "impactor = {mass = 1, radius = 0.1, speed = \"1 km/s\", distance = 1}\n";
/// Hit by point-source theory.
std::string coupled_by(const std::string& more) {
  return "impactor = {mass = 1, radius = 0.1, speed = 10, distance = 1, coupling = {law = "
         "\"point_source\", density = 1, hand_over = 1" +
         more + "}}\n";
}
const std::string springs = "[contact]\nrestitution = 0.5\n[penalty]\nmodel = \"hooke\"\n";
const std::string by_springs = "method = \"penalty\"\n";
const std::string law = "[pair_potential]\nlaw = \"lennard_jones\"\ndepth = 1\ndistance = 2\n";
const std::string between_rock_and_ice =
    "[[pair_potential.between]]\nmaterials = [\"rock\", \"ice\"]\nlaw = \"lennard_jones\"\n"
    "depth = 2\ndistance = 2\ncutoff = 3\n";
const std::string by_law = "method = \"potential\"\n";

// Motions of group b, all at rest at the start: 6 km/s within some steps, after 5 s, after 15 s.
const std::string shaken =
    "motion.oscillation = {amplitude = [\"10 m\", 0, 0], period = \"10 ms\", phase = 1.570796}\n";
const std::string struck =
    "motion.table = {times = [5, 5.001], displacements = [[0, 0, 0], [0, 6, 0]]}\n";
const std::string struck_later =
    "motion.table = {times = [15, 15.001], displacements = [[0, 0, 0], [0, 6, 0]]}\n";

/// The bodies and a group by another recipe.
std::string with_group(const std::string& keys) {
  return bodies + "[[groups]]\nname = \"c\"\nmaterial = \"rock\"\n" + keys + phase;
}

/// "a.a.a..."
std::string nested(int parts) {
  std::string key = "a";
  while (--parts > 0) key += ".a";
  return key;
}

struct Refused {
  std::string text;     ///< of the case
  std::string message;  ///< from its beginning on
};

const std::vector<Refused> table = {
    // Times and phases.
    {bodies + phase + "until = \"settled\"\n", "x.toml:11:1: phases.only.settled_speed is missing"},
    {bodies + phase + "[[phases]]\nname = \"a/b\"\nstep = 1\nduration = 1\n",
     "x.toml:16:8: phases.a/b.name cannot be part of a file's name"},
    {bodies + phase + phase, "x.toml:15:1: phases.only: two phases are named \"only\""},
    {"read_out = [5, 20]\n" + bodies + phase + impactor,
     "x.toml:1:12: read_out = 20 s is never reached: phases end 10 s after the impactor is added"},
    {"read_out = [0.0005]\n" + bodies + phase + impactor,
     "x.toml:1:12: read_out = 0.0005 s: the impactor of x.toml:12:1: phases.only has not "
     "arrived by then, it flies 1 m at 1000 m/s"},
    {"read_out = [0.0005, 5]\n" + bodies + phase + impactor,
     "x.toml:1:12: read_out = 0.0005 s: the impactor of x.toml:12:1: phases.only has not "},
    {"read_out = [5]\n" + bodies + phase,
     "x.toml:1:12: read_out tells times after the impact, but no phase has an impactor"},
    {bodies + phase + impactor + "[[phases]]\nname = \"again\"\nstep = 1\nduration = 1\n" +
         impactor,
     "x.toml:20:12: phases.again.impactor: phases.only has an impactor, too; there can be one"},
    {bodies + phase + "[orbit]\nseparation = 1\nspeed = 1\nparameter = 1\nperiod = 1\n",
     "x.toml:15:1: orbit asks for the orbit after an impact, but no phase has an impactor"},
    {bodies + phase + impactor + "[orbit]\nseparation = 1\nspeed = 1\nparameter = 1\nperiod = 1\n",
     "x.toml:16:1: orbit follows from the deflection: it needs read_out"},
    {bodies + phase + "cohesion = \"1 N\"\n",
     "x.toml:11:1: phases.only.cohesion needs contact.cohesion_range"},
    {"read_out = [15]\n" + bodies + phase + impactor +
         "[[phases]]\nname = \"later\"\nstep = 1\nduration = 9\nremove_drift = true\n",
     "x.toml:17:1: phases.later.remove_drift takes away what the impact gave, and x.toml:1:12: "
     "read_out asks later"},
    {bodies + phase + "until = \"settled\"\nsettled_speed = 1\n[output]\nseries_every = 20\n",
     "x.toml:11:1: phases.only.until = \"settled\" is looked at in rows of the series, which come "
     "every 20 s, and the phase ends after 10 s"},
    {bodies + springs +
         "stiffness = 1e6\n[[phases]]\nname = \"only\"\nstep = 1e-4\nduration = 5e-3\n" +
         by_springs + "until = \"settled\"\nsettled_speed = 1\n",
     "x.toml:16:1: phases.only.until = \"settled\" is looked at in rows of the series, which come "
     "every 0.01 s, and the phase ends after 0.005 s"},
    {with_group("volume = {radius = 1, center = [9, 0, 0]}\nvelocity = [4e7, 0, 0]\n"),
     "x.toml:11:1: groups.c.velocity: 4e+07 m/s are more than a tenth of the speed of light"},
    {with_group("volume = {radius = 2, center = [9, 0, 0]}\nspin = [0, 0, 2e7]\n"),
     "x.toml:11:1: groups.c.spin: 4e+07 m/s are more than a tenth of the speed of light"},
    {with_group("volume = {radius = 1, center = [9, 0, 0]}\nmotion = {velocity = [0, 4e7, 0]}\n"),
     "x.toml:11:1: groups.c.motion: 4e+07 m/s are more than a tenth of the speed of light"},
    // Odd, and beyond what a double holds exactly.
    {with_group("volume = {radius = 1, center = [9, 0, 0]}\nvelocity = [9007199254740993, 0, 0]\n"),
     "x.toml:11:1: groups.c.velocity: 9.01e+15 m/s are more than a tenth of the speed of light"},
    // What would be moved away from what stays.
    {bodies + phase + "remove_drift = true\n[[planes]]\npoint = [0, 0, -2]\n",
     "x.toml:11:1: phases.only.remove_drift: a wall of [[planes]] or [[boxes]] would stay"},
    {bodies + springs + "stiffness = 1e6\n[periodic]\nsize = [9, 9, 9]\n" + phase + by_springs +
         "remove_drift = true\n",
     "x.toml:18:1: phases.only.remove_drift: the box of [periodic] would stay"},
    {bodies + "fixed = true\n" + phase + "remove_drift = true\n",
     "x.toml:12:1: phases.only.remove_drift: groups.b, which is fixed, would stay"},
    // Bodies that never move.
    {bodies + "fixed = true\ntotal_mass = 5\n" + phase,
     "x.toml:12:14: groups.b.total_mass is that of a group which moves as prescribed or not"},
    {bodies + "fixed = true\nthermal_velocity = {rms = 1}\n" + phase,
     "x.toml:12:20: groups.b.thermal_velocity is of no use: the group is fixed or moved"},
    {bodies + "thermal_velocity = {rms = 1}\n" + phase,
     "x.toml:7:1: groups.b.thermal_velocity: without a drift one body that moves has none"},
    {bodies + "fixed = true\n[gravity]\nmethod = \"direct\"\n" + phase,
     "x.toml:7:1: groups.b.fixed: self-gravity needs finite masses"},
    {"[materials.rock]\ndensity = 1600\n[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nfixed = "
     "true\nvolume = {radius = 1}\n" +
         phase + impactor,
     "x.toml:12:12: phases.only.impactor: all groups are fixed or move as prescribed"},
    // Volumes and packings.
    {with_group("volume = {shape = \"box\", size = [1, 1, 1], center = [9, 0, 0]}\n"),
     "x.toml:14:10: groups.c.volume is not a sphere"},
    {with_group(
         "volume = {radius = 1, center = [9, 0, 0]}\npacking = {kind = \"hcp\", radius = 2}\n"),
     "x.toml:11:1: groups.c: its volume holds no sphere of radius 2 m"},
    {with_group("volume = {radius = 1, center = [4, 0, 0]}\n"),
     "x.toml:11:1: groups.c: body 2 at (4, 0, 0) m overlaps body 1 of groups.b at (3, 0, 0) m"},
    {with_group("volume = {radius = 9, center = [99, 0, 0]}\n"
                "packing = {kind = \"random\", radius = 0.1, count = 320000}\n"),
     "x.toml:11:1: groups.c: 320000 spheres of radius 0.1 m would be 0.439 of the volume; at "
     "random at most 0.4"},
    {with_group("volume = {radius = 1, center = [9, 0, 0]}\n"
                "packing = {kind = \"random\", radius = 0.3, count = 13}\n"),
     "x.toml:11:1: groups.c: 13 spheres of radius 0.3 m would be 0.351 of the volume; "},
    {with_group(
         "volume = {radius = 1}\npacking = {kind = \"random\", radius = 1, count = 5, sizes = "
         "{law = \"list\", radii = [1]}}\n"),
     "x.toml:15:38: groups.c.packing.radius is given beside sizes"},
    {with_group("volume = {radius = 1}\npacking = {kind = \"random\", count = 5, sizes = {law = "
                "\"power\", smallest = 2, largest = 1, exponent = 3}}\n"),
     "x.toml:15:88: groups.c.packing.sizes.largest is less than smallest"},
    {with_group("volume = {radius = 1}\npacking = {kind = \"random\", count = 5, sizes = {law = "
                "\"list\", radii = [1, 2], shares = [1]}}\n"),
     "x.toml:15:88: groups.c.packing.sizes.shares are not as many as radii"},
    {with_group("volume = {radius = 1}\npacking = {kind = \"random\", count = 5, sizes = {law = "
                "\"lognormal\", smallest = 1, largest = 2, median = 9, spread = 0.1}}\n"),
     "x.toml:15:104: groups.c.packing.sizes.median and spread leave less than a hundredth"},
    {with_group("volume = {radius = 1}\npacking = {kind = \"file\", file = \"gone.h5\"}\n"),
     "x.toml:11:1: groups.c: there is no file 'gone.h5'"},
    {bodies + "[periodic]\nsize = [4.5, 0, 0]\n" + springs + "stiffness = 1e6\n" + phase +
         by_springs,
     "x.toml:7:1: groups.b: body 1 at (3, 0, 0) m overlaps an image of body 0 of groups.a at (0, "
     "0, "
     "0) m by 0.5 m"},
    {with_group("volume = {shape = \"box\", size = [2, 2, 4], center = [9, 0, 0]}\n"
                "packing = {kind = \"simple_cubic\", radius = 1}\n") +
         by_springs + "[periodic]\nsize = [0, 0, 3.5]\n" + springs + "stiffness = 1e6\n",
     "x.toml:11:1: groups.c: body 3 at (9, 0, 1) m overlaps an image of body 2 of groups.c at (9, "
     "0, -1) m by 0.5 m"},
    // Walls.
    {bodies + springs +
         "stiffness = 1e6\n[periodic]\nsize = [9, 0, 0]\n[[planes]]\npoint = [0, 0, "
         "-9]\nnormal = [0.1, 0, 1]\n" +
         phase + by_springs,
     "x.toml: the wall \"plane_0\" does not run along x, which [periodic] repeats"},
    {bodies + springs +
         "stiffness = 1e6\n[periodic]\nsize = [9, 0, 0]\n[[cylinders]]\nradius = 30\n" + phase +
         by_springs,
     "x.toml: the wall \"cylinder_0\" does not run along x, which [periodic] repeats"},
    {bodies + phase + "[[planes]]\npoint = [0, 0, -0.5]\n",
     "x.toml:3:1: groups.a: body 0 at (0, 0, 0) m lies 0.5 m deep in the wall plane_0"},
    {bodies + springs + "stiffness = 1e6\n[[cylinders]]\nradius = 3\n" + phase + by_springs,
     "x.toml:7:1: groups.b: body 1 at (3, 0, 0) m lies 1 m deep in the wall cylinder_0"},
    {bodies + phase + "[[cylinders]]\nradius = 30\n",
     "x.toml:11:1: phases.only: [[cylinders]] and [periodic] act in phases of method = "
     "\"penalty\""},
    {bodies + law +
         "cutoff = 3\n[periodic]\nsize = [99, 99, 99]\n[gravity]\nmethod = \"direct\"\n" + phase +
         by_law,
     "x.toml:20:1: phases.only: [periodic] needs gravity.method"},
    {bodies + phase + impactor + "[[planes]]\npoint = [-1.5, 0, 0]\nnormal = [1, 0, 0]\n",
     "x.toml:15:12: phases.only.impactor: it begins 0.7 m deep in the wall plane_0"},
    {bodies + springs + "stiffness = 1e3\n[[cylinders]]\npoint = [1.5, 0, 0]\nradius = 2.5\n" +
         phase + by_springs +
         "impactor = {mass = 1, radius = 0.1, speed = \"0.2 m/s\", distance = 1}\n",
     "x.toml:24:12: phases.only.impactor: it begins 1.2 m deep in the wall cylinder_0"},
    {bodies + springs + "stiffness = 1e3\n[periodic]\nlow = [-2, 0, 0]\nsize = [8, 0, 0]\n" +
         phase + by_springs +
         "impactor = {mass = 1, radius = 0.1, speed = \"0.2 m/s\", distance = 1}\n",
     "x.toml:24:12: phases.only.impactor: it begins at (-2.1, 0, 0) m, outside of [periodic]"},
    // Images too near.
    {bodies + springs + "stiffness = 1e6\n[periodic]\nsize = [9, 3.9, 9]\n" + phase + by_springs,
     "x.toml:18:1: phases.only: periodic.size: 3.9 m in direction y is less than twice 2 m"},
    {bodies + law + "cutoff = 3\n[periodic]\nsize = [9, 9, 5]\n" + phase + by_law,
     "x.toml:18:1: phases.only: periodic.size: 5 m in direction z is less than twice 3 m"},
    // The impactor.
    {bodies + phase +
         "impactor = {mass = 1, radius = 0.1, speed = 1, offset = [0, 0, 5], distance = 1}\n",
     "x.toml:15:12: phases.only.impactor: the impactor misses"},
    {bodies + phase + coupled_by(""),
     "x.toml:15:81: phases.only.impactor.coupling.law needs ground"},
    {bodies + phase + coupled_by(", ground = \"mud\""),
     "x.toml:15:134: phases.only.impactor.coupling.ground is none of rock, weakly_cemented_basalt"},
    {bodies + phase + coupled_by(", ground = \"sand\", mu = 0.7"),
     "x.toml:15:147: phases.only.impactor.coupling.mu is not between 1/3 and 2/3"},
    {bodies + phase + coupled_by(", ground = \"sand\", n1 = 20"),
     "x.toml:15:12: phases.only.impactor.coupling.hand_over = 1 m lies within 2 m"},
    {bodies + phase + coupled_by(", ground = \"rock\", crater_radius = 0.5"),
     "x.toml:15:12: phases.only.impactor.coupling.hand_over = 1 m lies beyond 0.5 m"},
    {bodies + phase + coupled_by(", ground = \"sand\"") + "[[planes]]\npoint = [0, 0, -9]\n",
     "x.toml:15:12: phases.only.impactor.coupling: a wall would take a part of the recoil"},
    {bodies + phase + coupled_by(", ground = \"sand\"") +
         "[shapes.pair]\nspheres = [{at = [0, 0, 0], radius = 1}, {at = [1, 0, 0], radius = 1}]\n"
         "[[groups]]\nname = \"c\"\nmaterial = \"rock\"\nvolume = {radius = 1, center = [9, 0, "
         "0]}\n"
         "packing = {kind = \"single\", shape = \"pair\"}\n",
     "x.toml:15:12: phases.only.impactor.coupling: the flow is handed to spheres alone"},
    {bodies + phase +
         "impactor = {mass = 1, radius = 0.1, speed = 10, distance = 1, coupling = {law = "
         "\"point_source\", ground = \"sand\", density = 1601, hand_over = 1}}\n",
     "x.toml:15:12: phases.only.impactor.coupling.density = 1601 kg/m^3 is that of the ground"},
    {bodies + "[materials.impactor]\ndensity = 5\n" + phase + impactor,
     "x.toml:17:12: phases.only.impactor: its mass and radius give 238.732 kg/m^3"},
    // Motions that a step goes through straight on.
    {bodies + "motion.oscillation = {amplitude = [0, 0, 1], period = 0.007}\n" + phase,
     "x.toml:12:1: phases.only.step = 0.001 s is 0.143 of a turn or an oscillation"},
    {bodies + "motion.rotation = {axis = [0, 0, 1], rate = \"150 rev/s\"}\n" + phase,
     "x.toml:12:1: phases.only.step = 0.001 s is 0.15 of a turn or an oscillation"},
    {bodies +
         "motion.table = {times = [1, 1.0002, 1.0004], displacements = [[0, 0, 0], [0, 6, 0], "
         "[0, 0, 0]]}\n" +
         phase,
     "x.toml:12:1: phases.only.step = 0.001 s does not see 1 of the range of x.toml:"},
    {bodies +
         "motion.table = {times = [1, 1.0002, 1.0004, 1.0006], velocities = [[0, 0, 0], [0, 9, "
         "0], [0, -9, 0], [0, 0, 0]]}\n" +
         phase,
     "x.toml:12:1: phases.only.step = 0.001 s does not see 1 of the range of x.toml:"},
    // Angles are no coefficients.
    {bodies + "[contact]\nfriction = \"30 deg\"\n" + phase,
     "x.toml:12:12: contact.friction = \"30 deg\" is an angle; a number such as 0.5 is wanted"},
    {bodies + "[solver]\nprox = 1.5\n" + phase, "x.toml:12:8: solver.prox = 1.5"},
    // Methods.
    {bodies + "[contact]\nfriction = 0.5\n[solver]\nmethod = \"bb\"\n" + phase,
     "x.toml:15:1: phases.only: solver.method = \"apgd\" and \"bb\" minimise"},
    {bodies + phase + by_springs, "x.toml:11:1: phases.only.method = \"penalty\" needs [penalty]"},
    {bodies + "[penalty]\nmodel = \"hooke\"\nstiffness = 1e6\n" + phase + by_springs,
     "x.toml:14:1: phases.only.method = \"penalty\" needs contact.restitution > 0"},
    {bodies + "[contact]\nrestitution = 0.5\n[penalty]\n" + phase + by_springs,
     "x.toml:3:1: groups.a: penalty.model = \"hertz\" needs materials.rock.youngs_modulus"},
    {bodies + springs + "stiffness = 1e6\nrolling_friction = 0.1\n" + phase + by_springs,
     "x.toml:17:1: phases.only: penalty.rolling_friction needs contact.friction > 0"},
    {"read_out = [1]\n" + bodies + springs + "stiffness = 1e9\n" + phase + by_springs + impactor,
     "x.toml:17:1: phases.only.method = \"penalty\": read_out is for phases of"},
    {bodies + phase + by_law,
     "x.toml:11:1: phases.only.method = \"potential\" needs [pair_potential]"},
    {bodies + law + "cutoff = 3\n[contact]\ncohesion_range = 1\n" + phase + by_law +
         "cohesion = 1\n",
     "x.toml:18:1: phases.only.cohesion is that of contacts"},
    {bodies + "[materials.ice]\ndensity = 900\n" + law + "cutoff = 3\n" + between_rock_and_ice +
         between_rock_and_ice + phase + by_law,
     "x.toml:25:13: pair_potential.between.1.materials = rock and ice: told of before, at "
     "x.toml:19:13: pair_potential.between.0.materials"},
    {bodies + law + "breaking_strain = 0.1\n" + phase + by_law +
         "[[phases]]\nname = \"apart\"\nstep = 1\nduration = 1\n"
         "[[phases]]\nname = \"again\"\nstep = 1e-3\nduration = 1\n" +
         by_law,
     "x.toml:25:1: phases.again.method = \"potential\": phases.apart has moved the bodies of "
     "phases.only by another method, without their bonds and stresses"},
    // Steps that are too long, in the first phase and in a later one.
    {bodies + springs + "stiffness = 1e10\n" + phase + by_springs,
     "x.toml:16:1: phases.only: step = 0.001 s is too long for penalty contact: body "},
    {bodies + springs + "stiffness = 1e10\n" + phase +
         "[[phases]]\nname = \"later\"\nstep = 1e-3\n"
         "duration = 1\n" +
         by_springs,
     "x.toml:20:1: phases.later: step = 0.001 s is too long for penalty contact: body "},
    {"[contact]\nrestitution = 0.5\n[penalty]\nmodel = \"hertz\"\n" + bodies +
         "[materials.steel]\ndensity = 7800\n" + phase + by_springs,
     "x.toml:7:1: groups.a: penalty.model = \"hertz\" needs materials.rock.youngs_modulus"},
    {"materials.rock.youngs_modulus = 1e11\nmaterials.rock.density = 1600\n" +
         bodies.substr(bodies.find("[[groups]]")) + "[contact]\nrestitution = 0.5\n[penalty]\n" +
         phase + by_springs,
     "x.toml:14:1: phases.only: step = 0.001 s is too long for penalty contact: surface waves"},
    {bodies + law + "cutoff = 3\n" + phase.substr(0, phase.find("step")) +
         "step = 10\nduration = 100\n" + by_law,
     "x.toml:16:1: phases.only: step = 10 s is too long for the pair potential"},
    {bodies + law + "cutoff = 3\n" + phase +
         "[[phases]]\nname = \"later\"\nstep = 10\nduration = 20\n" + by_law +
         "impactor = {mass = 1, radius = 1, speed = \"1 km/s\", distance = 1}\n",
     "x.toml:20:1: phases.later: step = 10 s is too long for the pair potential"},
    // Of groups that are slow at the start, or move in a later phase alone.
    {bodies + shaken + springs + "stiffness = 1e6\n" + phase + by_springs,
     "x.toml:17:1: phases.only: body "},
    {bodies + struck + springs + "stiffness = 1e6\n" + phase + by_springs,
     "x.toml:17:1: phases.only: body "},
    {bodies + struck_later + springs + "stiffness = 1e6\n" + phase + by_springs +
         "[[phases]]\nname = \"later\"\n"
         "step = \"1 ms\"\nduration = \"10 s\"\n" +
         by_springs,
     "x.toml:22:1: phases.later: body "},
    {bodies + shaken + law + "cutoff = 3\n" + phase + by_law,
     "x.toml:17:1: phases.only: in a step = 0.001 s two bodies come 6.28 m nearer"},
    // Numbers that are none.
    {bodies + "[[phases]]\nname = \"only\"\nstep = 1e-300\nduration = 1\n",
     "x.toml:13:8: phases.only.step = 1e-300 s: a size from 1e-50 to 1e+50, or 0, is wanted"},
    {bodies + "[[phases]]\nname = \"only\"\nstep = 1e-12\nduration = \"1 h\"\n",
     "x.toml:13:8: phases.only.step = 1e-12 s makes 3.6e+15 steps of the duration; "},
    {bodies + "velocity = [1e160, 0, 0]\n" + phase,
     "x.toml:11:12: groups.b.velocity = 1e+160 m/s: a size from 1e-50 to 1e+50, or 0, is wanted"},
    {with_group("volume = {radius = \"1e308 km\"}\n"),
     "x.toml:14:20: groups.c.volume.radius = \"1e308 km\" is beyond the numbers that are reckoned "
     "with"},
    {with_group("volume = {shape = \"box\", size = [1, 1, 1], center = [9, 0, 0]}\n"
                "packing = {kind = \"fcc\", radius = \"1 nm\"}\n"),
     "x.toml:11:1: groups.c: a lattice of 2e-09 m in its volume has about 1.3e+26 sites; at most "
     "2147483647 can be"},
    {with_group("volume = {radius = 1, center = [9, 0, 0]}\n"
                "packing = {kind = \"random\", radius = \"1 um\", count = 1000000000000}\n"),
     "x.toml:15:54: groups.c.packing.count = 1000000000000: a group has at most 2147483647"},
    {with_group("volume = {radius = 1, center = [9, 0, 0]}\npacking = {kind = \"graded\", radius = "
                "\"1 um\", smallest = \"1 um\", growth = 1}\n"),
     "x.toml:11:1: groups.c: about 8.4e+16 spheres of radius 1e-06 m are wanted; at most "
     "2147483647 can be"},
    {bodies + "[gravity]\nmethod = \"direct\"\nmap = {size = [1, 1, 1], spacing = 1e-5}\n" + phase,
     "x.toml:13:7: gravity.map has 1e+15 points; at most 1000000000 are written"},
    {bodies + "[[phases]]\nname = \"..\"\nstep = 1\nduration = 1\n",
     "x.toml:12:8: phases....name cannot be part of a file's name"},
    {bodies + "[[phases]]\nname = \"" + std::string(101, 'n') + "\"\nstep = 1\nduration = 1\n",
     "x.toml:12:8: phases." + std::string(101, 'n') + ".name cannot be part of a file's name"},
    {"title = \"deep\"\n" + nested(50'000) + " = 1\n" + bodies + phase,
     "x.toml:2: a key has more than 1000 parts"},
    {"[" + nested(50'000) + "]\n", "x.toml:1: a key has more than 1000 parts"},
    {"a = " + std::string(50'000, '['),
     "x.toml:1:261: Error while parsing value: exceeded maximum"},
};

TEST(Refusals, are_those_of_check_and_of_run_alike_with_file_line_and_key) {
  const Comm comm = testing_world();
  const std::string folder = (std::filesystem::temp_directory_path() /
                              fmt::format("spall_refusals_{}", comm.sum(std::int64_t{getpid()})))
                                 .string();
  for (const auto& [text, message] : table) {
    const std::string checked = complaint_of([&] { check_case(comm, parse_case(text, "x.toml")); });
    EXPECT_TRUE(checked.starts_with(message)) << checked << "\n  instead of\n" << message;
    EXPECT_LT(checked.size(), 600u);
    EXPECT_EQ(complaint_of([&] { run_case(comm, parse_case(text, "x.toml"), folder); }), checked);
    comm.any(false);  // rank 0 has taken it away
    EXPECT_FALSE(std::filesystem::exists(folder)) << message << "\n  left files";
    comm.any(false);  // rank 0 may make the next one
  }
  EXPECT_GE(table.size(), 40u);
}

TEST(Refusals, name_a_folder_whose_path_leaves_no_room_for_files) {
  const Comm comm = testing_world();
  std::string folder = "out";
  while (folder.size() < 4000) folder += "/" + std::string(40, 'd');
  const std::string told =
      complaint_of([&] { run_case(comm, parse_case(bodies + phase, "x.toml"), folder); });
  EXPECT_TRUE(told.starts_with("the path of the folder for results has 4021 signs, more than"))
      << told;
  EXPECT_FALSE(std::filesystem::exists("out"));
}

/// What a run that goes on says to a change: after 2 s of the second phase, 0.5 s after the impact.
TEST(Refusals, are_of_changes_of_what_lies_behind_a_run_that_goes_on) {
  RestartState state;
  state.case_file = "x.toml";
  const std::string second = "[[phases]]\nname = \"hit\"\nstep = \"1 ms\"\nduration = \"9 s\"\n";
  const std::string third = "[[phases]]\nname = \"rest\"\nstep = \"1 ms\"\nduration = \"9 s\"\n";
  state.case_text = "read_out = [0.25, 5]\n[contact]\ncohesion_range = 1\n" + bodies + phase +
                    second + impactor + third;
  state.overrides = {"seed=5", "phases.only.cohesion=1 N", "phases.only.cohesion=2 N"};
  state.clock = {.step = 12000,
                 .phase = 1,
                 .step_in_phase = 2000,
                 .time = 12,
                 .time_in_phase = 2,
                 .since_impact = 2};
  const auto told = [&](const std::string& change) {
    return complaint_of([&] { case_to_go_on(testing_world(), state, {change}, {}); });
  };
  for (const auto& [change, message] : std::vector<std::pair<std::string, std::string>>{
           {"seed=7", "the bodies are made already"},
           {"groups.a.volume.radius=2", "the bodies are made already"},
           {"groups.0.velocity=[1, 0, 0]", "the bodies are made already"},
           {"allowed_overlap=0.1", "the bodies are made already"},
           {"shapes.rod.count=3", "the bodies are made already"},
           {"materials.rock.density=5", "bodies have their masses already"},
           {"materials.rock.solid.distension=2", "bodies have their masses already"},
           {"periodic.size=[9, 9, 9]", "bodies and their images lie in the box so far"},
           {"contact.cohesion=5", "cohesion is that of the phases so far"},
           {"phases.only.step=1 s", "phase only is over"},
           {"phases.0.duration=1 h", "phase only is over"},
           {"phases.only.cohesion=1 N", "phase only is over"},  // it was told otherwise later
           {"phases.hit.cohesion=5 N", "phase hit has begun; cohesion is asked for when it begins"},
           {"phases.1.impactor.mass=5", "phase hit has begun; impactor is asked for"},
           {"phases.hit.remove_drift=true", "phase hit has begun; remove_drift is asked for"},
           {"phases.hit.method=penalty", "phase hit has begun; method is asked for"},
       }) {
    const std::string whole = "--set " + change + ": " + message;
    EXPECT_TRUE(told(change).starts_with(whole)) << told(change) << "\n  instead of\n" << whole;
  }
  EXPECT_TRUE(told("read_out=[1, 5]")
                  .ends_with("read_out: 1 s is over: the run goes on 2 s after "
                             "the impactor was added"))
      << told("read_out=[1, 5]");
  for (const char* change :
       {"seed=5", "phases.only.cohesion=2 N", "read_out=[0.25, 3]", "phases.hit.step=1 us",
        "phases.hit.duration=8 s", "phases.rest.cohesion=5 N", "phases.rest.remove_drift=true",
        "contact.friction=1", "materials.rock.youngs_modulus=1 GPa", "title=other"})
    EXPECT_EQ(told(change), "") << change;
  state.clock = {};  // before the first step all phases can be told, and the impactor's density
  EXPECT_EQ(told("phases.only.remove_drift=true"), "");
}

TEST(Refusals, are_of_walls_that_a_run_which_goes_on_would_move_into_bodies) {
  const Comm comm = testing_world();
  const std::string folder = (std::filesystem::temp_directory_path() /
                              fmt::format("spall_walls_{}", comm.sum(std::int64_t{getpid()})))
                                 .string();
  const std::string floor = "[[planes]]\nname = \"floor\"\npoint = [0, 0, -1.0005]\n";
  const std::string second = "[[phases]]\nname = \"later\"\nstep = 1\nduration = 1\n";
  run_case(comm, parse_case(bodies + floor + phase + second, "x.toml"), folder);
  comm.any(false);  // rank 0 has written it
  const auto told = [&](const std::string& change) {
    return complaint_of([&] {
      resume_case(comm, folder + "/after_only.h5",
                  {folder + "/resumed", Former::overwrite, {change}, false});
    });
  };
  const std::string message = "x.toml: body 1 lies in a wall where --set has moved it to";
  EXPECT_TRUE(told("planes.floor.point=[0, 0, -0.9]").starts_with(message));
  EXPECT_EQ(told("planes.floor.point=[0, 0, -5]"), "");
  for (const char* others : {"planes=[]", "planes=[{name=\"lid\", point=[0, 0, -5]}]"})
    EXPECT_TRUE(told(others).starts_with("x.toml: --set adds or takes away walls")) << others;
  comm.any(false);
  if (comm.rank == 0) std::filesystem::remove_all(folder);
}

TEST(Refusals, are_of_another_cohesion_by_a_materials_constants) {
  RestartState state;
  state.case_file = "x.toml";
  state.case_text = R"([materials.rock.solid]
density = 2000
sound_speed = 3000
hugoniot_slope = 1.5
gruneisen = 1
youngs_modulus = 1e10
poisson_ratio = 0.25
yield_strength = 10
tensile_strength = 10
[contact]
material = "rock"
cohesion_range = 0.1
[[groups]]
name = "a"
material = "rock"
volume = {shape = "box", size = [4, 2, 2]}
packing = {kind = "fcc", radius = 1}
)" + phase;
  state.clock = {.step = 1, .phase = 0, .step_in_phase = 1, .time = 1, .time_in_phase = 1};
  const auto told = [&](const std::string& change) {
    return complaint_of([&] { case_to_go_on(testing_world(), state, {change}, {}); });
  };
  EXPECT_TRUE(told("materials.rock.solid.tensile_strength=1e4")
                  .starts_with("x.toml: --set changes the cohesion that follows from "
                               "materials.rock, "))
      << told("materials.rock.solid.tensile_strength=1e4");
  EXPECT_EQ(told("materials.rock.solid.specific_heat=900"), "");
}

TEST(Refusals, are_not_of_what_is_modelled) {
  const Comm comm = testing_world();
  // Debris may fly on by another method, and is told to fall apart; a fluid has no bonds.
  const std::string flight = "[[phases]]\nname = \"apart\"\nstep = 1\nduration = 1\n";
  const std::string again = "[[phases]]\nname = \"again\"\nstep = 1e-3\nduration = 1\n" + by_law;
  const std::string torn = bodies + law + "breaking_strain = 0.1\n" + phase + by_law + flight;
  const std::string told = "phases.apart: bonds and stresses of method = \"potential\" end here";
  EXPECT_NE(check_case(comm, parse_case(torn, "x.toml")).find(told), std::string::npos);
  const std::string fluid = bodies + law + "cutoff = 3\n" + phase + by_law + flight + again;
  EXPECT_EQ(check_case(comm, parse_case(fluid, "x.toml")).find(told), std::string::npos);
  const auto complaint = [&](const std::string& text) {
    return complaint_of([&] { check_case(comm, parse_case(text, "x.toml")); });
  };
  EXPECT_EQ(complaint(bodies + phase), "");
  // Two walls never meet, so that nothing is asked of their pair.
  const std::string between =
      "[[contact.between]]\nmaterials = [\"rock\", \"{}\"]\nrestitution = 0.5\n";
  const std::string floor =
      "[materials.floor]\ndensity = 1\n[[planes]]\nmaterial = \"floor\"\npoint = [0, 0, -2]\n";
  const std::string steps =
      "[[phases]]\nname = \"only\"\nstep = 1e-4\nduration = 1e-3\n" + by_springs;
  EXPECT_EQ(complaint(bodies + "[contact]\nfriction = 0.5\n" +
                      fmt::format(fmt::runtime(between), "rock") +
                      fmt::format(fmt::runtime(between), "floor") +
                      "[penalty]\nmodel = \"hooke\"\nstiffness = 1e8\n" + floor + steps),
            "");
  // A ball is pressed into a wall more deeply than into another ball: by sqrt(2).
  const std::string moving = bodies +
                             "velocity = [0, 0, -10]\n[contact]\nrestitution = 1\n[penalty]\n"
                             "model = \"hooke\"\nstiffness = 1.4e6\n" +
                             steps;
  EXPECT_EQ(complaint(moving), "");
  EXPECT_NE(complaint(moving + "[[planes]]\npoint = [0, 0, -2]\n")
                .find("and a wall would pass into each other by 0.69"),
            std::string::npos);
}

}  // namespace
}  // namespace spall
