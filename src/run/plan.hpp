// What more ranks would bring: real shares of a case, and a model of the time of a step.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "run/foretell.hpp"
#include "run/network.hpp"
#include "run/rank_shares.hpp"
#include "spall/simulation.hpp"

namespace spall {

/// Steps that one rank made with all bodies.
struct OneRank {
  Sample sample;
  SharedState state;       ///< in which they began
  double time = 0;         ///< s since the start, of that
  double searches = 0;     ///< for pairs, a step
  double evaluations = 0;  ///< of gravity, a step
  bool rates = false;      ///< evaluations tell how fast the field changes
  bool tree = false;       ///< gravity is evaluated by a tree
  Traffic of_tree;         ///< of one evaluation by it
  double accuracy = 0;     ///< of the tree
};

/// Makes a step and then steps for so many seconds. Throws Error where there is nothing to plan.
/// `simulation` is on one rank, its phase has begun.
OneRank try_one_rank(Simulation& simulation, double seconds);

/// A stage of a step of one rank among many.
struct StageCost {
  std::string stage;
  double messages = 0, bytes = 0, collectives = 0;  ///< sent, or taken part in, a step
  double work = 0;                                  ///< s
  double even_work = 0;                             ///< s: of one rank alone, over their number
  /// s: by latency of messages, by bytes, by collectives, beyond what work hides
  double by_messages = 0, by_bytes = 0, by_collectives = 0;

  double seconds() const { return work + by_messages + by_bytes + by_collectives; }
};

/// A rank's stages, and last what belongs to none.
std::vector<StageCost> foretell_step(const OneRank& one, const RankShare& share, int ranks,
                                     const Network& network);

struct PlanRequest {
  std::vector<int> ranks;                    ///< for how many
  std::optional<double> latency, bandwidth;  ///< s, bytes/s; else measured or assumed
  bool calibrate = false;                    ///< measure them between two ranks of these
  std::vector<std::string> overrides;        ///< of the case
};

/// Plans for a case, as its first phase begins, or for a restart file, "x.h5", as it goes on. Rank
/// 0 does all of it and gets the text. Throws Error where a run would, and where a plan cannot be
/// made. Collective.
std::string plan(const Comm& comm, const std::string& file, const PlanRequest& request);

}  // namespace spall
