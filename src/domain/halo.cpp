// Ranks tell their neighbours the boxes of small clusters; a body goes where it meets one, and
// stays where it meets a body.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/halo.hpp"

#include <algorithm>
#include <map>
#include <set>

#include "base/morton.hpp"
#include "base/sort_by_key.hpp"
#include "state/pack.hpp"

namespace spall {
namespace {

constexpr std::size_t bodies_a_cluster = 4;  // that follow each other along a space-filling curve
constexpr double wide = 2;                   // a cluster this many times as wide as most is parted
constexpr double large = 4;     // a body this many times the mean radius is a cluster of its own
constexpr std::size_t fan = 8;  // boxes that one of the next level of the tree holds

/// All points within `radius` of the box from `low` to `high`.
struct RoundBox {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  double radius = 0;

  void add(const Vec3& center, double r) {
    low = low.cwiseMin(center);
    high = high.cwiseMax(center);
    radius = std::max(radius, r);
  }
  /// All of the other as a box without roundness: a single giant must not make all others round.
  void hold(const RoundBox& other) {
    low = low.cwiseMin(other.low - Vec3::Constant(other.radius));
    high = high.cwiseMax(other.high + Vec3::Constant(other.radius));
  }
  RoundBox moved(const Vec3& by) const { return {low + by, high + by, radius}; }
  bool meets(const RoundBox& other) const {
    double gap2 = 0;
    for (int k = 0; k < 3; ++k) {
      const double gap = std::max({low[k] - other.high[k], other.low[k] - high[k], 0.0});
      gap2 += gap * gap;
    }
    const double reach = radius + other.radius;
    return gap2 <= reach * reach;
  }
  double width() const { return (high - low).maxCoeff(); }
};
constexpr std::size_t doubles_a_box = 7;
static_assert(sizeof(RoundBox) == doubles_a_box * sizeof(double));

struct Cluster {
  RoundBox box;
  std::span<const Index> rows;
};

/// All by which an image may be away from its body, none first.
std::vector<Vec3> shifts_of(const Period& period) {
  std::vector<Vec3> shifts{Vec3::Zero()};
  for (int k = 0; k < 3; ++k)
    for (std::size_t s = 0, before = shifts.size(); s < before && period.size[k] > 0; ++s)
      for (double sign : {-1.0, 1.0})
        shifts.push_back(shifts[s] + sign * period.size[k] * Vec3::Unit(k));
  return shifts;
}

RoundBox ball(const Bodies& bodies, std::span<const double> reach, Index b) {
  return {bodies.position[b], bodies.position[b], bodies.radius[b] + reach[b]};
}

/// Rows of owned bodies along a space-filling curve through cells as wide as `edge`. Bodies wander
/// and are wrapped: the order in memory is no such curve for long.
std::vector<Index> along_curve(const Bodies& bodies, double edge) {
  std::vector<KeyedRow> order;
  order.reserve(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b)
    order.push_back({morton_key(bodies.position[b], edge), b});
  sort_by_key(order);
  std::vector<Index> rows;
  rows.reserve(order.size());
  for (const KeyedRow& r : order) rows.push_back(r.row);
  return rows;
}

Cluster cluster_of(const Bodies& bodies, std::span<const double> reach,
                   std::span<const Index> rows) {
  Cluster cluster{{}, rows};
  for (Index b : rows) cluster.box.add(bodies.position[b], bodies.radius[b] + reach[b]);
  return cluster;
}

/// Runs of rows along the curve. Where it jumps, a run is parted in halves until none is wide.
std::vector<Cluster> cluster_bodies(const Bodies& bodies, std::span<const double> reach,
                                    double mean, std::span<const Index> rows) {
  const auto is_large = [&](Index b) { return bodies.radius[b] + reach[b] > large * mean; };
  std::vector<Cluster> runs;
  for (std::size_t k = 0, end; k < rows.size(); k = end) {
    end = k + 1;
    if (!is_large(rows[k]))
      while (end < rows.size() && end - k < bodies_a_cluster && !is_large(rows[end])) ++end;
    runs.push_back(cluster_of(bodies, reach, rows.subspan(k, end - k)));
  }
  if (runs.empty()) return runs;

  std::vector<double> widths;
  for (const Cluster& run : runs) widths.push_back(run.box.width());
  const auto median = widths.begin() + static_cast<std::ptrdiff_t>(widths.size() / 2);
  std::nth_element(widths.begin(), median, widths.end());
  const double widest = wide * *median;
  std::vector<Cluster> clusters;
  const auto part = [&](const Cluster& run, auto&& again) -> void {
    if (run.box.width() <= widest || run.rows.size() == 1) {
      clusters.push_back(run);
      return;
    }
    const std::size_t half = run.rows.size() / 2;
    again(cluster_of(bodies, reach, run.rows.first(half)), again);
    again(cluster_of(bodies, reach, run.rows.subspan(half)), again);
  };
  for (const Cluster& run : runs) part(run, part);
  return clusters;
}

double mean_radius(const Bodies& bodies, std::span<const double> reach) {
  double sum = 0;
  for (Index b = 0; b < bodies.owned; ++b) sum += bodies.radius[b] + reach[b];
  return sum / std::max<Index>(bodies.owned, 1);
}

/// A box without roundness that holds all owned bodies; empty without any.
RoundBox whole_of(const Bodies& bodies, std::span<const double> reach) {
  RoundBox whole;
  for (Index b = 0; b < bodies.owned; ++b) whole.hold(ball(bodies, reach, b));
  return whole;
}

/// Boxes of clusters, boxes of those, and so on up to one that holds all.
class ClusterTree {
 public:
  ClusterTree() : levels_(1) {}
  ClusterTree(const Bodies& bodies, std::span<const double> reach) : levels_(1) {
    const double mean = mean_radius(bodies, reach);
    rows_ = along_curve(bodies, mean);
    clusters_ = cluster_bodies(bodies, reach, mean, rows_);
    for (const Cluster& cluster : clusters_) levels_[0].push_back(cluster.box);
    while (levels_.back().size() > 1) {
      std::vector<RoundBox> above((levels_.back().size() + fan - 1) / fan);
      for (std::size_t k = 0; k < levels_.back().size(); ++k)
        above[k / fan].hold(levels_.back()[k]);
      levels_.push_back(std::move(above));
    }
  }

