// The bodies of a case: the same on any number of ranks, clear of each other, of the right mass.
// SPDX-License-Identifier: BSD-3-Clause
#include "scene/scene.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

#include "scene/impactor.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

Case parse(const std::string& groups) {
  return parse_case("materials.rock.density = 1600\n" + groups +
                        "[[phases]]\nname = \"only\"\nstep = 1\nduration = 1\n",
                    "x.toml");
}

const char* const nucleus_and_boulders = R"(
[[groups]]
name = "nucleus"
material = "rock"
volume = {radius = "7 m", center = [1, 2, 3]}
fixed = true
[[groups]]
name = "crust"
material = "rock"
volume = {shape = "sphere", radius = "10 m", center = [1, 2, 3]}
packing = {kind = "random", radius = "0.5 m", count = 700}
velocity = [4, 0, 0]
spin = [0, 0, 0.5]
[[groups]]
name = "plate"
material = "rock"
volume = {shape = "box", size = [4, 20, 20], center = [-20, 0, 0]}
packing = {kind = "fcc", radius = 0.5}
total_mass = "1e6 kg"
[[planes]]
point = [0, 0, -10]
)";

Bodies all_on_this_rank(const Case& scene) {
  return make_bodies(scene, Comm(MPI_COMM_SELF));
}

std::string complaint(const Case& scene, const Comm& comm) {
  return complaint_of([&] { make_bodies(scene, comm); });
}

TEST(Scene, random_bodies_keep_clear_of_images) {
  // A sphere that stands out of the box at one end, and others at the other end.
  const Case scene = parse_case(R"(
materials.rock.density = 1600
[contact]
restitution = 0.5
[penalty]
model = "hooke"
stiffness = 1
[periodic]
low = [-5, 0, -30]
size = [10, 0, 6]
[[groups]]
name = "one"
material = "rock"
volume = {radius = 1, center = [4.8, 0, 0]}
[[groups]]
name = "many"
material = "rock"
volume = {shape = "box", size = [2, 3, 9], center = [-4, 0, 0]}
packing = {kind = "random", radius = 0.4, count = 30}
[[phases]]
name = "only"
method = "penalty"
step = 1
duration = 1
)",
                                "x.toml");
  const Bodies bodies = all_on_this_rank(scene);
  ASSERT_EQ(bodies.owned, 31);
  for (Index a = 0; a < bodies.owned; ++a)
    for (Index b = 0; b < a; ++b) {
      const Vec3 image = scene.period.nearest(bodies.position[a], bodies.position[b]);
      EXPECT_GE((image - bodies.position[b]).norm(), bodies.radius[a] + bodies.radius[b])
          << a << " " << b;
    }
}

TEST(Scene, bodies_have_the_fields_that_the_case_s_methods_need) {
  const auto fields = [](const std::string& method, const std::string& more) {
    return fields_of(parse_case(
        "materials.rock.density = 1600\n[[groups]]\nname = \"a\"\nmaterial = \"rock\"\n"
        "volume = {radius = 1}\n" +
            more + "[[phases]]\nname = \"only\"\nstep = 1e-5\nduration = 1\nmethod = \"" + method +
            "\"\n",
        "x.toml"));
  };
  const std::string bonds =
      "[pair_potential]\nlaw = \"lennard_jones\"\ndepth = 1\ndistance = 2\nbreaking_strain = 0.1\n";
  const std::string springs =
      "[contact]\nrestitution = 0.5\n[penalty]\nmodel = \"hooke\"\nstiffness = 1e8\n";
  const std::string field = "[gravity]\nuniform = [0, 0, -1]\n";
  EXPECT_EQ(fields("nonsmooth", ""), (FieldSet{Field::angular_velocity, Field::acceleration}));
  EXPECT_EQ(fields("penalty", springs), (FieldSet{Field::angular_velocity, Field::heat}));
  EXPECT_EQ(fields("penalty", springs + field),
            (FieldSet{Field::angular_velocity, Field::acceleration, Field::heat}));
  EXPECT_EQ(fields("potential", bonds), (FieldSet{Field::bonds, Field::damage}));
  EXPECT_EQ(fields("potential", "spin = [0, 0, 1]\n" + bonds),
            (FieldSet{Field::angular_velocity, Field::bonds, Field::damage}));
  EXPECT_EQ(fields("potential", bonds + "damping = 0.1\n" + field),
            (FieldSet{Field::acceleration, Field::heat, Field::kick, Field::bonds, Field::damage}));
}

