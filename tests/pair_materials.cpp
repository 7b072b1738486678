// Laws by pair of materials in contacts: rock on ice, steel on aluminium, and what is refused.
// SPDX-License-Identifier: BSD-3-Clause
#include <array>

#include "penalty_worlds.hpp"
#include "run/simulation.hpp"

namespace spall {
namespace {

constexpr int ice = 0, rock = 1;  // as a case has them: in the order of their names

/// Body k is of material `of[k]`.
void set_materials(Lab& world, const std::vector<int>& of) {
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.material[b] = of[world.bodies.id[b] % of.size()];
}

/// Rock on rock, rock on ice, ice on ice.
const std::array<ContactLaw, 3> three{{{.friction = 0.5, .restitution = 0.9},
                                       {.friction = 0.2, .restitution = 0.7},
                                       {.friction = 0.05, .restitution = 0.4}}};
ByPair<ContactLaw> three_laws() {
  ByPair<ContactLaw> laws(2, three[0]);
  laws.set(rock, ice, three[1]);
  laws.set(ice, ice, three[2]);
  return laws;
}

/// Three pairs that hit each other at 1 m/s, far apart, and slide at 10 m/s as they do.
std::vector<Sphere> three_oblique_hits(double gap) {
  std::vector<Sphere> spheres;
  for (int k = 0; k < 3; ++k) {
    spheres.push_back({.mass = 2, .position = {0, 100.0 * k, 0}, .velocity = {1, 0, 10}});
    spheres.push_back({.mass = 3, .position = {2 + gap, 100.0 * k, 10 * gap}});
  }
  return spheres;
}
const std::vector<int> of_hits{rock, rock, rock, ice, ice, ice};

void expect_pairs_own_restitution_and_friction(const std::vector<Sphere>& before,
                                               const std::vector<Sphere>& after, double within) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Sphere &a = after[2 * k], &b = after[2 * k + 1];
    const Vec3 n = Vec3::UnitX();
    const Vec3 u = b.velocity - a.velocity;
    EXPECT_NEAR(u.dot(n), three[k].restitution, within) << k;
    const Vec3 impulse = b.mass * (b.velocity - before[2 * k + 1].velocity);
    EXPECT_NEAR(impulse.z(), three[k].friction * impulse.x(), within * impulse.x()) << k;
  }
}

TEST(PairMaterials, rigid_spheres_of_each_pair_have_their_own_restitution_and_friction) {
  const auto spheres = three_oblique_hits(0);
  Lab world = make_world(testing_world(), spheres, {});
  world.contact = three_laws();
  set_materials(world, of_hits);
  advance(world, 1e-6, 1);
  // The normal turns by 1e-5 while they touch in a step of 1e-6 s.
  expect_pairs_own_restitution_and_friction(spheres, spheres_of(world), 1e-5);
}

TEST(PairMaterials, penalty_spheres_of_each_pair_have_their_own_restitution_and_friction) {
  // Stiff: they touch for 0.1 ms, in which the normal turns by a thousandth.
  const double h = 1e-7;
  const auto spheres = three_oblique_hits(0);
  Lab world =
      penalty_world(testing_world(), spheres, {.model = PenaltyModel::hooke, .stiffness = 1e9}, {});
  world.materials = {{.name = "ice"}, {.name = "rock"}};
  world.contact = three_laws();
  set_materials(world, of_hits);
  penalty_steps(world, h, 2000);
  // Before they part the dashpot pulls for a moment, and friction acts on that as well.
  expect_pairs_own_restitution_and_friction(spheres, spheres_of(world), 0.02);
}