  /// Calls `f(cluster, those that it meets)` with each that meets any of `boxes`, in order.
  template <class F>
  void for_each_meeting(std::span<const RoundBox> boxes, F&& f) const {
    visit(levels_.size() - 1, 0, boxes, f);
  }

  /// Whether any of the bodies, which the tree is of, meets the ball.
  bool meets(const Bodies& bodies, std::span<const double> reach, const RoundBox& other) const {
    return meets(levels_.size() - 1, 0, bodies, reach, other);
  }

 private:
  bool meets(std::size_t level, std::size_t from, const Bodies& bodies,
             std::span<const double> reach, const RoundBox& other) const {
    for (std::size_t k = from; k < std::min(from + fan, levels_[level].size()); ++k) {
      if (!levels_[level][k].meets(other)) continue;
      if (level > 0 ? meets(level - 1, fan * k, bodies, reach, other)
                    : std::ranges::any_of(clusters_[k].rows, [&](Index b) {
                        return ball(bodies, reach, b).meets(other);
                      }))
        return true;
    }
    return false;
  }
  template <class F>
  void visit(std::size_t level, std::size_t from, std::span<const RoundBox> boxes, F& f) const {
    std::vector<RoundBox> met;
    for (std::size_t k = from; k < std::min(from + fan, levels_[level].size()); ++k) {
      const RoundBox& own = levels_[level][k];
      met.clear();
      std::copy_if(boxes.begin(), boxes.end(), std::back_inserter(met),
                   [&](const RoundBox& box) { return box.meets(own); });
      if (met.empty()) continue;
      if (level == 0)
        f(clusters_[k], met);
      else
        visit(level - 1, fan * k, met, f);
    }
  }

