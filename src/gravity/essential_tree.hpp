// The locally essential tree: own cells with their moments, and other ranks' that they need.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "base/traffic.hpp"
#include "gravity/multipole.hpp"
#include "gravity/octree.hpp"
#include "gravity/tree.hpp"

namespace spall {

/// What of two cells decides whether they may attract each other by multipoles.
struct PairMeasure {
  double radii, extents;    ///< sums
  double squared_distance;  ///< of the centres
  double weight;            ///< mass of one / acceleration of the other, summed over both ways
};

inline PairMeasure measure_pair(const Cell& a, const Cell& b) {
  return {a.radius + b.radius, a.extent + b.extent, (b.center - a.center).squaredNorm(),
          a.mass / b.pull + b.mass / a.pull};
}

/// Of two near cells the larger is opened; keys decide between equals.
inline bool is_larger(const Cell& a, const Cell& b) {
  return a.radius != b.radius ? a.radius > b.radius : a.key > b.key;
}

template <int P>
struct EssentialTree {
  Octree octree;
  double squared_opening, squared_accuracy;
  std::vector<Moments<P>> moments;  ///< of every cell
  std::vector<Eight> others{};      ///< bodies of leaves that are elsewhere

  /// Moments up the tree, and other ranks' cells that this one's may have to open. Collective.
  EssentialTree(const Comm& comm, Octree grown, const TreeSettings& settings);
  /// No moments yet.
  EssentialTree(Octree grown, const TreeSettings& settings);

  std::span<Eight> eights(const Cell& leaf) {
    std::vector<Eight>& held = leaf.holder == Cell::Holder::elsewhere ? others : octree.eights;
    return {held.data() + leaf.first, static_cast<std::size_t>(leaf.count)};
  }

  /// Whether two cells attract each other by their multipoles. The decision is symmetric and the
  /// same wherever it is made, or momentum would be lost. The terms left out are about
  /// (mass / distance^2) (extents / distance)^P (Dehnen 2014, eq. 13). They have to be small
  /// against the acceleration of either cell.
  bool are_far(const PairMeasure& pair) const {
    const double q = pair.extents * pair.extents / pair.squared_distance;
    double power = 1;  // q^P
    for (int k = 0; k < P; ++k) power *= q;
    return pair.radii * pair.radii < squared_opening * pair.squared_distance &&
           pair.weight * pair.weight * power <
               squared_accuracy * pair.squared_distance * pair.squared_distance;
  }
};

/// What each of the ranks `sample` would tell the others of its cells. All of them are here: it has
/// the parts of all ranks.
template <int P>
std::vector<Traffic> foretell_messages(const Comm& alone, Octree grown,
                                       const TreeSettings& settings, std::span<const int> sample);

}  // namespace spall