TEST(PairMaterials, walls_are_of_the_body_s_material_or_of_their_own) {
  // From a floor without a material up to a ceiling of ice.
  for (bool rigid : {true, false}) {
    const double h = rigid ? 1e-3 : 1e-6;
    Lab world = penalty_world(testing_world(),
                              {{.radius = 0.1, .position = {0, 0, 0.1}, .velocity = {0, 0, -1}},
                               {.radius = 0.1, .position = {5, 0, 0.1}, .velocity = {0, 0, -1}},
                               {.radius = 0.1, .position = {10, 0, 1.9}, .velocity = {0, 0, 1}},
                               {.radius = 0.1, .position = {15, 0, 1.9}, .velocity = {0, 0, 1}}},
                              {.model = PenaltyModel::hooke, .stiffness = 1e9}, {});
    world.materials = {{.name = "ice"}, {.name = "rock"}};
    world.contact = three_laws();
    set_materials(world, {rock, ice});
    world.planes = {{}, {.point = {0, 0, 2}, .normal = {0, 0, -1}, .material = ice}};
    if (rigid)
      advance(world, h, 2);
    else
      penalty_steps(world, h, 500);
    const auto after = spheres_of(world);
    const double within = rigid ? 1e-9 : 0.02;
    EXPECT_NEAR(after[0].velocity.z(), three[0].restitution, within);
    EXPECT_NEAR(after[1].velocity.z(), three[2].restitution, within);
    EXPECT_NEAR(after[2].velocity.z(), -three[1].restitution, within);
    EXPECT_NEAR(after[3].velocity.z(), -three[2].restitution, within);
  }
}

TEST(PairMaterials, mixed_moduli_are_hertz_s_and_mindlin_s_and_those_of_one_material_exact) {
  const Material steel{.name = "steel", .youngs_modulus = 210e9, .poisson_ratio = 0.3};
  const Material aluminium{.name = "aluminium", .youngs_modulus = 69e9, .poisson_ratio = 0.33};
  const ContactLaw contact{.restitution = 0.5};
  for (const Material& m : {steel, aluminium, soft_rock}) {
    const double e = m.youngs_modulus, nu = m.poisson_ratio;
    const PenaltyLaw law = penalty_law({}, contact, m, m);
    EXPECT_EQ(law.normal, e / (2 * (1 - nu * nu)));
    EXPECT_EQ(law.tangential, 2 * e / ((2 - nu) * (1 + nu)));
  }
  const PenaltyLaw mixed = penalty_law({}, contact, steel, aluminium);
  const double contact_modulus = 1 / ((1 - 0.09) / 210e9 + (1 - 0.33 * 0.33) / 69e9);
  const double shear = 1 / (2 * (2 - 0.3) * (1 + 0.3) / 210e9 + 2 * (2 - 0.33) * (1 + 0.33) / 69e9);
  EXPECT_NEAR(mixed.normal, contact_modulus, 1e-14 * contact_modulus);
  EXPECT_NEAR(mixed.tangential, 8 * shear, 1e-14 * 8 * shear);
}

TEST(PairMaterials, steel_on_aluminium_is_hertz_s_collision) {
  const double r1 = 0.01, r2 = 0.02, speed = 0.5;
  const double m1 = 7850 * 4 / 3.0 * pi * r1 * r1 * r1, m2 = 2700 * 4 / 3.0 * pi * r2 * r2 * r2;
  const double r = r1 * r2 / (r1 + r2), m = m1 * m2 / (m1 + m2);
  const double modulus = 1 / ((1 - 0.09) / 210e9 + (1 - 0.33 * 0.33) / 69e9);
  const double deepest = std::pow(15 * m * speed * speed / (16 * modulus * std::sqrt(r)), 0.4);
  // T = 2.9432 delta/v (Johnson, Contact Mechanics, 1985, eq. 11.24).
  const double lasts = 2.9432 * deepest / speed, h = lasts / 2000;
  for (double e : {1.0, 0.6}) {
    Lab world = penalty_world(
        testing_world(),
        {{.radius = r1, .mass = m1, .position = {-r1, 0, 0}, .velocity = {speed, 0, 0}},
         {.radius = r2, .mass = m2, .position = {r2, 0, 0}},
         {.radius = r2, .mass = m2, .position = {1, 0, 0}}},
        {}, {});
    world.materials = {{.name = "steel", .youngs_modulus = 210e9, .poisson_ratio = 0.3},
                       {.name = "aluminium", .youngs_modulus = 69e9, .poisson_ratio = 0.33}};
    ByPair<ContactLaw> laws(2, ContactLaw{.restitution = 0.1});
    laws.set(0, 1, {.restitution = e});
    world.contact = laws;
    set_materials(world, {0, 1, 1});
    double overlap = 0, touched = 0;
    for (int step = 0; step < 2500; ++step) {
      penalty_steps(world, h, 1);
      const auto s = spheres_of(world);
      const double now = r1 + r2 - (s[1].position - s[0].position).norm();
      overlap = std::max(overlap, now);
      if (now > 0) touched += h;
    }
    const auto s = spheres_of(world);
    EXPECT_NEAR((s[1].velocity - s[0].velocity).x(), e * speed, 5e-3 * speed) << e;
    if (e < 1) continue;
    EXPECT_NEAR(overlap, deepest, 1e-3 * deepest);
    EXPECT_NEAR(touched, lasts, 2e-3 * lasts);
  }
}

