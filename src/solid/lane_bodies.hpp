// Some bodies that are worked on at once: where their numbers are, and their materials.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <functional>
#include <span>
#include <vector>

#include "solid/law.hpp"
#include "solid/rows.hpp"

namespace spall {

/// The next rows of a rising list, as many as there are lanes; where there are fewer, the last one
/// fills them up.
class LaneRows {
 public:
  explicit LaneRows(std::span<const Index> list)
      : rows_(list.first(std::min(list.size(), pair_lanes))),
        stretch_(rows_.size() == pair_lanes && rows_.back() - rows_.front() + 1 == count()) {}

  Index count() const { return static_cast<Index>(rows_.size()); }
  Index operator[](std::size_t l) const { return rows_[std::min(l, rows_.size() - 1)]; }
  PairLanes load(const std::vector<double>& numbers) const {
    PairLanes v;
    if (stretch_)
      std::memcpy(&v, &numbers[rows_.front()], sizeof v);
    else
      for (std::size_t l = 0; l < pair_lanes; ++l) v[l] = numbers[(*this)[l]];
    return v;
  }
  void store(const PairLanes& v, std::vector<double>& numbers) const {
    if (stretch_)
      std::memcpy(&numbers[rows_.front()], &v, sizeof v);
    else
      for (std::size_t l = 0; l < rows_.size(); ++l) numbers[rows_[l]] = v[l];
  }

 private:
  std::span<const Index> rows_;
  bool stretch_;  // they follow each other in memory
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
