// Planes, halos and cells are those of runs; only nobody sends them.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/rank_shares.hpp"

#include <algorithm>
#include <numeric>
#include <set>

#include "domain/bisection.hpp"
#include "gravity/near_clumps.hpp"
#include "gravity/tree.hpp"
#include "pairs/search.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// Of each row, ghosts included, the owned row that it is or is an image of.
std::vector<Index> originals(const Ghosts& ghosts) {
  std::vector<double> rows(static_cast<std::size_t>(ghosts.owned()) + ghosts.ghosts());
  std::iota(rows.begin(), rows.end(), 0.0);
  ghosts.gather(rows.data(), 1);
  return {rows.begin(), rows.end()};
}

std::vector<double> sum_by_rank(std::span<const int> owner, int ranks,
                                std::span<const double> work) {
  std::vector<double> sums(ranks);
  for (std::size_t b = 0; b < owner.size(); ++b) sums[owner[b]] += work[b];
  return sums;
}

double most_over_mean(const std::vector<double>& sums) {
  const double all = std::accumulate(sums.begin(), sums.end(), 0.0);
  return std::ranges::max(sums) * static_cast<double>(sums.size()) / all;
}

/// All ranks, or some that may be the worst and others at equal distances.
std::vector<int> choose_sample(const std::vector<RankShare>& all, int most) {
  const auto ranks = static_cast<int>(all.size());
  std::set<int> sample;
  if (ranks > most)
    for (auto count : {&RankShare::bodies, &RankShare::pairs, &RankShare::boundary})
      sample.insert(std::ranges::max_element(all, {}, count)->rank);
  const int others = std::min(ranks, most) - static_cast<int>(sample.size());
  for (int k = 0; k < others; ++k)
    sample.insert(static_cast<int>(part_begin(ranks, 2 * k + 1, 2 * others)));
  return {sample.begin(), sample.end()};
}

}  // namespace

SharedState shared_state(const World& world, FoundPairs found) {
  SharedState state{.bodies = world.bodies,
                    .period = world.period,
                    .reach = std::move(found.reach),
                    .work = std::move(found.work),
                    .pairs = std::move(found.pairs),
                    .near_clumps = world.has_near_clumps() ? world.gravity.near_clumps : 0};
  resize(state.bodies, state.bodies.owned);
  if (found.members) {
    state.members = *found.members;
    resize(state.members, state.members.owned);
    state.members.position = found.search->found_at;
    state.whole = {found.whole.begin(), found.whole.end()};
    state.bodies.position = {found.bodies_at.begin(), found.bodies_at.end()};
  } else {
    state.bodies.position = found.search->found_at;
  }
  const Index rows = state.rows().owned;
  // Two bodies that meet across a period do so twice: as either one's image.
  const std::vector<Index> original = originals(found.search->ghosts);
  Links& pairs = state.pairs;
  std::size_t kept = 0;
  for (std::size_t p = 0; p < pairs.i.size(); ++p) {
    const Index i = pairs.i[p], j = pairs.j[p];
    if (j >= rows && original[j] < i) continue;
    pairs.i[kept] = original[i];
    pairs.j[kept++] = original[j];
  }
  pairs.i.resize(kept);
  pairs.j.resize(kept);
  return state;
}

std::vector<double> SharedState::first_work() const {
  if (whole.empty()) return std::vector<double>(bodies.owned, 1.0);
  std::vector<double> counts(bodies.owned, 0.0);
  for (const Index body : whole) ++counts[body];
  return counts;
}

RankShares share_out(const SharedState& state, int ranks, int most) {
  const Bodies& bodies = state.bodies;
  require(bodies.owned >= ranks, "{} bodies on {} ranks: plan for at most {}", bodies.owned, ranks,
          bodies.owned);
  const Comm alone(MPI_COMM_SELF);
  RankShares shares;
  shares.ranks = ranks;
  std::vector<int> owner = bisect(alone, bodies, state.first_work(), ranks);
  shares.by_work = most_over_mean(sum_by_rank(owner, ranks, state.work)) > imbalance_limit;
  if (shares.by_work) owner = bisect(alone, bodies, state.work, ranks);

  std::vector<RankShare> all(ranks);
  for (int rank = 0; rank < ranks; ++rank) all[rank].rank = rank;
  for (int rank : owner) ++all[rank].bodies;
  std::vector<int> of_row = owner;
  if (!state.whole.empty()) {
    of_row.clear();
    for (const Index body : state.whole) of_row.push_back(owner[body]);
  }
  for (int rank : of_row) ++all[rank].rows;
  for (std::size_t p = 0; p < state.pairs.i.size(); ++p) {
    const int first = of_row[state.pairs.i[p]], second = of_row[state.pairs.j[p]];
    ++all[first].pairs;
    if (first == second) continue;
    ++all[second].pairs;
    ++all[first].boundary;
    ++all[second].boundary;
  }
  const std::vector<int> sample = choose_sample(all, most);
  const auto halos = foretell_halo(state.rows(), state.reach, of_row, ranks, state.period, sample);
  for (std::size_t k = 0; k < sample.size(); ++k) {
    shares.sample.push_back(all[sample[k]]);
    shares.sample.back().halo = halos[k];
  }
  if (state.near_clumps > 0) {
    const NearSearch near = search_for_near_clumps(bodies, state.near_clumps);
    const auto found = foretell_halo(near.bodies, near.reach, owner, ranks, {}, sample);
    for (std::size_t k = 0; k < sample.size(); ++k) shares.sample[k].near_clumps = found[k].search;
  }
  shares.owner = std::move(owner);
  return shares;
}

void share_out_tree(const SharedState& state, double accuracy, bool rates, RankShares& shares) {
  const Bodies& bodies = state.bodies;
  std::vector<int> sample;
  for (const RankShare& share : shares.sample) sample.push_back(share.rank);
  std::span<const Vec3> velocity;
  if (rates) velocity = bodies.velocity;
  const auto trees =
      foretell_gravity_tree(Comm(MPI_COMM_SELF), tree_settings(accuracy), bodies.mass,
                            bodies.position, velocity, shares.owner, shares.ranks, sample);
  for (std::size_t k = 0; k < trees.size(); ++k) shares.sample[k].tree = trees[k];
}

}  // namespace spall
