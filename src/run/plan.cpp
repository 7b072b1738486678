// One rank tells what a body, a pair and an exchange cost; shares tell how many of them a rank has.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <filesystem>
#include <string_view>

#include "base/process.hpp"
#include "engine/type.hpp"
#include "gravity/field.hpp"
#include "output/restart.hpp"
#include "run/progress.hpp"
#include "run/record.hpp"
#include "run/run.hpp"
#include "run/simulation.hpp"
#include "scene/case.hpp"
#include "scene/scene.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// What a stage's work on one rank is in proportion to.
double share_of_work(std::string_view stage, const OneRank& one, const RankShare& share,
                     int ranks) {
  const auto bodies = static_cast<double>(one.state.bodies.owned);
  const auto pairs = static_cast<double>(one.state.pairs.i.size());
  const auto of_bodies = static_cast<double>(share.bodies) / bodies;
  if (stage == "gravity")
    return one.tree ? static_cast<double>(share.tree.bodies) / bodies : 1.0 / ranks;
  if (stage == "neighbours")
    return static_cast<double>(share.rows + share.halo.ghosts) /
           static_cast<double>(one.state.rows().owned);
  const bool by_pairs = stage == "contacts" || stage == "solver" || stage == "forces";
  return by_pairs && pairs > 0 ? static_cast<double>(share.pairs) / pairs : of_bodies;
}

/// From or to a rank, a step.
struct Flow {
  double messages = 0, bytes = 0;
};

}  // namespace

OneRank try_one_rank(Simulation& simulation, double seconds) {
  const World& world = simulation.world();
  require(world.cut == Cut::bisection,
          "{}: domain.cut = \"metis\" has each rank hold the cells of all: plans are for bisection",
          simulation.scene().file);
  require(simulation.steps_left() > 1, "{}: a plan makes steps of phase {}, which has none left",
          simulation.scene().file, simulation.phase_name());
  OneRank one;
  one.time = simulation.time();
  simulation.advance(1, false);
  std::optional<FoundPairs> found = simulation.engine().found_pairs(world);
  require(found.has_value(),
          "{}.method = \"{}\": a plan shares out pairs of bodies, which this method does not list; "
          "`spall "
          "check --time` on the ranks that there are measures it",
          simulation.phase().place, simulation.phase().engine->name);
  const Search& search = *found->search;
  one.state = shared_state(world, *std::move(found));
  const auto counted = [&] {
    return std::array{static_cast<double>(simulation.steps()), static_cast<double>(search.searches),
                      static_cast<double>(world.kick.evaluations)};
  };
  const auto before = counted();
  one.sample = sample_steps(simulation, seconds);
  const auto after = counted();
  require(one.sample.steps > 0, "{}: phase {} is over before a step could be timed",
          simulation.scene().file, simulation.phase_name());
  const double steps = after[0] - before[0];
  one.searches = (after[1] - before[1]) / steps;
  one.evaluations = (after[2] - before[2]) / steps;
  one.rates = world.kick.may_hold;
  one.tree = choose_gravity(world.gravity, one.state.bodies.owned) == GravityMethod::tree;
  one.accuracy = world.gravity.accuracy;
  if (one.tree) {
    RankShares alone = share_out(one.state, 1, 1);
    share_out_tree(one.state, one.accuracy, one.rates, alone);
    one.of_tree = alone.sample.front().tree.traffic;
  }
  return one;
}

