// The tree of gravity: cells along one space-filling curve, the same on any number of ranks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "base/traffic.hpp"
#include "gravity/attract.hpp"
#include "spall/comm.hpp"
#include "spall/types.hpp"

namespace spall {

/// A cell of a binary tree: its children halve it, along one axis after another. So every third
/// generation is one of the octree, and leaves are evenly filled. A half without bodies is no
/// cell.
struct Cell {
  Vec3 center = Vec3::Zero();  ///< of mass
  double radius = 0;           ///< m, all bodies lie within it about the centre
  double extent = 0;           ///< m, the radius that the error of its series goes by
  double mass = 0;             ///< kg
  double pull = 0;             ///< the smallest acceleration of its bodies, roughly and without G
  std::uint64_t key = 0;       ///< of the first body: no other separate cell has it
  std::array<Index, 2> children = {none, none};
  Index first = none;  ///< of a leaf: its place in `Octree::eights`
  Index count = 0;     ///< of a leaf: how many eights
  Index bodies = 0;    ///< of a leaf
  enum class Holder : std::int8_t { here, elsewhere, both } holder = Holder::here;

  static constexpr Index none = -1;
  bool inner() const { return children[0] != none; }
};

/// A box around bodies, not around space.
struct Box {
  Vec3 low = Vec3::Constant(infinity);
  Vec3 high = Vec3::Constant(-infinity);
  double squared_distance(const Vec3& x) const {
    return (low - x).cwiseMax(x - high).cwiseMax(0.0).squaredNorm();
  }
};

/// The bodies of this rank's part of the curve in their leaves, and how they came here. Positions
/// are relative to `origin`.
struct Octree {
  Vec3 origin = Vec3::Zero();
  std::vector<Cell> cells;  ///< own ones: parents before children; later those of several ranks
  Index root = 0;
  std::vector<Eight> eights;  ///< bodies of own leaves

  /// Of the curve, keys [begin, end), and the largest cells that nobody else has bodies in.
  struct Part {
    struct Root {
      Index cell;
      std::uint64_t last_key;  ///< of its bodies
    };
    std::uint64_t begin, end;
    std::vector<Root> roots{};  ///< along the curve
  };
  std::vector<Part> parts;  ///< that are this rank's: one, or all of them on a rank that plans

  /// What bodies feel, back on the ranks they came from: row k, of `felt_width`, is of the body
  /// `went_row[k]`. `eights` are given up. Collective.
  std::vector<double> take_felt(const Comm& comm);

  bool rates = false;               ///< bodies have velocities
  std::vector<Index> place;         ///< of each body that came: 8 * eight + lane
  std::map<int, std::size_t> came;  ///< bodies, by the rank that they came from
  std::vector<Index> went_row;      ///< rows in the order in which they went
  std::map<int, std::size_t> went;  ///< how many of them, by owner
};

/// For one rank that does what so many would do.
struct PlannedRanks {
  std::vector<int> owner;     ///< of each body
  std::vector<Traffic> sent;  ///< by each rank, beside what all do
};

/// Sends bodies to the ranks that hold their part of the curve, about equal numbers to each, and
/// makes their cells. `leaf_size` is the largest number of bodies in a leaf. Some leaves are much
/// thinner than what makes the field about them, as those of ejecta or a halo: they are also
/// smaller than `reach` times the distance over which the field changes. Without bodies there are
/// no cells. Collective.
///
/// One rank alone may have the parts of all ranks that it plans.
Octree grow_octree(const Comm& comm, std::span<const double> mass, std::span<const Vec3> position,
                   std::span<const Vec3> velocity, int leaf_size, double reach,
                   PlannedRanks* planned = nullptr);

}  // namespace spall