TEST(PairMaterials, two_materials_with_the_same_constants_move_as_one_to_the_last_bit) {
  // A third material, with another law, keeps the table from becoming a single law.
  auto spheres = crowd(80, 0.2, 1.0);
  spheres.push_back({.mass = 1000, .position = {40, 0, 0}});
  const ContactLaw law{.friction = 0.5, .restitution = 0.6, .cohesion = 10, .cohesion_range = 0.1};
  std::vector<int> of(spheres.size());
  for (std::size_t k = 0; k < of.size(); ++k) of[k] = static_cast<int>(k % 2);
  of.back() = 2;
  for (bool rigid : {true, false})
    for (Adhesion adhesion : {Adhesion::none, Adhesion::dmt, Adhesion::jkr}) {
      if (rigid && adhesion != Adhesion::none) continue;
      const double h = rigid ? 1e-2 : 2e-4;
      const auto ends = [&](bool by_pair) {
        Lab world = penalty_world(
            testing_world(), spheres,
            {.rolling_friction = 0.1, .adhesion = adhesion, .adhesion_strength = 50}, law);
        if (by_pair) {
          world.materials = {soft_rock, soft_rock, soft_rock};
          ByPair<ContactLaw> laws(3, law);
          laws.set(2, 2, {.friction = 0.1, .restitution = 0.2});
          world.contact = laws;
          set_materials(world, of);
        }
        if (rigid)
          advance(world, h, 20, {.tolerance = 1e-6});
        else
          penalty_steps(world, h, 200);
        return spheres_of(world);
      };
      const auto one = ends(false), two = ends(true);
      for (std::size_t k = 0; k < one.size(); ++k) {
        EXPECT_EQ(one[k].velocity, two[k].velocity) << k << rigid;
        EXPECT_EQ(one[k].spin, two[k].spin) << k << rigid;
      }
    }
}

TEST(PairMaterials, a_pair_holds_by_its_own_cohesion) {
  // Below a fixed sphere of rock hang one of ice and one of rock, which the default does not hold.
  const double strength = 1000;
  for (bool rigid : {true, false})
    for (double part : {0.8, 1.1}) {
      Lab world = penalty_world(testing_world(),
                                {{.radius = 0.5, .mass = infinity},
                                 {.radius = 0.5, .mass = 1000, .position = {0, 0, -1}},
                                 {.radius = 0.5, .mass = infinity, .position = {9, 0, 0}},
                                 {.radius = 0.5, .mass = 1000, .position = {9, 0, -1}}},
                                {.model = PenaltyModel::hooke, .stiffness = 1e7}, {});
      world.materials = {{.name = "ice"}, {.name = "rock"}};
      ByPair<ContactLaw> laws(2, ContactLaw{.restitution = 0.5});
      laws.set(rock, ice, {.restitution = 0.5, .cohesion = strength, .cohesion_range = 0.01});
      world.contact = laws;
      set_materials(world, {rock, ice, rock, rock});
      world.uniform_gravity = {0, 0, -part * strength / 1000};
      if (rigid)
        advance(world, 1e-2, 100);
      else
        for (int k = 0; k < 5000; ++k) penalty_steps(world, 2e-4, 1);
      const auto s = spheres_of(world);
      EXPECT_EQ(s[1].position.z() > -1.005, part < 1) << rigid << " " << s[1].position.z();
      EXPECT_LT(s[3].position.z(), -1.2) << rigid;
    }
}

