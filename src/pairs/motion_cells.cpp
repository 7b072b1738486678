// The displacements in a cell lie in a ball; those of two cells differ by what their balls span.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/motion_cells.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>

#include "base/morton.hpp"

namespace spall {

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
  first_ = static_cast<Index>(comm.sum_before(count_));
  for (std::size_t b = 0; b < places.size(); ++b)
    cell_of_[b] =
        static_cast<Index>(std::lower_bound(own.begin(), own.end(), key[b]) - own.begin());

  struct Cell {
    std::int64_t key;
    Index number;
  };
  std::vector<Cell> all;
  for (std::int64_t k : comm.all_gather(own)) all.push_back({k, static_cast<Index>(all.size())});
  std::sort(all.begin(), all.end(), [](const Cell& a, const Cell& b) { return a.key < b.key; });
  for (Index c = 0; c < count_; ++c)
    for (std::uint64_t near : keys_around(static_cast<std::uint64_t>(own[c]))) {
      const auto wanted = static_cast<std::int64_t>(near);
      auto at = std::lower_bound(all.begin(), all.end(), wanted,
                                 [](const Cell& cell, std::int64_t k) { return cell.key < k; });
      for (; at != all.end() && at->key == wanted; ++at)
        if (at->number >= first_ + c) touching_.push_back({first_ + c, at->number});
    }
}

std::vector<MotionCells::Ball> MotionCells::balls(const Comm& comm,
                                                  std::span<const Vec3> vectors) const {
  std::vector<Vec3> low(count_, Vec3::Constant(infinity)), high(count_, Vec3::Constant(-infinity));
  for (std::size_t b = 0; b < vectors.size(); ++b) {
    const Index c = cell_of_[b];
    low[c] = low[c].cwiseMin(vectors[b]);
    high[c] = high[c].cwiseMax(vectors[b]);
  }
  std::vector<Ball> own(count_);
  for (Index c = 0; c < count_; ++c) own[c].centre = (low[c] + high[c]) / 2;
  for (std::size_t b = 0; b < vectors.size(); ++b) {
    Ball& ball = own[cell_of_[b]];
    ball.radius = std::max(ball.radius, (vectors[b] - ball.centre).squaredNorm());
  }
  std::vector<double> packed;
  for (const Ball& ball : own)
    packed.insert(packed.end(),
                  {ball.centre[0], ball.centre[1], ball.centre[2], std::sqrt(ball.radius)});
  const auto gathered = comm.all_gather(std::span<const double>(packed));
  std::vector<Ball> all(gathered.size() / 4);
  for (std::size_t c = 0; c < all.size(); ++c)
    all[c] = {Vec3(&gathered[4 * c]), gathered[4 * c + 3]};
  return all;
}

double MotionCells::approach(const Comm& comm, double range,
                             std::span<const Vec3> displacement) const {
  const auto all = balls(comm, displacement);
  double touching = 0;
  for (const auto& [a, b] : touching_)
    touching =
        std::max(touching, (all[a].centre - all[b].centre).norm() + all[a].radius + all[b].radius);
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  for (const Ball& ball : all) {
    low = low.cwiseMin(ball.centre - Vec3::Constant(ball.radius));
    high = high.cwiseMax(ball.centre + Vec3::Constant(ball.radius));
  }
  // Bodies of cells that do not touch were an edge apart, at least.
  return std::max(comm.max(touching), (high - low).norm() - (edge_ - range));
}

double MotionCells::closing_speed(const Comm& comm, std::span<const Vec3> places,
                                  std::span<const Vec3> velocity) const {
  const auto at = balls(comm, places), moves = balls(comm, velocity);
  double fastest = 0;
  for (Index a = first_; a < first_ + count_; ++a)
    for (std::size_t b = a; b < at.size(); ++b) {
      const Vec3 x = at[b].centre - at[a].centre, v = moves[b].centre - moves[a].centre;
      const double distance = x.norm(), speed = v.norm();
      const double near = at[a].radius + at[b].radius, spread = moves[a].radius + moves[b].radius;
      const bool part = x.dot(v) >= distance * spread + speed * near + near * spread;
      if (!part) fastest = std::max(fastest, speed + spread);
    }
  return comm.max(fastest);
}

}  // namespace spall
