// What gravity is like about a cell, before there is a tree.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "gravity/curve.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// A rough field, without G, which serves to tell which errors are small. It is that of stretches
/// of the curve, taken as points and softened by their radii; where they are far, of the longer
/// ones that they are halves of.
class RoughField {
 public:
  /// `rows` name masses (kg) and positions (m); those of `at` are relative to `origin`. Collective.
  RoughField(const Comm& comm, std::span<const Stretch> stretches, std::span<const KeyedRow> rows,
             std::span<const double> mass, std::span<const Vec3> position, const Vec3& origin);

  struct Sample {
    double pull;      ///< at least a tenth of the sum of all pulls
    double gradient;  ///< of the field: Frobenius norm
  };
  /// Places are from now on within the stretch that has this key; it pulls no longer.
  void look_from(std::uint64_t key);
  Sample at(const Vec3& place) const;
  /// The smallest pull at eight places.
  double least_pull(const LaneVectors& places) const;

 private:
  struct Point {
    Vec3 center = Vec3::Zero();
    double mass = 0;
    double radius = 0;
  };
  void find_groups();
  void collect(Index s);

  std::span<const Stretch> stretches_;
  std::vector<Point> points_;  // of each stretch
  std::vector<Index> group_;   // of each stretch: the longer one whose view it shares, or none
  struct Puller {
    Lanes x{}, y{}, z{}, mass{}, softening{};  // softening: m^2
  };
  std::vector<Puller> pullers_;  // seen from the present group
  std::vector<Index> pulling_;   // their stretches
  Index seen_from_ = Cell::none;
  Index present_ = Cell::none;  // stretch
  std::size_t own_ = 0;         // which of the pullers it is
};

}  // namespace spall
