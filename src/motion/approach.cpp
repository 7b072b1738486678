// Two trees of boxes, compared from their roots on.
// SPDX-License-Identifier: BSD-3-Clause
#include "approach.hpp"

#include <cmath>
#include <cstring>

#include "flight.hpp"

namespace spall {
namespace {

constexpr std::size_t doubles_a_leaf = sizeof(Leaf) / sizeof(double);

/// The fourth lane of `place` is the largest half, that of `moved` zero.
struct Node {
  Box place, moved;
  void add(const Node& other) {
    for (const RowHalf& corner : {other.place.low, other.place.high}) place.add(corner);
    for (const RowHalf& corner : {other.moved.low, other.moved.high}) moved.add(corner);
  }
};
constexpr std::size_t doubles_a_node = sizeof(Node) / sizeof(double);

Node node_of(const Leaf& leaf) {
  Node node;
  for (std::size_t l = 0; l < lane_count; ++l) {
    const auto row = [&](const Lanes(&v)[3], double w) {
      return RowHalf{v[0][l], v[1][l], v[2][l], w};
    };
    const RowHalf place = row(leaf.place, leaf.half[l]), moved = row(leaf.moved, 0);
    const RowHalf ahead = row(leaf.ahead, 0);
    for (const RowHalf& end : {place, place + ahead}) node.place.add(end);
    for (const RowHalf& end : {moved, moved + ahead}) node.moved.add(end);
  }
  return node;
}

RowHalf larger(const RowHalf& a, const RowHalf& b) {
  return a > b ? a : b;
}
double square(const RowHalf& v) {
  return v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
}

class Approach {
 public:
  Approach(const std::vector<Leaf>& leaves, const Period& period, double least, double skin)
      : leaves_(leaves), period_(period), skin_(skin), furthest_(least) {
    levels_.emplace_back();
    for (const Leaf& leaf : leaves) levels_[0].push_back(node_of(leaf));
    while (levels_.back().size() > 1) {
      const std::vector<Node>& below = levels_.back();
      std::vector<Node> above((below.size() + 1) / 2);
      for (std::size_t k = 0; k < below.size(); ++k) above[k / 2].add(below[k]);
      levels_.push_back(std::move(above));
    }
  }

  double furthest() const { return furthest_; }
  /// What is known of other ranks: less need not be told apart any more.
  void know(double furthest) { furthest_ = furthest; }
  /// Without bodies: a box that holds nothing.
  Node root() const { return leaves_.empty() ? Node{} : levels_.back()[0]; }

  void compare_all() {
    if (!leaves_.empty()) compare(levels_.size() - 1, 0, 0);
  }
  /// With a leaf of another rank.
  void compare_with(const Leaf& other) {
    for_each_unsettled(node_of(other), [&](const Leaf& leaf) { compare(leaf, other); });
  }
  /// Calls `f(leaf)` for leaves that may have come nearer to something in the box than is known.
  template <class F>
  void for_each_unsettled(const Node& box, F&& f) const {
    if (!leaves_.empty() && box.place.low[0] <= box.place.high[0])
      descend(levels_.size() - 1, 0, box, f);
  }

 private:
  bool settled(const Node& a, const Node& b) const {
    if (furthest_ > skin_) return true;  // as much as one wants to know
    const RowHalf differ = larger(a.moved.high - b.moved.low, b.moved.high - a.moved.low);
    if (square(differ) <= furthest_ * furthest_) return true;
    RowHalf gap = larger(a.place.low - b.place.high, b.place.low - a.place.high);
    for (int k = 0; k < 3 && period_.any(); ++k) {
      const double size = period_.size[k];
      if (size == 0) continue;
      const double sum = (a.place.high[k] - a.place.low[k]) + (b.place.high[k] - b.place.low[k]);
      const double centres =
          (a.place.high[k] + a.place.low[k]) - (b.place.high[k] + b.place.low[k]);
      gap[k] = std::abs(std::remainder(centres / 2, size)) - sum / 2;
    }
    const double nearer = a.place.high[3] + b.place.high[3] - furthest_;
    return nearer <= 0 || square(larger(gap, RowHalf{})) >= nearer * nearer;
  }

