// Some bodies that are worked on at once: where their numbers are, and their materials.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <vector>

#include "solid/law.hpp"
#include "solid/rows.hpp"

namespace spall {

/// Rows one after another; where there are fewer than lanes, the last one fills them up.
struct LaneRows {
  Index first, count;

  Index operator[](std::size_t l) const {
    return first + std::min(static_cast<Index>(l), count - 1);
  }
  bool fill_lanes() const { return count == static_cast<Index>(pair_lanes); }
  PairLanes load(const std::vector<double>& numbers) const {
    PairLanes v;
    if (fill_lanes())
      std::memcpy(&v, &numbers[first], sizeof v);
    else
      for (std::size_t l = 0; l < pair_lanes; ++l) v[l] = numbers[(*this)[l]];
    return v;
  }
  void store(const PairLanes& v, std::vector<double>& numbers) const {
    if (fill_lanes())
      std::memcpy(&numbers[first], &v, sizeof v);
    else
      for (Index l = 0; l < count; ++l) numbers[first + l] = v[l];
  }
};

/// The law of each lane. Mostly all are of one.
class LaneLaws {
 public:
  LaneLaws(const std::vector<SolidLaw>& laws, const std::vector<std::int32_t>& material,
           const LaneRows& rows) {
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      law_[l] = &laws[material[rows[l]]];
      alike_ &= law_[l] == law_[0];
    }
  }
  const SolidLaw& operator[](std::size_t l) const { return *law_[l]; }
  /// f(law), or a constant, of each lane.
  template <class F>
  PairLanes of(F&& f) const {
    PairLanes v = spread_pairs(std::invoke(f, *law_[0]));
    if (!alike_)
      for (std::size_t l = 1; l < pair_lanes; ++l) v[l] = std::invoke(f, *law_[l]);
    return v;
  }
  /// Calls f(law, its lanes) for each law that some lanes are of.
  template <class F>
  void for_each(F&& f) const {
    const PairLanes one = spread_pairs(1);
    if (alike_) return f(*law_[0], one > 0.0);
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      if (std::find(law_.begin(), law_.begin() + l, law_[l]) != law_.begin() + l) continue;
      PairLanes own;
      for (std::size_t k = 0; k < pair_lanes; ++k) own[k] = law_[k] == law_[l];
      f(*law_[l], own > 0.0);
    }
  }
  template <class F>
  bool any(F&& f) const {
    const auto holds = [&](const SolidLaw* law) { return std::invoke(f, *law); };
    return alike_ ? holds(law_[0]) : std::ranges::any_of(law_, holds);
  }

 private:
  std::array<const SolidLaw*, pair_lanes> law_;
  bool alike_ = true;
};

}  // namespace spall
