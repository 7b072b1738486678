// The displacements in a cell lie in a ball; those of two cells differ by what their balls span.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/motion_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "base/morton.hpp"

namespace spall {
namespace {

struct Ends {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);

  void add(const Vec3& x) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  bool meets(double margin, const Ends& other) const {
    return (other.high.array() >= low.array() - margin).all() &&
           (other.low.array() <= high.array() + margin).all();
  }
};

/// Where the bodies of each rank are. Collective.
std::vector<Ends> ends_of_ranks(const Comm& comm, std::span<const Vec3> places) {
  Ends own;
  for (const Vec3& x : places) own.add(x);
  std::vector<double> packed(own.low.begin(), own.low.end());
  packed.insert(packed.end(), own.high.begin(), own.high.end());
  packed = comm.all_gather(packed);
  std::vector<Ends> ends;
  for (std::size_t at = 0; at < packed.size(); at += 6)
    ends.push_back({Vec3(&packed[at]), Vec3(&packed[at + 3])});
  return ends;
}

using Ball = MotionCells::Ball;

/// Where bodies are (m), and their velocities (m/s).
struct Flight {
  Ball at, moves;
};
constexpr std::size_t doubles_a_flight = 8;
static_assert(sizeof(Flight) == doubles_a_flight * sizeof(double));

/// The smallest that holds both.
Ball united(const Ball& a, const Ball& b) {
  const Vec3 apart = b.centre - a.centre;
  const double distance = apart.norm();
  if (distance + b.radius <= a.radius) return a;
  if (distance + a.radius <= b.radius) return b;
  const double radius = (distance + a.radius + b.radius) / 2;
  return {a.centre + (radius - a.radius) / distance * apart, radius};
}

/// Halves of the cells, of their halves and so on, with what holds them. Cells that follow each
/// other are near each other.
class FlightTree {
 public:
  explicit FlightTree(std::span<const Flight> cells) : cells_(cells.size()) {
    if (!cells.empty()) grow(cells);
  }

  /// A node and the number of its cells. Its halves follow it, each with all that is below it.
  struct Part {
    const Flight* node;
    std::size_t cells;
    Part first() const { return {node + 1, cells / 2}; }
    Part second() const { return {node + 2 * (cells / 2), cells - cells / 2}; }
  };
  Part all() const { return {nodes_.data(), cells_}; }

  /// What holds all cells, as fewer than twice `most` nodes.
  std::vector<Flight> coarse(std::size_t most) const {
    std::vector<Flight> flights;
    const std::size_t each = (cells_ + most - 1) / most;
    const auto add = [&](const auto& self, Part part) -> void {
      if (part.cells > each) {
        self(self, part.first());
        self(self, part.second());
      } else {
        flights.push_back(*part.node);
      }
    };
    if (cells_ > 0) add(add, all());
    return flights;
  }

 private:
  void grow(std::span<const Flight> cells) {
    const std::size_t node = nodes_.size(), half = cells.size() / 2;
    nodes_.push_back(cells[0]);
    if (half == 0) return;
    grow(cells.first(half));
    grow(cells.subspan(half));
    const Flight &a = nodes_[node + 1], &b = nodes_[node + 2 * half];
    nodes_[node] = {united(a.at, b.at), united(a.moves, b.moves)};
  }

  std::size_t cells_;
  std::vector<Flight> nodes_;
};

/// m/s, the larger of `known` and of the speed, at most, at which a body of `a` meets one of `b`.
double fastest_meeting(FlightTree::Part a, FlightTree::Part b, double known) {
  if (a.cells == 0 || b.cells == 0) return known;
  const Vec3 x = b.node->at.centre - a.node->at.centre;
  const Vec3 v = b.node->moves.centre - a.node->moves.centre;
  const double distance = x.norm(), speed = v.norm();
  const double near = a.node->at.radius + b.node->at.radius;
  const double spread = a.node->moves.radius + b.node->moves.radius;
  const bool part = x.dot(v) >= distance * spread + speed * near + near * spread;
  if (part || speed + spread <= known) return known;
  if (a.cells == 1 && b.cells == 1) return speed + spread;
  if (a.node == b.node) {
    known = fastest_meeting(a.first(), a.second(), known);
    known = fastest_meeting(a.first(), a.first(), known);
    return fastest_meeting(a.second(), a.second(), known);
  }
  if (a.cells < b.cells) std::swap(a, b);
  return fastest_meeting(a.second(), b, fastest_meeting(a.first(), b, known));
}

}  // namespace

