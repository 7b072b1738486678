// Where the curve is cut, bodies to the ranks of their part of it, cells there.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/octree.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "base/let_go.hpp"
#include "gravity/curve_parts.hpp"
#include "gravity/rough_field.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// The cube that the curve fills; cells know their true sizes.
struct Cube {
  Vec3 center;  // m
  double half;  // m, of an edge
};

/// Sums over the bodies of all ranks.
struct Sums {
  double bodies = 0, with_velocity = 0, mass = 0;
  Vec3 moment = Vec3::Zero();  // kg m
};

Sums sums_of(const Comm& comm, std::span<const double> mass, std::span<const Vec3> position,
             std::span<const Vec3> velocity) {
  std::array<double, 6> sums{static_cast<double>(mass.size()),
                             static_cast<double>(velocity.size())};
  for (std::size_t b = 0; b < mass.size(); ++b) {
    sums[2] += mass[b];
    for (int k = 0; k < 3; ++k) sums[k + 3] += mass[b] * position[b][k];
  }
  comm.sum(sums);
  return {sums[0], sums[1], sums[2], Vec3::Map(&sums[3])};
}

Cube bounding_cube(const Comm& comm, const Sums& sums, std::span<const double> mass,
                   std::span<const Vec3> position) {
  Cube cube{Vec3::Zero(), 0};
  if (sums.mass > 0) cube.center = sums.moment / sums.mass;
  double squares = 0, farthest = 0;
  for (std::size_t b = 0; b < mass.size(); ++b) {
    const Vec3 d = position[b] - cube.center;
    squares += mass[b] * d.squaredNorm();
    farthest = std::max(farthest, d.cwiseAbs().maxCoeff());
  }
  squares = comm.sum(squares);
  cube.half = comm.max(farthest);
  // 2^21 steps across 2000 rms distances still part neighbours in a pile of a million bodies.
  if (squares > 0) cube.half = std::min(cube.half, 1000 * std::sqrt(squares / sums.mass));
  return cube;
}

/// One rank's rows after another's.
std::vector<double> joined(ByRank<double> rows) {
  if (rows.size() == 1) return std::move(rows.begin()->second);
  std::vector<double> all;
  std::size_t size = 0;
  for (const auto& [rank, row] : rows) size += row.size();
  all.reserve(size);
  for (const auto& [rank, row] : rows) all.insert(all.end(), row.begin(), row.end());
  return all;
}

/// Cells of one part of the curve after another.
struct Builder {
  Octree& tree;
  std::span<const KeyedRow> rows;
  std::span<const double> bodies;
  std::size_t width;  // of a row of them
  RoughField& rough;
  std::size_t leaf_size;
  double reach;
  struct Leaf {
    Index cell;
    std::size_t begin, end;  // rows
  };
  std::vector<Leaf> leaves{};
  Index eights = 0;  // of all leaves

  /// The largest cells whose stretch of the curve is all in `part`: others may have bodies beyond.
  void plant(Octree::Part& part, std::size_t begin, std::size_t end) {
    if (begin == end) return;
    const Stretch stretch = stretch_of(rows[begin].key, rows[end - 1].key);
    if (stretch.low < part.begin || stretch.high > part.end) {
      const std::size_t split = split_at(stretch, begin, end);
      plant(part, begin, split);
      plant(part, split, end);
      return;
    }
    const auto cell = static_cast<Index>(tree.cells.size());
    part.roots.push_back({cell, rows[end - 1].key});
    tree.cells.emplace_back();
    grow(cell, begin, end);
  }

  std::size_t split_at(const Stretch& stretch, std::size_t begin, std::size_t end) const {
    return begin + first_at(rows.subspan(begin, end - begin), stretch.middle());
  }

  void grow(Index cell, std::size_t begin, std::size_t end) {
    tree.cells[cell].key = rows[begin].key;
    if (is_leaf(tree.cells[cell], begin, end)) {
      tree.cells[cell].first = eights;
      eights += tree.cells[cell].count =
          static_cast<Index>((end - begin + lane_count - 1) / lane_count);
      tree.cells[cell].bodies = static_cast<Index>(end - begin);
      leaves.push_back({cell, begin, end});
      return;
    }
    const std::size_t split = split_at(stretch_of(rows[begin].key, rows[end - 1].key), begin, end);
    const std::array<std::size_t, 3> edges = {begin, split, end};
    for (int k = 0; k < 2; ++k) {
      const auto child = static_cast<Index>(tree.cells.size());
      tree.cells[cell].children[k] = child;
      tree.cells.emplace_back();
      grow(child, edges[k], edges[k + 1]);
    }
  }