TEST(Scene, ranks_share_the_very_bodies_that_one_rank_makes) {
  const Comm comm = testing_world();
  const Case scene = parse(nucleus_and_boulders);
  const Bodies all = all_on_this_rank(scene), own = make_bodies(scene, comm);
  EXPECT_EQ(comm.sum(std::int64_t{own.owned}), all.owned);
  EXPECT_LE(std::abs(own.owned - all.owned / comm.size), 1);
  ASSERT_EQ(own.size(), own.owned);
  const BodyId first = comm.sum_before(own.owned);
  for (Index b = 0; b < own.owned; ++b) {
    ASSERT_EQ(own.id[b], first + b);
    ASSERT_EQ(own.position[b], all.position[first + b]);
    ASSERT_EQ(own.velocity[b], all.velocity[first + b]);
    ASSERT_EQ(own.angular_velocity[b], all.angular_velocity[first + b]);
    ASSERT_EQ(own.mass[b], all.mass[first + b]);
    ASSERT_EQ(own.radius[b], all.radius[first + b]);
    ASSERT_EQ(own.group[b], all.group[first + b]);
    ASSERT_EQ(own.material[b], all.material[first + b]);
  }
}

TEST(Scene, groups_do_not_overlap_and_stay_above_planes) {
  const Bodies all = all_on_this_rank(parse(nucleus_and_boulders));
  for (Index a = 0; a < all.owned; ++a) {
    EXPECT_GE(all.position[a].z() - all.radius[a], -10 - 1e-9);
    for (Index b = 0; b < a; ++b)
      ASSERT_GE((all.position[a] - all.position[b]).norm(),
                (all.radius[a] + all.radius[b]) * (1 - 1e-9));
  }
}

TEST(Scene, motion_and_mass_are_the_groups) {
  const Case scene = parse(nucleus_and_boulders);
  const auto contents = measure_groups(scene);
  const Bodies all = all_on_this_rank(scene);
  EXPECT_EQ(contents[0].count, 1);
  EXPECT_EQ(contents[1].count, 700);
  EXPECT_EQ(contents[0].count + contents[1].count + contents[2].count, all.owned);
  double plate = 0;
  for (Index b = 0; b < all.owned; ++b) {
    if (all.group[b] == 0) {
      EXPECT_EQ(all.mass[b], infinity);
    }
    if (all.group[b] == 1) {
      EXPECT_DOUBLE_EQ(all.mass[b], 1600 * pi / 6);
      const Vec3 arm = all.position[b] - Vec3(1, 2, 3);
      EXPECT_EQ(all.velocity[b], Vec3(4 - 0.5 * arm.y(), 0.5 * arm.x(), 0));
      EXPECT_EQ(all.angular_velocity[b], Vec3(0, 0, 0.5));
    }
    if (all.group[b] == 2) plate += all.mass[b];
  }
  EXPECT_NEAR(plate, 1e6, 1e-6 * std::sqrt(contents[2].count));  // round-off of the sum
}

const char* const gas = R"(
[[groups]]
name = "wall"
material = "rock"
volume = {radius = "7 m", center = [99, 0, 0]}
[[groups]]
name = "gas"
material = "rock"
volume = {shape = "box", size = [60, 60, 60]}
packing = {kind = "random", count = 4000, sizes = {law = "list", radii = [0.5, 1], shares = [3, 1]}}
velocity = [4, 0, 0]
thermal_velocity = {rms = "2 m/s", seed = 5}
)";

