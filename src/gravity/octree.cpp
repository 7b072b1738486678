// The cells that all ranks know, bodies to the ranks of their part of the curve, cells below.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/octree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "gravity/curve.hpp"
#include "gravity/rough_field.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// The cube that the curve fills; cells know their true sizes.
struct Cube {
  Vec3 center;  // m
  double half;  // m, of an edge
};

Cube bounding_cube(const Comm& comm, std::span<const double> mass, std::span<const Vec3> position) {
  std::array<double, 4> first{};  // sums of m, m x
  for (std::size_t b = 0; b < mass.size(); ++b) {
    first[0] += mass[b];
    for (int k = 0; k < 3; ++k) first[k + 1] += mass[b] * position[b][k];
  }
  comm.sum(first);
  Cube cube{Vec3::Zero(), 0};
  if (first[0] > 0) cube.center = Vec3::Map(&first[1]) / first[0];
  double squares = 0, farthest = 0;
  for (std::size_t b = 0; b < mass.size(); ++b) {
    const Vec3 d = position[b] - cube.center;
    squares += mass[b] * d.squaredNorm();
    farthest = std::max(farthest, d.cwiseAbs().maxCoeff());
  }
  squares = comm.sum(squares);
  cube.half = comm.max(farthest);
  // 2^21 steps across 2000 rms distances still part neighbours in a pile of a million bodies.
  if (squares > 0) cube.half = std::min(cube.half, 1000 * std::sqrt(squares / first[0]));
  return cube;
}

/// Rows of `width` doubles, `counts[r]` of them to rank r; returns those that come.
std::vector<double> exchange_rows(const Comm& comm, std::vector<double> rows,
                                  std::span<const int> counts, std::span<const int> coming,
                                  int width) {
  if (comm.size == 1) return rows;
  const auto scaled = [&](std::span<const int> c) {
    std::vector<int> n(c.begin(), c.end());
    for (int& v : n) v *= width;
    return n;
  };
  const auto starts = [](const std::vector<int>& n) {
    std::vector<int> at(n.size());
    std::exclusive_scan(n.begin(), n.end(), at.begin(), 0);
    return at;
  };
  const std::vector<int> send = scaled(counts), receive = scaled(coming);
  const std::vector<int> send_at = starts(send), receive_at = starts(receive);
  std::vector<double> result(receive_at.back() + receive.back());
  check_mpi(MPI_Alltoallv(rows.data(), send.data(), send_at.data(), MPI_DOUBLE, result.data(),
                          receive.data(), receive_at.data(), MPI_DOUBLE, comm.raw),
            "MPI_Alltoallv");
  return result;
}

/// Cells below one stretch of the curve.
struct Builder {
  Octree& tree;
  std::span<const KeyedRow> rows;
  std::span<const double> bodies;
  std::size_t width;  // of a row of them
  const RoughField& rough;
  std::size_t leaf_size;
  double reach;
  std::size_t stretch = 0;  // the one below which cells grow
  struct Leaf {
    Index cell;
    std::size_t begin, end;  // rows
  };
  std::vector<Leaf> leaves{};
  Index eights = 0;  // of all leaves

  void grow(Index cell, std::size_t begin, std::size_t end) {
    tree.cells[cell].key = rows[begin].key;
    if (is_leaf(tree.cells[cell], begin, end)) {
      tree.cells[cell].first = eights;
      eights += tree.cells[cell].count =
          static_cast<Index>((end - begin + lane_count - 1) / lane_count);
      leaves.push_back({cell, begin, end});
      return;
    }
    // The highest bit in which the first and last key differ is where the cell has two halves.
    const int bit = std::bit_width(rows[begin].key ^ rows[end - 1].key) - 1;
    const std::uint64_t middle = rows[end - 1].key >> bit << bit;
    const std::size_t split = begin + first_at(rows.subspan(begin, end - begin), middle);
    const std::array<std::size_t, 3> edges = {begin, split, end};
    for (int k = 0; k < 2; ++k) {
      const auto child = static_cast<Index>(tree.cells.size());
      tree.cells[cell].children[k] = child;
      tree.cells.emplace_back();
      grow(child, edges[k], edges[k + 1]);
    }
  }

  /// Few bodies, and close together unless they weigh something in the field there.
  bool is_leaf(Cell& cell, std::size_t begin, std::size_t end) {
    const bool divisible = rows[begin].key != rows[end - 1].key;
    if (divisible && end - begin > leaf_size) return false;
    Vec3 low = Vec3::Constant(infinity), high = -low;
    double mass = 0;
    for (std::size_t k = begin; k < end; ++k) {
      const double* body = bodies.data() + width * rows[k].row;
      low = low.cwiseMin(Vec3::Map(body));
      high = high.cwiseMax(Vec3::Map(body));
      mass += body[3];
    }
    const RoughField::Sample field = rough.at((low + high) / 2, stretch);
    cell.pull = field.pull;
    const double radius = (high - low).norm() / 2;
    constexpr double thin = 0.01;  // in a pile of equal bodies it is at least 0.05
    return !divisible || radius * field.gradient <= reach * field.pull ||
           mass >= thin * field.gradient * radius * radius * radius;
  }

