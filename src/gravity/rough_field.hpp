// What gravity is like about a cell, before there is a tree.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "gravity/curve.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// A rough field, without G, which serves to tell which errors are small. It is that of stretches
/// of the curve, taken as points and softened by their radii.
class RoughField {
 public:
  /// `rows` name masses (kg) and positions (m); those of `at` are relative to `origin`. Collective.
  RoughField(const Comm& comm, std::span<const Stretch> stretches, std::span<const KeyedRow> rows,
             std::span<const double> mass, std::span<const Vec3> position, const Vec3& origin);

  struct Sample {
    double pull;      ///< at least a tenth of the sum of all pulls: where they cancel, a smaller
                      ///< one would have all cells opened
    double gradient;  ///< sum of mass / distance^3
  };
  /// Without stretch `own`, counted among those that are not divided: it would pull itself.
  Sample at(const Vec3& place, std::size_t own) const;

 private:
  struct Puller {
    Lanes x{}, y{}, z{}, mass{}, softening{};  // softening: m^2
  };
  std::vector<Puller> pullers_;
};

}  // namespace spall