TEST(Scene, thermal_velocities_are_maxwell_s_without_a_drift) {
  const Comm comm = testing_world();
  const Bodies own = make_bodies(parse(gas), comm), all = all_on_this_rank(parse(gas));
  for (Index b = 0; b < own.owned; ++b)  // sums over ranks have another order
    ASSERT_LT((own.velocity[b] - all.velocity[own.id[b]]).norm(), 1e-13);
  EXPECT_EQ(all.velocity[0], Vec3(Vec3::Zero()));
  Vec3 momentum = Vec3::Zero();
  double mass = 0, squares = 0, fourth = 0;
  Vec3 products = Vec3::Zero();
  for (Index b = 1; b < all.owned; ++b) {
    const Vec3 v = all.velocity[b] - Vec3(4, 0, 0);
    momentum += all.mass[b] * v;
    mass += all.mass[b];
    squares += v.squaredNorm();
    fourth += v.array().pow(4).sum();
    products += v.cwiseProduct(Vec3(v.y(), v.z(), v.x()));
  }
  EXPECT_LT((momentum / mass).norm(), 1e-12);
  const double n = all.owned - 1;
  EXPECT_NEAR(squares / (3 * n), 4, 1e-11);  // exactly what was asked for
  // Of a normal distribution <v^4> = 3 <v^2>^2 and components are independent: within four standard
  // deviations, of which v^4 has sqrt(96) <v^2>^2 and v_x v_y has <v^2>.
  EXPECT_NEAR(fourth / (3 * n), 48, 4 * std::sqrt(96 / (3 * n)) * 16);
  for (double product : products) EXPECT_NEAR(product / n, 0, 4 * 4 / std::sqrt(n));
  std::string other = gas;
  other.replace(other.find("seed = 5"), 8, "seed = 6");
  EXPECT_NE(all_on_this_rank(parse(other)).velocity[1], all.velocity[1]);
}

TEST(Scene, other_seeds_give_other_places_and_the_same_number) {
  Case scene = parse(nucleus_and_boulders);
  const Bodies one = all_on_this_rank(scene);
  scene.seed = 2;
  const Bodies other = all_on_this_rank(scene);
  ASSERT_EQ(one.owned, other.owned);
  EXPECT_NE(one.position[1], other.position[1]);
}

TEST(Scene, overlaps_are_told_with_both_bodies) {
  const char* const two = R"(
[[groups]]
name = "a"
material = "rock"
volume = {radius = 2}
[[groups]]
name = "b"
material = "rock"
volume = {radius = 1, center = [2.9, 0, 0]}
)";
  const Comm comm(MPI_COMM_SELF);
  EXPECT_EQ(
      complaint(parse(two), comm),
      "x.toml:7:1: groups.b: body 1 at (2.9, 0, 0) m overlaps body 0 of groups.a at (0, 0, 0) "
      "m by 0.1 m; allowed_overlap = 0.001 of the smaller radius, 1 m");
  Case allowed = parse(two);
  allowed.allowed_overlap = 0.11;
  EXPECT_EQ(complaint(allowed, comm), "");
  EXPECT_EQ(complaint(parse(std::string(two) + "[[planes]]\npoint = [0, 0, -1.5]\n"), comm),
            "x.toml:3:1: groups.a: body 0 at (0, 0, 0) m lies 0.5 m deep in the wall plane_0; "
            "allowed_overlap = 0.001 of its radius, 2 m");
}

TEST(Scene, a_volume_that_holds_no_sphere_is_an_error) {
  const char* const empty = R"(
[[groups]]
name = "a"
material = "rock"
volume = {shape = "box", size = [1, 1, 1]}
packing = {kind = "hcp", radius = 1}
)";
  EXPECT_EQ(complaint(parse(empty), Comm(MPI_COMM_SELF)),
            "x.toml:3:1: groups.a: its volume holds no sphere of radius 1 m");
}

TEST(Case, what_is_resolved_is_the_same_case_with_its_changes_wherever_it_stands) {
  if (testing_world().size > 1) return;  // no rank asks another here, and large cases take long
  const std::vector<std::string> files = find_cases(CASES);
  ASSERT_GT(files.size(), 10u);
  for (const std::string& file : files) {
    const Case scene = read_case(file, {"seed=7", "phases.0.step=1e-9"});
    const Case again = parse_case(scene.resolved, "/elsewhere/x.toml");
    EXPECT_EQ(again.resolved, scene.resolved) << file;
    EXPECT_EQ(again.seed, 7u);
    EXPECT_EQ(again.phases[0].step, 1e-9);
    const auto is_stored = [](const Group& g) { return !g.packing.file.empty(); };
    if (std::ranges::none_of(scene.groups, is_stored)) {  // else an earlier run makes its bodies
      EXPECT_EQ(describe_phases(again, measure_groups(again)),
                describe_phases(scene, measure_groups(scene)))
          << file;
    }
    for (std::size_t g = 0; g < scene.groups.size(); ++g) {
      EXPECT_EQ(again.groups[g].packing.rotation, scene.groups[g].packing.rotation) << file;
      EXPECT_EQ(again.groups[g].volume.center, scene.groups[g].volume.center) << file;
    }
  }
}