  /// When all leaves are known: memory for no more than them.
  void fill_leaves() {
    tree.eights.resize(eights);
    for (const auto& [cell, begin, end] : leaves) fill_leaf(tree.cells[cell], begin, end);
  }

  void fill_leaf(const Cell& cell, std::size_t begin, std::size_t end) {
    for (std::size_t k = 0; k < cell.count * lane_count; ++k) {
      const Index b = rows[std::min(begin + k, end - 1)].row;
      const double* body = bodies.data() + width * b;
      Eight& eight = tree.eights[cell.first + k / lane_count];
      const std::size_t lane = k % lane_count;
      const bool present = begin + k < end;
      put_body(body, tree.rates, present, eight, lane);
      if (present)
        tree.place[b] = static_cast<Index>((cell.first + k / lane_count) * lane_count + lane);
    }
  }
};

}  // namespace

Octree grow_octree(const Comm& comm, std::span<const double> mass, std::span<const Vec3> position,
                   std::span<const Vec3> velocity, int leaf_size, double reach) {
  Octree tree;
  const double bodies = comm.sum(static_cast<double>(mass.size()));
  if (bodies == 0) return tree;
  const Cube cube = bounding_cube(comm, mass, position);
  tree.origin = cube.center;

  // Where the curve is cut, and who gets which part.
  auto rows = sorted_keys(
      mass.size(), [&](std::size_t b) -> Vec3 { return position[b] - cube.center; }, cube.half);
  // Known to all: enough cells for a rough field, and shares that are equal to 1/16.
  const double grain = bodies / std::max(512, 8 * comm.size);
  const std::vector<Stretch> top =
      divide_curve(comm, rows, bodies, std::max<double>(grain, leaf_size));
  tree.owner = deal_out(comm, top);
  tree.top = static_cast<Index>(top.size());
  tree.cells.resize(top.size());
  for (std::size_t s = 0; s < top.size(); ++s) tree.cells[s].children = top[s].children;

  const RoughField rough(comm, top, rows, mass, position, cube.center);

  // Bodies go there.
  tree.went.assign(comm.size, 0);
  tree.came.assign(comm.size, 0);
  for (std::size_t s = 0; s < top.size(); ++s)
    if (tree.owner[s] >= 0)
      tree.went[tree.owner[s]] +=
          static_cast<int>(first_at(rows, top[s].high) - first_at(rows, top[s].low));
  check_mpi(MPI_Alltoall(tree.went.data(), 1, MPI_INT, tree.came.data(), 1, MPI_INT, comm.raw),
            "MPI_Alltoall");
  tree.rates = comm.any(!velocity.empty());
  const std::size_t width = body_width(tree.rates);
  std::vector<double> going(rows.size() * width);
  tree.went_row.resize(rows.size());
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const Index b = tree.went_row[k] = rows[k].row;
    write_body(position[b] - cube.center, mass[b], tree.rates ? &velocity[b] : nullptr,
               going.data() + k * width);
  }
  rows = {};
  const std::vector<double> here =
      exchange_rows(comm, std::move(going), tree.went, tree.came, body_width(tree.rates));

  // Cells below the stretches that are this rank's.
  const std::size_t count = here.size() / width;
  const auto own = sorted_keys(
      count, [&](std::size_t b) -> Vec3 { return Vec3::Map(here.data() + b * width); }, cube.half);
  tree.place.resize(count);
  tree.cells.reserve(top.size() + 4 * count / leaf_size);
  Builder builder{tree, own, here, width, rough, static_cast<std::size_t>(leaf_size), reach};
  for (std::size_t s = 0; s < top.size(); ++s) {
    if (tree.owner[s] == comm.rank)
      builder.grow(static_cast<Index>(s), first_at(own, top[s].low), first_at(own, top[s].high));
    if (tree.owner[s] >= 0) ++builder.stretch;
  }
  builder.fill_leaves();
  return tree;
}

std::vector<double> Octree::take_felt(const Comm& comm) {
  const std::size_t width = felt_width(rates);
  std::vector<double> rows(place.size() * width);
  for (std::size_t b = 0; b < place.size(); ++b)
    get_felt(eights[place[b] / lane_count], place[b] % lane_count, rates, rows.data() + b * width);
  eights = {};
  return exchange_rows(comm, std::move(rows), came, went, felt_width(rates));
}

}  // namespace spall