const std::string scene = R"([materials.rock]
density = 2000
youngs_modulus = 1e8
[materials.ice]
density = 900
youngs_modulus = 2e7
[contact]
friction = 0.5
restitution = 0.3
cohesion = 1
cohesion_range = "1 cm"
[[contact.between]]
materials = ["ice", "rock"]
friction = 0.1
cohesion = 7
[[contact.between]]
materials = ["ice", "ice"]
restitution = 0.8
[penalty]
rolling_friction = 0.1
[[penalty.between]]
materials = ["rock", "ice"]
rolling_friction = 0.2
[[planes]]
material = "ice"
point = [0, 0, -1]
[gravity]
uniform = [0, 0, -9.81]
[[groups]]
name = "a"
material = "rock"
volume = {shape = "box", size = [4, 4, 1]}
packing = {kind = "random", radius = 0.2, count = 20}
[[groups]]
name = "b"
material = "ice"
volume = {shape = "box", size = [4, 4, 1], center = [0, 0, 1.5]}
packing = {kind = "random", radius = 0.2, count = 20}
[[phases]]
name = "fall"
method = "METHOD"
step = "0.2 ms"
duration = "20 ms"
[[phases]]
name = "stick"
method = "METHOD"
step = "0.2 ms"
duration = 1
cohesion = 5
)";
std::string with_method(const std::string& method, std::string text = scene) {
  for (std::size_t at; (at = text.find("METHOD")) != text.npos;) text.replace(at, 6, method);
  return text;
}

TEST(PairMaterials, a_case_gives_the_default_and_what_differs) {
  const Case read = parse_case(with_method("penalty"), "x.toml");
  EXPECT_EQ(read.contact(rock, rock).friction, 0.5);
  EXPECT_EQ(read.contact(rock, ice).friction, 0.1);
  EXPECT_EQ(read.contact(ice, rock).restitution, 0.3);
  EXPECT_EQ(read.contact(ice, ice).restitution, 0.8);
  EXPECT_EQ(read.planes[0].material, ice);
  ByPair<ContactLaw> laws = read.contact;
  set_cohesion(laws, 5);
  EXPECT_EQ(laws(rock, rock).cohesion, 5);
  EXPECT_EQ(laws(ice, ice).cohesion, 5);  // tells none of its own
  EXPECT_EQ(laws(rock, ice).cohesion, 7);
  EXPECT_EQ(laws(rock, ice).cohesion_range, 0.01);
  // The impactor's material is known by its name, whether or not the case has it.
  const std::string hit = "impactor = {mass = 1, radius = 0.1, speed = 10}\n";
  const std::string more = "[[contact.between]]\nmaterials = [\"impactor\", \"ice\"]\n";
  const Case third = parse_case(with_method("nonsmooth") + hit + more + "friction = 0.9\n", "x");
  EXPECT_EQ(third.contact(third.phases[1].impactor->material, ice).friction, 0.9);
  const std::string own = "[materials.impactor]\nyoungs_modulus = 1e9\ndensity = 238.732414638\n";
  EXPECT_EQ(parse_case(with_method("penalty") + hit + own, "x").materials.size(), 3u);
}