TEST(Case, tables_and_keys_that_nothing_reads_are_told) {
  const Case scene = parse(
      "[gravity]\naccuracy = 1e-3\n[penalty]\nrolling_friction = 0.3\n[contact]\nfriction = "
      "0.1\n[[groups]]\nname = \"a\"\n"
      "material = \"rock\"\nvolume = {radius = 2}\n");
  EXPECT_EQ(scene.unused,
            (std::vector<std::string>{"[penalty] is not used: no phase has method = \"penalty\"",
                                      "gravity.accuracy is not used: no gravity.method is named"}));
  EXPECT_NE(describe_phases(scene, measure_groups(scene)).find(scene.unused[0]), std::string::npos);
  for (const bool shaped : {false, true}) {
    const Case other = parse(
        std::string("[gravity]\nmethod = \"direct\"\nnear_clumps = 3\n[shapes.egg]\naxes = [2, 1, "
                    "1]\ncount = 3\n[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nvolume = "
                    "{radius = 2}\n") +
        (shaped ? "packing = {kind = \"single\", shape = \"egg\"}\n" : ""));
    EXPECT_EQ(other.unused.size(), shaped ? 0u : 2u);
    if (!shaped) {
      EXPECT_EQ(other.unused[1], "gravity.near_clumps is not used: no group has a shape");
    }
  }
  const std::string hit = R"([contact]
restitution = 0.5
cohesion_range = 0.1
[[groups]]
name = "a"
material = "rock"
volume = {radius = 2}
[[phases]]
name = "hit"
step = 1e-4
duration = 1
impactor = {mass = 1, radius = 0.1, speed = 1000, distance = 1, coupling = {law = "point_source", ground = "sand", density = 1600, hand_over = 1, n2 = 1.2}}
)";
  const std::string flow =
      "phases.hit.impactor.coupling.n2 is not used: without crater_radius no rim ends the flow";
  EXPECT_EQ(parse(hit).unused, (std::vector<std::string>{
                                   "contact.cohesion_range is not used: nothing coheres", flow}));
  const std::string springs = R"([contact]
restitution = 0.5
friction = 0
[penalty]
model = "hooke"
stiffness = 1e6
tangential_damping = 0.5
[[groups]]
name = "a"
material = "rock"
volume = {radius = 2}
[[phases]]
name = "soft"
method = "penalty"
step = 1e-4
duration = 1
)";
  EXPECT_EQ(
      parse(springs).unused,
      std::vector<std::string>{"penalty.tangential_damping is not used: nothing has friction"});
}

TEST(Case, what_a_later_phase_of_a_method_does_not_use_is_told_too) {
  const Case scene = parse(R"([contact]
friction = 0.5
[[groups]]
name = "a"
material = "rock"
volume = {radius = 2}
[[phases]]
name = "first"
step = 1
duration = 1
[[phases]]
name = "second"
step = 1
duration = 1
solver = {relaxation = 1.5}
)");
  const std::string text = describe_phases(scene, measure_groups(scene));
  EXPECT_NE(text.find("\n  in phase second:\n  solver.relaxation is not used"), std::string::npos)
      << text;
  EXPECT_EQ(text.find("in phase first:"), std::string::npos) << text;
  EXPECT_EQ(text.find("in phase only:"), std::string::npos) << text;
}

TEST(Case, a_read_out_needs_what_can_be_deflected) {
  const std::string text = R"(read_out = [0.5]
materials.rock.density = 1600
[[groups]]
name = "a"
material = "rock"
volume = {radius = 2}
fixed = true
[[phases]]
name = "hit"
step = 0.1
duration = 1
impactor = {mass = 1, diameter = 0.5, speed = 9, direction = [1, 0, 0], distance = 3}
)";
  EXPECT_EQ(
      complaint_of([&] { parse_case(text, "x.toml"); }),
      "x.toml:1:12: read_out tells how a target is deflected, but all groups are fixed or move "
      "as prescribed");
}