  void compare(std::size_t level, std::size_t a, std::size_t b) {
    if (settled(levels_[level][a], levels_[level][b])) return;
    if (level == 0) return compare(leaves_[a], leaves_[b]);
    const std::size_t size = levels_[level - 1].size();
    for (std::size_t i = 2 * a; i < std::min(2 * a + 2, size); ++i)
      for (std::size_t j = a == b ? i : 2 * b; j < std::min(2 * b + 2, size); ++j)
        compare(level - 1, i, j);
  }

  template <class F>
  void descend(std::size_t level, std::size_t a, const Node& box, F&& f) const {
    if (settled(levels_[level][a], box)) return;
    if (level == 0) return f(leaves_[a]);
    for (std::size_t i = 2 * a; i < std::min(2 * a + 2, levels_[level - 1].size()); ++i)
      descend(level - 1, i, box, f);
  }

  /// Every body with every other. What was nearer than its length, by more than round-off, is
  /// listed.
  void compare(const Leaf& a, const Leaf& b) {
    constexpr double surely = (1 - 1e-6) * (1 - 1e-6);
    const Lanes known = spread(furthest_), zero{};
    Lanes furthest2 = known * known;
    for (std::size_t l = 0; l < lane_count; ++l) {
      Lanes before2{}, now2{}, then2{}, least2{};
      for (int k = 0; k < 3; ++k) {
        const Lanes now = b.moved[k] - a.moved[k][l], ahead = b.ahead[k] - a.ahead[k][l];
        const Lanes then = now + ahead;
        Lanes place = b.place[k] - a.place[k][l], before = place - now, least{};
        if (const double size = period_.size[k]; size > 0) {
          for (std::size_t m = 0; m < lane_count; ++m) {
            place[m] = std::remainder(place[m], size);
            // Nearer than this is no image; where another one may become the nearest, it is not
            // known which one was listed.
            const double flies = std::abs(ahead[m]);
            least[m] = std::max(0.0, std::abs(place[m]) - flies);
            before[m] = std::abs(place[m]) + flies < size / 2 ? place[m] - now[m] : infinity;
          }
          least2 += least * least;
        } else {
          // Between here and there, along this axis: 0 if they pass each other.
          const Lanes there = place + ahead, here2 = place * place, there2 = there * there;
          least = here2 < there2 ? here2 : there2;
          least2 += place * there > zero ? least : zero;
        }
        before2 += before * before;
        now2 += now * now;
        then2 += then * then;
      }
      const Lanes length = b.half + a.half[l], near = length - known;
      const auto counts =
          (before2 >= surely * length * length) & (near > zero) & (least2 < near * near);
      const Lanes moved2 = counts ? (now2 > then2 ? now2 : then2) : zero;
      furthest2 = moved2 > furthest2 ? moved2 : furthest2;
    }
    for (std::size_t m = 0; m < lane_count; ++m)
      furthest_ = std::max(furthest_, std::sqrt(furthest2[m]));
  }

  const std::vector<Leaf>& leaves_;
  const Period& period_;
  double skin_, furthest_;
  std::vector<std::vector<Node>> levels_;  // a node and the next one make one of the next level
};

}  // namespace

double furthest_approach(const Comm& comm, const Period& period, const std::vector<Leaf>& leaves,
                         double least, double skin) {
  Approach own(leaves, period, least, skin);
  own.compare_all();
  if (comm.size == 1) return own.furthest();
  own.know(comm.max(own.furthest()));
  const Node root = own.root();
  const auto roots = comm.all_gather(
      std::span<const double>(reinterpret_cast<const double*>(&root), doubles_a_node));
  std::vector<std::vector<double>> outgoing(comm.size);
  for (int rank = 0; rank < comm.rank; ++rank) {
    Node other;
    std::memcpy(static_cast<void*>(&other), &roots[rank * doubles_a_node], sizeof other);
    own.for_each_unsettled(other, [&](const Leaf& leaf) {
      const double* const first = reinterpret_cast<const double*>(&leaf);
      outgoing[rank].insert(outgoing[rank].end(), first, first + doubles_a_leaf);
    });
  }
  for (const auto& arrived : comm.exchange(outgoing))
    for (std::size_t k = 0; k < arrived.size(); k += doubles_a_leaf) {
      Leaf other;
      std::memcpy(&other, &arrived[k], sizeof other);
      own.compare_with(other);
    }
  return comm.max(own.furthest());
}

}  // namespace spall