  std::vector<Index> rows_;  // along the curve
  std::vector<Cluster> clusters_;
  std::vector<std::vector<RoundBox>> levels_;
};

void append(std::vector<double>& row, const RoundBox& box) {
  row.insert(row.end(), box.low.data(), box.low.data() + 3);
  row.insert(row.end(), box.high.data(), box.high.data() + 3);
  row.push_back(box.radius);
}
RoundBox box_from(const double* row) {
  return {Vec3(row[0], row[1], row[2]), Vec3(row[3], row[4], row[5]), row[6]};
}

/// An image of a rank that bodies of this one may meet.
struct Neighbour {
  int rank;
  std::size_t shift;  // its number
  RoundBox whole;     // moved by the shift
};

/// Of one rank, among the wholes of all.
std::vector<Neighbour> neighbours_of(int own, std::span<const RoundBox> wholes,
                                     const std::vector<Vec3>& shifts) {
  std::vector<Neighbour> neighbours;
  for (int rank = 0; rank < std::ssize(wholes); ++rank)
    for (std::size_t s = 0; s < shifts.size(); ++s) {
      if (rank == own && s == 0) continue;
      const RoundBox theirs = wholes[rank].moved(shifts[s]);
      if (theirs.meets(wholes[own])) neighbours.push_back({rank, s, theirs});
    }
  return neighbours;
}

/// Collective.
std::vector<RoundBox> gather_wholes(const Comm& comm, const RoundBox& own) {
  std::vector<double> row;
  append(row, own);
  const std::vector<double> rows = comm.all_gather(std::span<const double>(row));
  std::vector<RoundBox> wholes;
  for (std::size_t at = 0; at < rows.size(); at += doubles_a_box)
    wholes.push_back(box_from(&rows[at]));
  return wholes;
}

/// By rank: boxes of own clusters that its bodies may meet, each after the number of the shift by
/// which its bodies are moved then; shift by shift.
ByRank<double> boxes_for(const std::vector<Neighbour>& neighbours, const ClusterTree& tree) {
  ByRank<double> outgoing;
  for (const Neighbour& beside : neighbours)
    tree.for_each_meeting(std::span(&beside.whole, 1), [&](const Cluster& cluster, const auto&) {
      outgoing[beside.rank].push_back(static_cast<double>(beside.shift));
      append(outgoing[beside.rank], cluster.box);
    });
  return outgoing;
}

/// Calls `f(move, b)` with each owned body that meets one of a rank's boxes once it is moved.
template <class F>
void for_each_asked(const Bodies& bodies, std::span<const double> reach, const ClusterTree& tree,
                    const std::vector<Vec3>& moves, const std::vector<double>& boxes, F&& f) {
  std::vector<RoundBox> beside;  // as seen from bodies that are not moved
  for (auto box = boxes.begin(); box != boxes.end();) {
    const double number = *box;
    const Vec3& move = moves[static_cast<std::size_t>(number)];
    beside.clear();
    for (; box != boxes.end() && *box == number; box += 1 + doubles_a_box)
      beside.push_back(box_from(&box[1]).moved(-move));
    tree.for_each_meeting(beside, [&](const Cluster& cluster, const std::vector<RoundBox>& near) {
      for (Index b : cluster.rows) {
        const RoundBox own = ball(bodies, reach, b);
        if (std::ranges::any_of(near, [&](const RoundBox& other) { return other.meets(own); }))
          f(move, b);
      }
    });
  }
}

constexpr std::size_t doubles_before_row = 5;  // of a ghost: its shift, row and reach

}  // namespace

Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach, const Period& period,
                 std::vector<Vec3>& shifts) {
  resize(bodies, bodies.owned);
  reach.resize(bodies.owned);
  const std::vector<Vec3> moves = shifts_of(period);
  const auto wholes = gather_wholes(comm, whole_of(bodies, reach));
  const auto neighbours = neighbours_of(comm.rank, wholes, moves);
  // Without any, as on one rank without a period, neither curve nor clusters are needed.
  const ClusterTree tree = neighbours.empty() ? ClusterTree() : ClusterTree(bodies, reach);

  ByRank<double> outgoing;
  for (const auto& [rank, boxes] : comm.exchange(boxes_for(neighbours, tree))) {
    std::vector<double>& row = outgoing[rank];
    for_each_asked(bodies, reach, tree, moves, boxes, [&](const Vec3& move, Index b) {
      row.insert(row.end(), move.data(), move.data() + 3);
      row.push_back(b);
      row.push_back(reach[b]);
      pack_row(bodies, b, trait::ghosted, row);
    });
  }

  const auto incoming = comm.exchange(std::move(outgoing));
  const std::size_t width = doubles_before_row + packed_row_width(bodies, trait::ghosted);
  // Fields grow once, and by no more than what came.
  std::size_t arriving = 0;
  for (const auto& [rank, rows] : incoming) arriving += rows.size();
  const std::size_t size = bodies.owned + arriving / width;
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(size); });
  std::vector<Origin> origins;
  shifts.clear();
  for (const auto& [rank, rows] : incoming)
    for (std::size_t k = 0; k < rows.size(); k += width) {
      const Vec3 shift(rows[k], rows[k + 1], rows[k + 2]);
      reach.push_back(rows[k + 4]);
      unpack_rows(bodies,
                  std::span(rows).subspan(k + doubles_before_row, width - doubles_before_row),
                  trait::ghosted);
      bodies.position.back() += shift;
      const Index ghost = bodies.size() - 1;
      if (!tree.meets(bodies, reach, ball(bodies, reach, ghost))) {
        resize(bodies, ghost);
        reach.pop_back();
        continue;
      }
      shifts.push_back(shift);
      origins.push_back({rank, static_cast<Index>(rows[k + 3])});
    }
  return Ghosts(comm, bodies.owned, origins);
}