TEST(Case, nothing_is_resolved_where_a_program_adds_spheres) {
  Scene scene = Scene::from_text(
      "[materials.rock]\ndensity = 2000\n[[phases]]\nname = 'only'\n"
      "step = 1\nduration = 1\n");
  EXPECT_FALSE(scene.parts()->resolved.empty());
  scene.add({.material = "rock", .radius = 1});
  EXPECT_TRUE(scene.parts()->resolved.empty());
}

TEST(Scene, columns_of_its_description_do_not_run_together) {
  const Case scene = parse(R"([[groups]]
name = "a"
material = "rock"
volume = {radius = 9}
packing = {kind = "random", count = 300, sizes = {law = "list", radii = [0.0000254, 0.000254]}}
)");
  const std::string text = describe_bodies(scene, 1, 0);
  EXPECT_NE(text.find(" 300  2.54e-05 to 0.000254 "), text.npos) << text;
}

TEST(Scene, of_a_text_may_fill_a_mesh) {
  const auto of = [](const std::string& file) {
    return Scene::from_text(fmt::format(R"(
[materials.rock]
density = 2000
[[groups]]
name = "a"
material = "rock"
volume = {{shape = "mesh", file = "{}", unit = 10}}
packing = {{kind = "fcc", radius = 1}}
[[phases]]
name = "only"
step = 1
duration = 1
)",
                                        file));
  };
  // An octahedron of half width 1 has the volume 4/3; close-packed spheres fill 0.74 of what is
  // inside.
  const Scene scene = of(CASES "/../docs/examples/octahedron.obj");
  const Bodies bodies = make_bodies(*scene.parts(), Comm(MPI_COMM_SELF));
  EXPECT_NEAR(double(bodies.owned) * ball_volume(1) / (4000. / 3), 0.74, 0.2);
  EXPECT_EQ(complaint_of([&] { of("gone.obj"); }),
            "scene:4:1: groups.a: volume.file: there is no file 'gone.obj'");
}

TEST(Scene, the_cases_that_come_with_the_program_have_the_thesis_masses) {
  if (testing_world().size > 1) return;  // no rank asks another here, and large cases take long
  const std::vector<std::string> files = find_cases(CASES);
  for (const std::string& file : files) {
    const Case scene = read_case(file);
    const auto is_stored = [](const Group& g) { return !g.packing.file.empty(); };
    if (std::ranges::any_of(scene.groups, is_stored)) continue;  // an earlier run makes its bodies
    double mass = 0;
    const auto contents = measure_groups(scene);
    for (std::size_t g = 0; g < contents.size(); ++g)
      mass += scene.groups[g].total_mass.value_or(contents[g].mass);
    const std::string folder = std::filesystem::path(file).parent_path().filename();
    if (folder == "didymoon") {
      EXPECT_NEAR(mass, 1.8651e9, 0.0001e9);
    }
    if (folder == "nucleus") {
      EXPECT_NEAR(mass, 2.708e9, 0.001e9);
    }
    if (folder == "pull") {
      EXPECT_DOUBLE_EQ(mass, 1.0723e9);
    }
    EXPECT_FALSE(describe_bodies(scene, 1, 0).empty());
  }
  EXPECT_GE(files.size(), 7u);
}

TEST(Scene, too_many_at_random_are_refused_with_how_many_fit) {
  const char* const crowd = R"(
[[groups]]
name = "a"
material = "rock"
volume = {radius = 1}
packing = {kind = "random", radius = 0.3, count = 20}
)";
  const std::string message = complaint(parse(crowd), Comm(MPI_COMM_SELF));
  EXPECT_TRUE(message.starts_with(
      "x.toml:3:1: groups.a: 20 spheres of radius 0.3 m would be 0.540 of the volume; "))
      << message;
}

