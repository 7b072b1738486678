// What each of many ranks would have and tell others, counted by the code of runs on one rank.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "domain/halo.hpp"
#include "engine/engine.hpp"
#include "gravity/tree.hpp"
#include "state/world.hpp"

namespace spall {

/// All bodies of a world on one rank, where their pairs were found last.
struct SharedState {
  Bodies bodies;
  Bodies members{};            ///< spheres of clumps where these meet; none where bodies do
  std::vector<Index> whole{};  ///< of a member: its body
  Period period;
  std::vector<double> reach;  ///< m, beyond its sphere, up to which a row was to meet others
  std::vector<double> work;   ///< of a body, as the domain is cut by
  Links pairs;                ///< of rows, each once; an image stands for what it is of
  double near_clumps = 0;     ///< of gravity; 0: clumps attract by their centres alone

  /// The rows that meet: bodies, or the members of clumps.
  const Bodies& rows() const { return whole.empty() ? bodies : members; }

  /// Of a body, as a run's first cut goes by: its rows.
  std::vector<double> first_work() const;
};

/// By what the engine of `world` found, which is on one rank.
SharedState shared_state(const World& world, FoundPairs found);

/// Of one rank.
struct RankShare {
  int rank = 0;
  std::int64_t bodies = 0;
  std::int64_t rows = 0;      ///< that meet others: bodies, or the members of clumps
  std::int64_t pairs = 0;     ///< with one of its bodies, at least
  std::int64_t boundary = 0;  ///< of them, with another rank's
  HaloShare halo;             ///< of rows
  TreeShare tree;             ///< of one evaluation; empty without a tree of gravity
  Traffic near_clumps;        ///< of its search for clumps that are near
};

struct RankShares {
  int ranks = 1;
  bool by_work = false;    ///< cut a second time, as the work of the first shares was uneven
  std::vector<int> owner;  ///< of each body
  std::vector<RankShare> sample;
};

/// The shares of `ranks` ranks by bisection, of all of them or of a sample of `most`: those with
/// most bodies, pairs and pairs with ghosts, and others at equal distances. The domain is cut as in
/// a run: by rows, and by the bodies' work where that differs by more than a tenth. Throws Error
/// where there are more ranks than bodies.
RankShares share_out(const SharedState& state, int ranks, int most);

/// Adds what an evaluation of gravity's tree sends from the ranks of the sample. `rates`: how fast
/// the field changes is evaluated, too.
void share_out_tree(const SharedState& state, double accuracy, bool rates, RankShares& shares);

}  // namespace spall