namespace {

/// A rank that is not there: its bodies are rows of another one's.
struct AbsentRank {
  Bodies bodies;  // with the fields that a halo is made by
  std::vector<double> reach;
  ClusterTree tree;

  AbsentRank(const Bodies& all, std::span<const double> reach_of_all, std::span<const Index> rows) {
    resize(bodies, static_cast<Index>(rows.size()));
    bodies.owned = bodies.size();
    for (std::size_t k = 0; k < rows.size(); ++k) {
      bodies.position[k] = all.position[rows[k]];
      bodies.radius[k] = all.radius[rows[k]];
      reach.push_back(reach_of_all[rows[k]]);
    }
    if (!rows.empty()) tree = ClusterTree(bodies, reach);
  }
};

}  // namespace

std::vector<HaloShare> foretell_halo(const Bodies& bodies, std::span<const double> reach,
                                     std::span<const int> owner, int ranks, const Period& period,
                                     std::span<const int> sample) {
  std::vector<std::vector<Index>> rows(ranks);
  std::vector<RoundBox> wholes(ranks);
  for (Index b = 0; b < bodies.owned; ++b) {
    rows[owner[b]].push_back(b);
    wholes[owner[b]].hold(ball(bodies, reach, b));
  }
  std::map<int, AbsentRank> made;
  const auto rank_of = [&](int rank) -> const AbsentRank& {
    return made.try_emplace(rank, bodies, reach, rows[rank]).first->second;
  };
  const std::vector<Vec3> moves = shifts_of(period);
  std::map<int, ByRank<double>> boxes_made;
  const auto boxes_of = [&](int rank) -> const ByRank<double>& {
    const auto [at, is_new] = boxes_made.try_emplace(rank);
    if (is_new) at->second = boxes_for(neighbours_of(rank, wholes, moves), rank_of(rank).tree);
    return at->second;
  };
  // Bodies of `rank` that the other one is sent by its boxes, and how many of them it keeps.
  struct Asked {
    std::int64_t sent = 0, kept = 0;
  };
  const auto count_asked = [&](int rank, int other, const std::vector<double>& boxes) {
    const AbsentRank &of = rank_of(rank), &by = rank_of(other);
    Asked count;
    for_each_asked(of.bodies, of.reach, of.tree, moves, boxes, [&](const Vec3& move, Index b) {
      ++count.sent;
      const RoundBox moved = ball(of.bodies, of.reach, b).moved(move);
      count.kept += by.tree.meets(by.bodies, by.reach, moved);
    });
    return count;
  };

  const auto width =
      static_cast<std::int64_t>(doubles_before_row + packed_row_width(bodies, trait::ghosted));
  std::vector<HaloShare> shares;
  for (int own : sample) {
    HaloShare& share = shares.emplace_back();
    std::int64_t doubles = 0, boxes_came = 0, senders = 0;
    for (const auto& [other, boxes] : boxes_of(own)) {
      const Asked came = count_asked(other, own, boxes);
      share.ghosts += came.kept;
      if (other == own) continue;
      share.sources += came.kept > 0;
      senders += came.sent > 0;
      ++share.search.messages;
      doubles += std::ssize(boxes);
    }
    std::set<int> others;
    for (const Neighbour& beside : neighbours_of(own, wholes, moves)) others.insert(beside.rank);
    for (int other : others) {
      const ByRank<double>& boxes = boxes_of(other);
      const auto for_own = boxes.find(own);
      if (for_own == boxes.end() || other == own) continue;
      ++boxes_came;
      const Asked went = count_asked(own, other, for_own->second);
      share.copies += went.kept;
      share.holders += went.kept > 0;
      share.search.messages += went.sent > 0;
      doubles += width * went.sent;
    }
    share.search.bytes = static_cast<std::int64_t>(sizeof(double)) * doubles;
    share.search.sources = std::max(boxes_came, senders);
  }
  return shares;
}

void refresh_ghosts(const Ghosts& ghosts, Bodies& bodies) {
  std::vector<FieldRows> fields;
  for_each_field(bodies, [&]<class T>(const TypedField<T>& info, auto& field) {
    if (info.is(trait::refreshed))
      fields.push_back(
          {reinterpret_cast<double*>(field.data()), static_cast<int>(packed_width<T>)});
  });
  ghosts.gather(fields);
}

}  // namespace spall
