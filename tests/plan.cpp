// What `spall plan` counts for many ranks is what a run on so many ranks has.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/plan.hpp"

#include <algorithm>

#include "gravity/kick.hpp"
#include "run/simulation.hpp"
#include "spall/scene.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// A cloud of 2,600 boulders at random, some of them twice as large, at this speed (m/s).
std::string cloud(const std::string& method, const std::string& more, double rms = 0.1) {
  return fmt::format(R"(
[materials.rock]
density = 2000
[contact]
friction = 0.3
restitution = 0.5
[penalty]
model = "hooke"
stiffness = 1e6
[[groups]]
name = "small"
material = "rock"
volume = {{shape = "box", size = [26, 20, 14]}}
packing = {{kind = "random", radius = 0.3, count = 2000}}
thermal_velocity = {{rms = {}, seed = 3}}
[[groups]]
name = "large"
material = "rock"
volume = {{shape = "box", size = [26, 20, 14]}}
packing = {{kind = "random", radius = 0.6, count = 600}}
thermal_velocity = {{rms = {}, seed = 4}}
[[phases]]
name = "only"
method = "{}"
step = 1e-4
duration = 1
{}
)",
                     rms, rms, method, more);
}

std::string crystal(const std::string& more) {
  return fmt::format(R"(
[materials.rock]
density = 2500
[pair_potential]
law = "morse"
depth = 1
distance = 0.01
steepness = 6
cutoff = 0.018
[[groups]]
name = "crystal"
material = "rock"
volume = {{shape = "sphere", radius = 0.1}}
packing = {{kind = "fcc", radius = "5 mm", rotation = [0.3, 0.4, 0.5]}}
[[phases]]
name = "rest"
method = "potential"
step = "1 us"
duration = "1 ms"
{}
)",
                     more);
}

/// What a rank has and sends in a step, and in an evaluation of gravity's tree.
struct Counts {
  double bodies = 0, ghosts = 0, sources = 0, messages = 0, bytes = 0;
  double tree_messages = 0, tree_bytes = 0;
  double collectives = 0, tree_collectives = 0;
};
constexpr std::size_t doubles = sizeof(Counts) / sizeof(double);

Counts of_run(const Comm& comm, const std::string& text) {
  Simulation simulation(comm, Scene::from_text(text));
  simulation.begin_phase();
  simulation.advance(1, false);
  World& world = simulation.world();
  Counts counts{.bodies = static_cast<double>(world.bodies.owned),
                .ghosts = static_cast<double>(simulation.engine().ghosts(world))};
  if (world.gravity.method == GravityMethod::tree) {
    world.kick.evaluated = false;
    world.stages.clear();
    evaluate_field(world);
    const Traffic& tree = world.stages["gravity"].traffic;
    counts.tree_messages = static_cast<double>(tree.messages);
    counts.tree_bytes = static_cast<double>(tree.bytes);
    counts.tree_collectives = static_cast<double>(tree.collectives);
  }
  world.stages.clear();
  simulation.advance(1, false);
  Traffic all;
  for (const char* stage : {"neighbours", "forces"}) all.add(world.stages[stage].traffic);
  counts.messages = static_cast<double>(all.messages);
  counts.bytes = static_cast<double>(all.bytes);
  counts.sources = static_cast<double>(all.sources);
  counts.collectives = static_cast<double>(all.collectives);
  return counts;
}

/// Of all ranks, by one of them.
std::vector<Counts> of_plan(int ranks, const std::string& text) {
  Simulation simulation(alone(), Scene::from_text(text));
  simulation.begin_phase();
  OneRank one = try_one_rank(simulation, 0);
  EXPECT_EQ(one.searches, 0);
  one.state.work = one.state.first_work();  // a run's first search knows no other
  RankShares shares = share_out(one.state, ranks, ranks);
  if (one.tree) share_out_tree(one.state, one.accuracy, one.rates, shares);
  std::vector<Counts> counts;
  for (const RankShare& share : shares.sample) {
    EXPECT_EQ(share.rank, std::ssize(counts));
    Counts& of_rank = counts.emplace_back();
    of_rank.bodies = static_cast<double>(share.bodies);
    of_rank.ghosts = static_cast<double>(share.halo.ghosts);
    of_rank.sources = static_cast<double>(share.halo.sources);
    Traffic tree = share.tree.traffic;
    tree.add(share.near_clumps);
    of_rank.tree_messages = static_cast<double>(tree.messages);
    of_rank.tree_bytes = static_cast<double>(tree.bytes);
    for (const StageCost& cost : foretell_step(one, share, ranks, {})) {
      // An evaluation whose step is this one is the sample's only one.
      if (cost.stage == "gravity" && one.tree && one.evaluations == 1)
        of_rank.tree_collectives = cost.collectives;
      if (cost.stage != "neighbours" && cost.stage != "forces") continue;
      of_rank.messages += cost.messages;
      of_rank.bytes += cost.bytes;
      of_rank.collectives += cost.collectives;
    }
  }
  return counts;
}

