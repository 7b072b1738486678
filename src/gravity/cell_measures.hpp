// Centres, sizes and moments of cells, from bodies up.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "gravity/essential_tree.hpp"
#include "gravity/expansion.hpp"

namespace spall {

/// What is known of a cell beside what acts.
struct Outline {
  Box box;
  double largest_leaf = 0;  ///< radius
  double bodies = 0;
  /// |distance from the centre|^P over radius^P: means over the bodies, by mass and by number.
  std::array<double, 2> spread = {0, 0};
};

template <int P>
class CellMeasures {
  using Row = Moments<P>;

 public:
  explicit CellMeasures(EssentialTree<P>& tree) : outlines(tree.octree.cells.size()), tree_(tree) {}

  std::vector<Outline> outlines;  ///< of own cells and those above

  void measure_own_cells() {
    for (auto c = static_cast<Index>(tree_.octree.cells.size()); c-- > 0;)
      if (tree_.octree.cells[c].inner())
        measure_inner(c);
      else
        measure_leaf(c);
  }

  /// From the two halves.
  void measure_inner(Index c) {
    Cell& cell = tree_.octree.cells[c];
    Row& row = tree_.moments[c];
    Outline& outline = outlines[c];
    Vec3 place = Vec3::Zero(), momentum = Vec3::Zero();
    double mass = 0;
    for (Index half : cell.children) {
      const double m = tree_.moments[half].row[0];
      mass += m;
      place += m * tree_.octree.cells[half].center;
      momentum += m * tree_.moments[half].mean_velocity();
      const Outline& part = outlines[half];
      outline.box.low = outline.box.low.cwiseMin(part.box.low);
      outline.box.high = outline.box.high.cwiseMax(part.box.high);
      outline.largest_leaf = std::max(outline.largest_leaf, part.largest_leaf);
    }
    start(c, mass, place, momentum);
    // Two bounds of the distance of the farthest body: by the halves' spheres and by the box.
    const Vec3 corner = (cell.center - outline.box.low).cwiseMax(outline.box.high - cell.center);
    double reach = 0;
    for (Index half : cell.children) {
      const Cell& part = tree_.octree.cells[half];
      reach = std::max(reach, (part.center - cell.center).norm() + part.radius);
      add_moments(row, tree_.moments[half]);
    }
    cell.radius = std::min(reach, corner.norm());
    for (Index half : cell.children) outline.bodies += outlines[half].bodies;
    for (Index half : cell.children) {
      const Cell& part = tree_.octree.cells[half];
      // Of the norms of distances, by the triangle inequality.
      const auto [by_mass, by_number] = outlines[half].spread;
      const double shift = (part.center - cell.center).norm();
      add_spread(c, shift + part.radius * std::pow(by_mass, 1.0 / P), part.mass, 0);
      add_spread(c, shift + part.radius * std::pow(by_number, 1.0 / P), 0, outlines[half].bodies);
    }
    set_extent(c);
    cell.pull = std::min(tree_.octree.cells[cell.children[0]].pull,
                         tree_.octree.cells[cell.children[1]].pull);
    cell.key = tree_.octree.cells[cell.children[0]].key;
    const auto holder = tree_.octree.cells[cell.children[0]].holder;
    cell.holder =
        holder == tree_.octree.cells[cell.children[1]].holder ? holder : Cell::Holder::both;
  }

 private:
  void measure_leaf(Index c) {
    Cell& cell = tree_.octree.cells[c];
    Row& row = tree_.moments[c];
    Outline& outline = outlines[c];
    Vec3 place = Vec3::Zero(), momentum = Vec3::Zero();
    double mass = 0;
    for (const Eight& e : tree_.eights(cell)) {
      mass += sum_of_lanes(e.mass);
      place +=
          Vec3(sum_of_lanes(e.mass * e.x), sum_of_lanes(e.mass * e.y), sum_of_lanes(e.mass * e.z));
      momentum += Vec3(sum_of_lanes(e.mass * e.vx), sum_of_lanes(e.mass * e.vy),
                       sum_of_lanes(e.mass * e.vz));
      for (std::size_t k = 0; k < lane_count; ++k) {
        const Vec3 x(e.x[k], e.y[k], e.z[k]);
        outline.box.low = outline.box.low.cwiseMin(x);
        outline.box.high = outline.box.high.cwiseMax(x);
      }
    }
    start(c, mass, place, momentum);
    double squared_radius = 0;
    for (const Eight& e : tree_.eights(cell)) {
      const Lanes x = e.x - cell.center.x(), y = e.y - cell.center.y(), z = e.z - cell.center.z();
      const Lanes r2 = x * x + (y * y + z * z);
      for (std::size_t k = 0; k < lane_count; ++k) squared_radius = std::max(squared_radius, r2[k]);
    }
    measure_bodies(tree_.eights(cell), tree_.octree.rates, row);
    cell.radius = std::sqrt(squared_radius);
    outline.largest_leaf = cell.radius;
    outline.bodies = cell.bodies;
    for (Index b = 0; b < cell.bodies; ++b) {
      const Eight& e = tree_.eights(cell)[b / lane_count];
      const std::size_t k = b % lane_count;
      const double r = (Vec3(e.x[k], e.y[k], e.z[k]) - cell.center).norm();
      add_spread(c, r, e.mass[k], 1);
    }
    set_extent(c);
  }

  void add_spread(Index c, double distance, double mass, double bodies) {
    const Cell& cell = tree_.octree.cells[c];
    if (distance == 0) return;
    const double part = std::min(1.0, distance / cell.radius);  // above by round-off
    double power = 1;
    for (int k = 0; k < P; ++k) power *= part;
    Outline& outline = outlines[c];
    if (cell.mass > 0) outline.spread[0] += mass / cell.mass * power;
    outline.spread[1] += bodies / outline.bodies * power;
  }
  /// Bodies pull by their masses and feel one by one: the extent goes by both.
  void set_extent(Index c) {
    const auto [by_mass, by_number] = outlines[c].spread;
    Cell& cell = tree_.octree.cells[c];
    cell.extent = cell.radius * std::pow((by_mass + by_number) / 2, 1.0 / P);
  }

  /// Mass, centre and mean velocity by sums over mass; of nothing, the centre of its box.
  void start(Index c, double mass, const Vec3& place, const Vec3& momentum) {
    Cell& cell = tree_.octree.cells[c];
    Row& row = tree_.moments[c];
    const Box& box = outlines[c].box;
    cell.center = mass > 0 ? Vec3(place / mass) : Vec3((box.low + box.high) / 2);
    cell.mass = mass;
    row.row[0] = mass;
    Vec3::Map(&row.row[1]) = cell.center;
    Vec3::Map(&row.row[Row::velocity]) = mass > 0 ? Vec3(momentum / mass) : Vec3(Vec3::Zero());
  }

  EssentialTree<P>& tree_;
};

}  // namespace spall