MotionCells::MotionCells(const Comm& comm, std::span<const Vec3> places, double edge)
    : edge_(edge), cell_of_(places.size()) {
  std::vector<std::int64_t> key(places.size());
  for (std::size_t b = 0; b < places.size(); ++b)
    key[b] = static_cast<std::int64_t>(morton_key(places[b], edge));
  std::vector<std::int64_t> own;
  std::unique_copy(key.begin(), key.end(), std::back_inserter(own));
  std::sort(own.begin(), own.end());
  own.erase(std::unique(own.begin(), own.end()), own.end());
  count_ = static_cast<Index>(own.size());
  for (std::size_t b = 0; b < places.size(); ++b)
    cell_of_[b] =
        static_cast<Index>(std::lower_bound(own.begin(), own.end(), key[b]) - own.begin());

  // Bodies of cells that touch are at most two edges apart in any direction.
  const std::vector<Ends> ends = ends_of_ranks(comm, places);
  ByRank<std::int64_t> outgoing;  // key and number of a cell
  for (int rank = 0; rank < comm.size; ++rank) {
    if (rank == comm.rank || !ends[rank].meets(2 * edge, ends[comm.rank])) continue;
    std::vector<bool> near(count_, false);
    for (std::size_t b = 0; b < places.size(); ++b)
      if (ends[rank].meets(2 * edge, {places[b], places[b]})) near[cell_of_[b]] = true;
    for (Index c = 0; c < count_; ++c)
      if (near[c]) outgoing[rank].insert(outgoing[rank].end(), {own[c], c});
  }
  struct Cell {
    std::int64_t key;
    Index number;
  };
  std::vector<Cell> known;
  for (Index c = 0; c < count_; ++c) known.push_back({own[c], c});
  std::vector<Origin> origins;
  for (const auto& [rank, cells] : comm.exchange(std::move(outgoing)))
    for (std::size_t k = 0; k < cells.size(); k += 2) {
      known.push_back({cells[k], static_cast<Index>(known.size())});
      origins.push_back({rank, static_cast<Index>(cells[k + 1])});
    }
  ghosts_ = Ghosts(comm, count_, origins);
  std::sort(known.begin(), known.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
  for (Index c = 0; c < count_; ++c)
    for (std::uint64_t near : keys_around(static_cast<std::uint64_t>(own[c]))) {
      const auto wanted = static_cast<std::int64_t>(near);
      auto at = std::lower_bound(known.begin(), known.end(), wanted,
                                 [](const Cell& cell, std::int64_t k) { return cell.key < k; });
      for (; at != known.end() && at->key == wanted; ++at)
        if (at->number >= c) touching_.push_back({c, at->number});
    }
}

std::vector<MotionCells::Ball> MotionCells::own_balls(std::span<const Vec3> vectors) const {
  std::vector<Ends> ends(count_);
  for (std::size_t b = 0; b < vectors.size(); ++b) ends[cell_of_[b]].add(vectors[b]);
  std::vector<Ball> own(count_);
  for (Index c = 0; c < count_; ++c) own[c].centre = (ends[c].low + ends[c].high) / 2;
  for (std::size_t b = 0; b < vectors.size(); ++b) {
    Ball& ball = own[cell_of_[b]];
    ball.radius = std::max(ball.radius, (vectors[b] - ball.centre).squaredNorm());
  }
  for (Ball& ball : own) ball.radius = std::sqrt(ball.radius);
  return own;
}

double MotionCells::approach(const Comm& comm, double range,
                             std::span<const Vec3> displacement) const {
  std::vector<Ball> balls = own_balls(displacement);
  Ends ends;
  for (const Ball& ball : balls) {
    ends.add(ball.centre - Vec3::Constant(ball.radius));
    ends.add(ball.centre + Vec3::Constant(ball.radius));
  }
  balls.resize(count_ + ghosts_.ghosts());
  ghosts_.gather(reinterpret_cast<double*>(balls.data()), doubles_a_ball);
  double touching = 0;
  for (const auto& [a, b] : touching_)
    touching = std::max(
        touching, (balls[a].centre - balls[b].centre).norm() + balls[a].radius + balls[b].radius);
  std::array<double, 7> most{touching,     -ends.low[0], -ends.low[1], -ends.low[2],
                             ends.high[0], ends.high[1], ends.high[2]};
  comm.max(most);
  // Bodies of cells that do not touch were an edge apart, at least.
  const double widest = (Vec3(&most[4]) + Vec3(&most[1])).norm();
  return std::max(most[0], widest - (edge_ - range));
}

double MotionCells::closing_speed(const Comm& comm, std::span<const Vec3> places,
                                  std::span<const Vec3> velocity, int most_told) const {
  const std::vector<Ball> at = own_balls(places), moves = own_balls(velocity);
  std::vector<Flight> cells(count_);
  for (Index c = 0; c < count_; ++c) cells[c] = {at[c], moves[c]};
  const FlightTree own(cells);

  const std::vector<Flight> told = own.coarse(std::max(1, most_told / comm.size));
  const std::vector<double> gathered = comm.all_gather(
      {reinterpret_cast<const double*>(told.data()), doubles_a_flight * told.size()});
  const auto first = static_cast<std::size_t>(comm.sum_before(std::int64_t(told.size())));
  std::vector<Flight> others(gathered.size() / doubles_a_flight);
  std::copy(gathered.begin(), gathered.end(), reinterpret_cast<double*>(others.data()));
  others.erase(others.begin() + first, others.begin() + first + told.size());

  const double among_own = fastest_meeting(own.all(), own.all(), 0);
  return comm.max(fastest_meeting(own.all(), FlightTree(others).all(), among_own));
}

}  // namespace spall