TEST(Scene, more_ranks_than_bodies_is_an_error) {
  const Comm comm = testing_world();
  const char* const one = "[[groups]]\nname = \"a\"\nmaterial = \"rock\"\nvolume = {radius = 2}\n";
  EXPECT_EQ(complaint(parse(one), comm),
            comm.size == 1
                ? ""
                : fmt::format("x.toml: 1 bodies on {} ranks: run it on at most 1", comm.size));
}

TEST(Impactor, meets_first_and_head_on_the_body_that_it_is_aimed_at) {
  const Comm comm = testing_world();
  const Case scene = parse(nucleus_and_boulders);
  const Bodies all = all_on_this_rank(scene);
  Bodies own = make_bodies(scene, comm);
  const Impactor impactor{.mass = 5,
                          .radius = 0.25,
                          .speed = 4000,
                          .direction = Vec3(1, -2, 2) / 3,
                          .distance = 0.2,
                          .offset = Vec3(9, 3, -2)};
  const Aim aim = add_impactor(comm, scene, impactor, own);

  EXPECT_EQ(comm.sum(std::int64_t{own.owned}), all.owned + 1);
  ASSERT_GE(aim.struck, 0);
  const Vec3 to = all.position[aim.struck] - aim.position;
  EXPECT_LT(to.cross(impactor.direction).norm(), 1e-12);  // head-on
  EXPECT_NEAR(to.norm(), 0.25 + all.radius[aim.struck] + 0.2, 1e-12);
  // All else along the line is met later.
  for (Index b = 0; b < all.owned; ++b) {
    const Vec3 other = all.position[b] - aim.position;
    const double along = other.dot(impactor.direction);
    const double aside = other.cross(impactor.direction).norm();
    const double reach = 0.25 + all.radius[b];
    if (b == aim.struck || aside >= reach) continue;
    EXPECT_GT(along - std::sqrt(reach * reach - aside * aside), 0.2);
  }
  const auto row = std::ranges::find(own.id, BodyId{all.owned}) - own.id.begin();
  EXPECT_EQ(comm.any(row < own.owned), true);
  if (row < own.owned) {
    EXPECT_EQ(own.position[row], aim.position);
    EXPECT_EQ(own.velocity[row], aim.velocity);
    EXPECT_EQ(own.group[row], 3);
  }
}

TEST(Impactor, is_aimed_head_on_whichever_body_it_meets) {
  const Comm comm(MPI_COMM_SELF);
  Bodies bodies;
  for (int k = 0; k < 3; ++k) {
    const Index row = append_row(bodies);
    bodies.id[row] = k;
    bodies.position[row] = {0, 10.0 * k, 0};
    bodies.radius[row] = 2;
  }
  bodies.owned = bodies.size();
  for (int k = 0; k < 3; ++k) {
    const Impactor impactor{
        .mass = 5, .radius = 1, .speed = 10, .distance = 4, .offset = Vec3(0, 10.0 * k + 1, 0)};
    const Aim aim = aim_impactor(comm, impactor, bodies);
    EXPECT_EQ(aim.struck, k);
    EXPECT_TRUE(aim.position.isApprox(Vec3(-7, 10.0 * k, 0), 1e-15));
  }
}

TEST(Impactor, on_a_line_keeps_to_it_and_a_miss_is_an_error) {
  const Comm comm(MPI_COMM_SELF);
  const Case scene = parse(R"(
[[groups]]
name = "a"
material = "rock"
volume = {radius = 2, center = [5, 0, 0]}
velocity = [0, 1, 0]
)");
  const Bodies bodies = make_bodies(scene, comm);
  Impactor impactor{.mass = 5, .radius = 1, .speed = 10, .distance = 4, .aim = Aiming::line};
  impactor.offset = Vec3(0, 0, 1.8);
  const Aim aim = aim_impactor(comm, impactor, bodies);
  EXPECT_TRUE(aim.position.isApprox(Vec3(5 - 2.4 - 4, 0, 1.8), 1e-15));  // 3-4-5: 1.8, 2.4, 3
  EXPECT_EQ(aim.velocity, Vec3(10, 1, 0));
  impactor.offset = Vec3(0, 3, 0);
  EXPECT_THROW(aim_impactor(comm, impactor, bodies), Error);
}

}  // namespace
}  // namespace spall