  /// Few bodies, and close together unless they are as dense as what makes the field there.
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
    rough.look_from(rows[begin].key);
    const RoughField::Sample field = rough.at((low + high) / 2);
    const double radius = (high - low).norm() / 2;
    // A leaf that is thinner than what pulls it would feel that in many small parts, whose errors
    // are alike and add up. A homogeneous ball has 0.2.
    constexpr double thin = 0.1;
    if (divisible && radius * field.gradient > reach * field.pull &&
        mass < thin * field.gradient * radius * radius * radius)
      return false;
    cell.pull = field.pull;
    // Where the field may change by half, its smallest value counts.
    if (radius * field.gradient > field.pull / 2)
      for (std::size_t k = begin; k < end; k += lane_count) {
        LaneVectors places;  // lanes that are left hold the last body again
        for (std::size_t lane = 0; lane < lane_count; ++lane) {
          const double* body = bodies.data() + width * rows[std::min(k + lane, end - 1)].row;
          places.x[lane] = body[0];
          places.y[lane] = body[1];
          places.z[lane] = body[2];
        }
        cell.pull = std::min(cell.pull, rough.least_pull(places));
      }
    return true;
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
                   std::span<const Vec3> velocity, int leaf_size, double reach,
                   PlannedRanks* planned) {
  Octree tree;
  const Sums sums = sums_of(comm, mass, position, velocity);
  if (sums.bodies == 0) return tree;
  const Cube cube = bounding_cube(comm, sums, mass, position);
  tree.origin = cube.center;

  // Where the curve is cut, and who gets which part.
  auto rows = sorted_keys(
      mass.size(), [&](std::size_t b) -> Vec3 { return position[b] - cube.center; }, cube.half);
  const std::vector<Stretch> stretches = divide_curve(comm, rows, sums.bodies, leaf_size);
  const std::vector<CurvePart> parts =
      planned ? foretell_parts(comm, rows, stretches, leaf_size, *planned)
              : find_parts(comm, rows, stretches, leaf_size);
  for (const CurvePart& part : parts)
    if (planned || part.rank == comm.rank) tree.parts.push_back({part.begin, part.end});

  RoughField rough(comm, stretches, rows, mass, position, cube.center);

  // Bodies go there, to one rank after another.
  tree.rates = sums.with_velocity > 0;
  const std::size_t width = body_width(tree.rates);
  ByRank<double> going;
  for (const CurvePart& part : parts) {
    const std::size_t begin = first_at(rows, part.begin), end = first_at(rows, part.end);
    if (begin == end) continue;
    tree.went[part.rank] = end - begin;
    std::vector<double>& row = going[planned ? comm.rank : part.rank];
    const std::size_t before = row.size();
    row.resize(before + width * (end - begin));
    for (std::size_t k = begin; k < end; ++k) {
      const Index b = rows[k].row;
      tree.went_row.push_back(b);
      write_body(position[b] - cube.center, mass[b], tree.rates ? &velocity[b] : nullptr,
                 row.data() + before + (k - begin) * width);
    }
  }
  let_go(rows);
  ByRank<double> coming = comm.exchange(std::move(going));
  for (const auto& [rank, row] : coming) tree.came[rank] = row.size() / width;
  const std::vector<double> here = joined(std::move(coming));

  const std::size_t count = here.size() / width;
  const auto own = sorted_keys(
      count, [&](std::size_t b) -> Vec3 { return Vec3::Map(here.data() + b * width); }, cube.half);
  tree.place.resize(count);
  tree.cells.reserve(4 * count / leaf_size);
  Builder builder{tree, own, here, width, rough, static_cast<std::size_t>(leaf_size), reach};
  for (Octree::Part& part : tree.parts)
    builder.plant(part, first_at(own, part.begin), first_at(own, part.end));
  builder.fill_leaves();
  return tree;
}

std::vector<double> Octree::take_felt(const Comm& comm) {
  const std::size_t width = felt_width(rates);
  ByRank<double> felt;
  for (std::size_t b = 0; const auto& [rank, bodies] : came) {
    std::vector<double>& row = felt[rank];
    row.resize(width * bodies);
    for (std::size_t n = 0; n < bodies; ++n, ++b)
      get_felt(eights[place[b] / lane_count], place[b] % lane_count, rates, row.data() + n * width);
  }
  let_go(eights);
  return joined(comm.exchange(std::move(felt)));
}

}  // namespace spall