std::vector<StageCost> foretell_step(const OneRank& one, const RankShare& share, int ranks,
                                     const Network& network) {
  const auto steps = static_cast<double>(one.sample.steps);
  const auto a_step = [&](std::int64_t count) { return static_cast<double>(count) / steps; };
  const auto rounds = static_cast<double>(std::bit_width(static_cast<unsigned>(ranks - 1)));
  const HaloShare& halo = share.halo;
  std::vector<StageCost> costs;
  for (const auto& [stage, use] : one.sample.stages) {
    const Traffic& told = use.traffic;
    StageCost& cost = costs.emplace_back();
    cost.stage = stage;
    cost.even_work = use.seconds / steps / ranks;
    cost.work = use.seconds / steps * share_of_work(stage, one, share, ranks);

    const auto exchange = [&](std::int64_t others, std::int64_t rows) {
      return Flow{a_step(told.exchanges) * static_cast<double>(others),
                  a_step(told.row_bytes) * static_cast<double>(rows)};
    };
    Flow out = exchange(halo.holders, halo.copies), in = exchange(halo.sources, halo.ghosts);
    cost.collectives = a_step(told.collectives);
    double reduced = a_step(told.reduced), gathered = a_step(told.gathered);
    const auto add = [&](double times, const Traffic& traffic) {
      for (Flow* flow : {&out, &in}) {
        flow->messages += times * static_cast<double>(traffic.messages);
        flow->bytes += times * static_cast<double>(traffic.bytes);
      }
    };
    if (stage == "gravity" && one.tree) {
      const Traffic& tree = share.tree.traffic;
      add(one.evaluations, tree);
      const auto more = [&](std::int64_t Traffic::*count) {
        return one.evaluations * static_cast<double>(tree.*count - one.of_tree.*count);
      };
      cost.collectives += more(&Traffic::collectives);
      reduced += more(&Traffic::reduced);
      gathered += more(&Traffic::gathered);
    } else if (stage != "gravity") {
      gathered *= ranks;  // each rank brings as much as the one of the sample
    }
    if (stage == "neighbours") add(one.searches, halo.search);
    if (stage == "gravity") add(one.evaluations, share.near_clumps);
    cost.messages = out.messages;
    cost.bytes = out.bytes;
    if (ranks == 1) continue;
    cost.by_messages = network.latency * std::max(out.messages, in.messages);
    cost.by_bytes = std::max(out.bytes, in.bytes) / network.bandwidth;
    const double call = network.latency * rounds;
    cost.by_collectives = call * cost.collectives + (2 * reduced + gathered) / network.bandwidth;

    // An iteration's exchange and sum are under way while contacts without ghosts are treated.
    if (told.delayed == 0) continue;
    const double inside = 1 - static_cast<double>(share.boundary) /
                                  static_cast<double>(std::max<std::int64_t>(share.pairs, 1));
    const double flying = (cost.by_messages + cost.by_bytes) * static_cast<double>(told.delayed) /
                              static_cast<double>(std::max(told.exchanges, told.delayed)) +
                          call * a_step(told.delayed);
    const double hidden = std::min(flying, inside * cost.work);
    const double left = 1 - hidden / (cost.by_messages + cost.by_bytes + cost.by_collectives);
    for (double* part : {&cost.by_messages, &cost.by_bytes, &cost.by_collectives}) *part *= left;
  }
  return costs;
}

namespace {

double seconds_of(const std::vector<StageCost>& costs) {
  double sum = 0;
  for (const StageCost& cost : costs) sum += cost.seconds();
  return sum;
}

/// What most of the time beyond an even share of the work goes to.
std::string limit_of(const std::vector<StageCost>& costs) {
  double most = 0;
  std::string limit = "nothing";
  for (const StageCost& cost : costs)
    for (const auto& [lost, by] :
         {std::pair(cost.work - cost.even_work, "work: uneven shares, and pairs with ghosts twice"),
          std::pair(cost.by_messages, "latency of messages"), std::pair(cost.by_bytes, "bytes"),
          std::pair(cost.by_collectives, "collective calls")})
      if (lost > most) {
        most = lost;
        limit = fmt::format("{}, by {}", cost.stage, by);
      }
  return limit;
}

/// Bytes of the program and of all bodies.
struct Memory {
  double program, bodies;

  Memory(const Case& scene, const std::vector<GroupContent>& contents, double bytes_of_program)
      : program(bytes_of_a_rank(scene, {}, 1, bytes_of_program)),
        bodies(bytes_of_a_rank(scene, contents, 1, bytes_of_program) - program) {}