void expect_plan_as_run(const std::string& text) {
  const Comm comm = testing_world();
  const Counts run = of_run(comm, text);
  std::vector<Counts> plan(comm.size);
  if (comm.rank == 0) plan = of_plan(comm.size, text);
  ASSERT_EQ(std::ssize(plan), comm.size);
  comm.broadcast(std::span(&plan[0].bodies, doubles * plan.size()), 0);
  const Counts& own = plan[comm.rank];
  EXPECT_EQ(own.bodies, run.bodies);
  EXPECT_EQ(own.ghosts, run.ghosts);
  EXPECT_EQ(own.sources, run.sources);
  EXPECT_EQ(own.messages, run.messages);
  EXPECT_EQ(own.bytes, run.bytes);
  EXPECT_EQ(own.collectives, run.collectives);
  EXPECT_EQ(own.tree_messages, run.tree_messages);
  EXPECT_EQ(own.tree_bytes, run.tree_bytes);
  EXPECT_EQ(own.tree_collectives, run.tree_collectives);
}

TEST(Plan, counts_of_rigid_spheres_are_those_of_a_run) {
  expect_plan_as_run(cloud("nonsmooth", ""));
}

TEST(Plan, counts_of_penalty_contact_are_those_of_a_run) {
  expect_plan_as_run(cloud("penalty", ""));
}

TEST(Plan, counts_of_pair_potentials_are_those_of_a_run) {
  expect_plan_as_run(crystal(""));
}

TEST(Plan, counts_in_a_periodic_box_are_those_of_a_run) {
  expect_plan_as_run(cloud("penalty", "[periodic]\nsize = [28, 22, 16]\n"));
}

TEST(Plan, counts_of_the_tree_of_gravity_are_those_of_a_run) {
  // Bodies hardly move, or other cells would be opened at the run's next evaluation.
  expect_plan_as_run(cloud("nonsmooth", "[gravity]\nmethod = \"tree\"\naccuracy = 1e-2\n", 1e-9));
}

/// The cloud, its small boulders clumps of two spheres.
std::string cloud_of_twins(const std::string& method, const std::string& more, double rms = 0.1) {
  std::string text = cloud(method, more + R"([shapes.twin]
spheres = [{at = [0, 0, 0], radius = 1}, {at = [1, 0, 0], radius = 0.7}]
)",
                           rms);
  return text.insert(text.find("count = 2000"), "shape = \"twin\", ");
}

TEST(Plan, counts_of_clumps_that_attract_by_their_spheres_are_those_of_a_run) {
  expect_plan_as_run(cloud_of_twins("nonsmooth", R"([gravity]
method = "tree"
accuracy = 1e-2
near_clumps = 1.5
)",
                                    1e-9));
}

TEST(Plan, counts_of_clumps_in_penalty_contact_are_those_of_a_run) {
  expect_plan_as_run(cloud_of_twins("penalty", ""));
  expect_plan_as_run(cloud_of_twins("penalty", "[periodic]\nsize = [28, 22, 16]\n"));
}

OneRank one_rank(const std::string& text) {
  Simulation simulation(alone(), Scene::from_text(text));
  simulation.begin_phase();
  return try_one_rank(simulation, 0);
}

TEST(Plan, a_step_of_one_rank_takes_what_it_took) {
  if (testing_world().rank > 0) return;  // one is enough
  const OneRank one = one_rank(crystal(""));
  const RankShares shares = share_out(one.state, 1, 1);
  double sum = 0;
  for (const StageCost& cost : foretell_step(one, shares.sample.front(), 1, {}))
    sum += cost.seconds();
  EXPECT_NEAR(sum, one.sample.seconds / static_cast<double>(one.sample.steps), 1e-9 * sum);
}

TEST(Plan, a_sample_has_the_ranks_with_most) {
  if (testing_world().rank > 0) return;  // one is enough
  const OneRank one = one_rank(cloud("penalty", ""));
  const RankShares all = share_out(one.state, 40, 40), some = share_out(one.state, 40, 8);
  EXPECT_EQ(all.sample.size(), 40);
  EXPECT_LE(some.sample.size(), 8);
  for (auto count : {&RankShare::bodies, &RankShare::pairs, &RankShare::boundary}) {
    const auto most = [&](const RankShares& shares) {
      return std::ranges::max(shares.sample, {}, count).*count;
    };
    EXPECT_EQ(most(some), most(all));
  }
}

TEST(Plan, refuses_what_it_cannot_tell) {
  if (testing_world().rank > 0) return;  // one is enough
  const OneRank one = one_rank(crystal(""));
  EXPECT_NE(complaint_of([&] {
              share_out(one.state, one.state.bodies.owned + 1, 8);
            }).find("plan for at most"),
            std::string::npos);
  EXPECT_NE(
      complaint_of([] { one_rank(crystal("[domain]\ncut = \"metis\"\n")); }).find("bisection"),
      std::string::npos);
}

TEST(Plan, bandwidths_have_units) {
  EXPECT_EQ(parse_bandwidth("10 GB/s"), 1e10);
  EXPECT_EQ(parse_bandwidth("2.5MB/s"), 2.5e6);
  for (const char* wrong : {"10", "10 GB", "-1 GB/s", "GB/s", ""})
    EXPECT_NE(complaint_of([&] { parse_bandwidth(wrong); }), "") << wrong;
}

}  // namespace
}  // namespace spall