TEST(PairMaterials, mistakes_name_file_line_and_key) {
  struct Mistake {
    std::string was, is, message;
  };
  const std::vector<Mistake> mistakes{
      {"[\"ice\", \"rock\"]", "[\"ice\", \"iron\"]",
       "x.toml:13:13: contact.between.0.materials: \"iron\" is not in [materials]"},
      {"[\"ice\", \"rock\"]", "\"ice\"",
       "x.toml:13:13: contact.between.0.materials is not two names, such as [\"rock\", \"ice\"]"},
      {"[\"ice\", \"ice\"]", "[\"rock\", \"ice\"]",
       "x.toml:17:13: contact.between.1.materials = rock and ice: told of before, at "
       "x.toml:13:13: contact.between.0.materials"},
      {"materials = [\"ice\", \"rock\"]\n", "",
       "x.toml:12:1: contact.between.0.materials is missing"},
      {"friction = 0.1\n", "frictoin = 0.1\n",
       "x.toml:14:1: contact.between.0.frictoin is not a key here; did you mean "
       "contact.between.0.friction?"},
      {"cohesion = 1\ncohesion_range = \"1 cm\"", "",
       "x.toml:12:13: contact.between.0.materials: its cohesion needs a cohesion_range: the gap up "
       "to which it acts"},
      {"[\"rock\", \"ice\"]\nrolling", "[\"rock\", \"iron\"]\nrolling",
       "x.toml:22:13: penalty.between.0.materials: \"iron\" is not in [materials]"},
      {"[penalty]", "[penalty]\nyoung_modulus = 1e8",
       "x.toml:20:17: penalty.young_modulus is the materials' now: write [materials.NAME] "
       "youngs_modulus, poisson_ratio"},
      {"rolling_friction = 0.2", "adhesion = \"jkr\"",
       "x.toml:23:1: penalty.between.0.adhesion is not a key here; the keys here are materials, "
       "rolling_friction"},
      {"youngs_modulus = 2e7\n", "",
       "x.toml:33:1: groups.b: penalty.model = \"hertz\" needs materials.ice.youngs_modulus"},
      {"restitution = 0.8", "restitution = 0",
       "x.toml:39:1: phases.fall.method = \"penalty\" needs contact.restitution > 0 between ice "
       "and "
       "ice: it sets the damping"},
      {"friction = 0.1\n", "friction = 0\n",
       "x.toml:39:1: phases.fall: penalty.rolling_friction needs contact.friction > 0 between rock "
       "and "
       "ice: bodies without it slide"},
      {"material = \"ice\"\npoint", "material = \"iron\"\npoint",
       "x.toml:25:12: planes.0.material = \"iron\" is not in [materials]"},
      {"cohesion = 5\n", "cohesion = 5\nimpactor = {mass = 1, radius = 0.1, speed = 10}\n",
       "x.toml:50:12: phases.stick.impactor: penalty.model = \"hertz\" needs "
       "materials.impactor.youngs_modulus"},
  };
  for (const Mistake& m : mistakes) {
    std::string text = with_method("penalty");
    const std::size_t at = text.find(m.was);
    ASSERT_NE(at, text.npos) << m.was;
    text.replace(at, m.was.size(), m.is);
    EXPECT_EQ(complaint_of([&] { parse_case(text, "x.toml"); }), m.message) << m.is;
  }
}

TEST(PairMaterials, a_restart_goes_on_to_the_same_bits_with_the_event_s_cohesion) {
  for (const char* method : {"nonsmooth", "penalty"}) {
    const Case read = parse_case(with_method(method), "x.toml");
    const Scene parts(std::make_shared<Case>(read));
    Simulation first(testing_world(), parts);
    const auto go = [](Simulation& one, int steps) {
      for (const auto end = one.clock().step + steps; one.clock().step < end;) {
        if (one.clock().step_in_phase == 0) one.begin_phase();
        one.advance(static_cast<int>(std::min(end - one.clock().step, one.steps_left())), true);
        if (one.steps_left() == 0) one.end_phase();
      }
    };
    go(first, 150);
    RestartState state = first.save();
    Simulation second(testing_world(), parts, state);
    EXPECT_EQ(second.world().contact(rock, rock).cohesion, 5);
    EXPECT_EQ(second.world().contact(rock, ice).cohesion, 7);
    first.go_on(state);
    go(first, 50);
    go(second, 50);
    ASSERT_EQ(first.world().bodies.owned, second.world().bodies.owned);
    for (Index b = 0; b < first.world().bodies.owned; ++b) {
      EXPECT_EQ(first.world().bodies.id[b], second.world().bodies.id[b]);
      EXPECT_EQ(first.world().bodies.position[b], second.world().bodies.position[b]) << method;
      EXPECT_EQ(first.world().bodies.velocity[b], second.world().bodies.velocity[b]) << method;
    }
  }
}

}  // namespace
}  // namespace spall