  double of(const OneRank& one, const RankShare& share) const {
    const auto part = [](std::int64_t some, Index of_all) {
      return static_cast<double>(some) / static_cast<double>(of_all);
    };
    return program + bodies * (part(share.bodies, one.state.bodies.owned) +
                               part(share.halo.ghosts, one.state.rows().owned));
  }
};

std::string describe_sample(const Simulation& simulation, const OneRank& one) {
  const Sample& sample = one.sample;
  std::string text = fmt::format(
      "{}\n\n  {} bodies and {} pairs that may touch, phase {} ({}) at {}\n",
      simulation.scene().title.empty() ? simulation.scene().file : simulation.scene().title,
      one.state.bodies.owned, one.state.pairs.i.size(), simulation.phase_name(),
      simulation.phase().engine->name, readable_time(one.time));
  if (!one.state.whole.empty())
    text +=
        fmt::format("  pairs and ghosts are of the {} spheres of clumps\n", one.state.whole.size());
  text +=
      fmt::format("  one rank here takes {} a step, from a sample of {}:",
                  readable_time(sample.seconds / static_cast<double>(sample.steps)), sample.steps);
  for (const auto& [stage, use] : sample.stages)
    if (use.seconds > 0.005 * sample.seconds)
      text += fmt::format(" {} {:.0f} %", stage, 100 * use.seconds / sample.seconds);
  return text + fmt::format("\n  {:.3g} searches for pairs a step{}\n", one.searches,
                            one.evaluations > 0
                                ? fmt::format(", {:.3g} evaluations of gravity", one.evaluations)
                                : "");
}

std::string describe_shares(const RankShares& shares, const OneRank& one, const Memory& memory,
                            const Network& network) {
  const std::vector<RankShare>& sample = shares.sample;
  std::string text =
      fmt::format("\n{} ranks, {} of them built{}\n", shares.ranks,
                  std::ssize(sample) == shares.ranks ? "all" : std::to_string(sample.size()),
                  shares.by_work ? ", cut by their work" : "");
  text += fmt::format("  {:<16}{:>12}{:>12}\n", "a rank", "mean", "most");
  const auto row = [&](const char* name, auto&& value) {
    double sum = 0, most = 0;
    for (const RankShare& share : sample) {
      const auto v = static_cast<double>(value(share));
      sum += v;
      most = std::max(most, v);
    }
    text += fmt::format("  {:<16}{:>12.6g}{:>12.6g}\n", name,
                        sum / static_cast<double>(sample.size()), most);
  };
  row("bodies", [](const RankShare& s) { return s.bodies; });
  row("pairs", [](const RankShare& s) { return s.pairs; });
  row("ghosts", [](const RankShare& s) { return s.halo.ghosts; });
  row("near ranks", [](const RankShare& s) { return s.halo.sources; });
  row("memory (MB)", [&](const RankShare& s) { return std::round(1e-6 * memory.of(one, s)); });

  std::vector<StageCost> slowest;
  for (const RankShare& share : sample)
    if (auto costs = foretell_step(one, share, shares.ranks, network);
        seconds_of(costs) > seconds_of(slowest))
      slowest = std::move(costs);
  text += fmt::format("  {:<16}{:>12}{:>12}{:>12}{:>12}{:>14}\n", "a step, slowest", "messages",
                      "bytes", "collectives", "work (us)", "telling (us)");
  StageCost all{.stage = "all"};
  const auto print = [&](const StageCost& cost) {
    text += fmt::format("  {:<16}{:>12.4g}{:>12.4g}{:>12.4g}{:>12.4g}{:>14.4g}\n", cost.stage,
                        cost.messages, cost.bytes, cost.collectives, 1e6 * cost.work,
                        1e6 * (cost.seconds() - cost.work));
  };
  for (const StageCost& cost : slowest) {
    if (cost.seconds() == 0) continue;
    print(cost);
    for (auto part :
         {&StageCost::messages, &StageCost::bytes, &StageCost::collectives, &StageCost::work,
          &StageCost::by_messages, &StageCost::by_bytes, &StageCost::by_collectives})
      all.*part += cost.*part;
  }
  print(all);
  const double alone = one.sample.seconds / static_cast<double>(one.sample.steps);
  return text + fmt::format("  a step takes {}, efficiency {:.2f}; most is lost in {}\n",
                            readable_time(all.seconds()), alone / shares.ranks / all.seconds(),
                            limit_of(slowest));
}

constexpr const char* assumptions = R"(
Bodies, pairs, ghosts, neighbours, messages and bytes are counted by the code of runs. Times assume
  work      as on one rank here: in proportion to bodies, pairs and ghosts, no faster in a cache
  messages  latency each, and bytes / bandwidth, one after another
  collective calls  log2(ranks) latencies each, and twice their bytes / bandwidth
  overlap   only in iterations of solver.method = "accelerated", while inner contacts are treated
  not counted: cuts of the domain, files, and what ranks wait for beyond uneven shares
)";

/// The beginning of a run, or of one that goes on; all of it on one rank.
Simulation begin(const Comm& alone, const std::string& file, const PlanRequest& request) {
  const InputFiles files(alone);
  if (std::filesystem::path(file).extension() != ".h5") {
    Simulation simulation(alone,
                          Scene(std::make_shared<Case>(read_case(file, request.overrides, files))));
    simulation.begin_phase();
    return simulation;
  }
  RestartState state = read_restart(alone, file);
  const auto scene = std::make_shared<Case>(case_to_go_on(alone, state, request.overrides, files));
  Simulation simulation(alone, Scene(scene), state);
  require(!simulation.over(), "'{}': all phases are over, there is nothing to plan", file);
  if (simulation.clock().step_in_phase == 0) simulation.begin_phase();
  return simulation;
}

}  // namespace

std::string plan(const Comm& comm, const std::string& file, const PlanRequest& request) {
  Network network = request.calibrate ? measure_network(comm) : Network();
  network.latency = request.latency.value_or(network.latency);
  network.bandwidth = request.bandwidth.value_or(network.bandwidth);
  if (comm.rank != 0) return "";

  const double bytes_of_program = resident_bytes();
  Simulation simulation = begin(Comm(MPI_COMM_SELF), file, request);
  constexpr double seconds_of_sample = 2;
  const OneRank one = try_one_rank(simulation, seconds_of_sample);
  const char* origin = request.calibrate                      ? "measured here"
                       : request.latency && request.bandwidth ? "as given"
                                                              : "as given or assumed";
  std::string text = describe_sample(simulation, one) +
                     fmt::format("  network, {}: latency {}, bandwidth {:.3g} GB/s a rank\n",
                                 origin, readable_time(network.latency), 1e-9 * network.bandwidth);
  const World& world = simulation.world();
  const Memory memory(simulation.scene(),
                      measure_bodies(world.comm, simulation.scene(), world.bodies),
                      bytes_of_program);
  constexpr int most_built = 16;
  for (int ranks : request.ranks) {
    RankShares shares = share_out(one.state, ranks, most_built);
    if (one.tree) share_out_tree(one.state, one.accuracy, one.rates, shares);
    text += describe_shares(shares, one, memory, network);
  }
  return text + assumptions;
}

}  // namespace spall
