// Rows come along a space-filling curve, a window of them at a time.
// SPDX-License-Identifier: BSD-3-Clause
#include "pairs/near_pairs.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "spall/error.hpp"
#include "spall/lanes.hpp"

namespace spall {
namespace {

constexpr Index lane_rows = lane_count;
constexpr Index window_rows = 16 * lane_rows;  // their forces stay in the first cache

/// Rows as they are found, until there are enough for a window.
class WindowMaker {
 public:
  WindowMaker(Grouping grouping, std::vector<NearWindow>& windows)
      : grouping_(grouping), windows_(windows) {}

  std::vector<Index>& partners() { return partners_; }
  /// Takes partners since the last row away; tells how many of the `near` first ones are left.
  template <class Test>
  Index drop(Index near, Test&& test) {
    Index to = first_, left = near;
    for (Index at = first_; at < static_cast<Index>(partners_.size()); ++at) {
      if (!test(partners_[at]))
        partners_[to++] = partners_[at];
      else if (at - first_ < near)
        --left;
    }
    partners_.resize(to);
    return left;
  }
  /// All partners since the last call belong to `row`.
  void end_row(Index row, Index near) {
    rows_.push_back({row, first_, static_cast<Index>(partners_.size()) - first_, near});
    first_ = static_cast<Index>(partners_.size());
    if (rows_.size() == window_rows) flush();
  }
  void finish() {
    if (!rows_.empty()) flush();
    windows_.resize(made_);
  }

 private:
  struct Row {
    Index row, first, count, near;
  };

  void flush() {
    if (made_ == windows_.size()) windows_.emplace_back();
    NearWindow& window = windows_[made_++];
    sort(&Row::count);
    if (grouping_ == Grouping::by_near_partners) sort(&Row::near);
    window.count = static_cast<Index>(rows_.size());
    while (rows_.size() % lane_rows != 0) rows_.push_back({rows_.back().row, 0, 0, 0});
    window.rows.clear();
    for (const Row& row : rows_) window.rows.push_back(doubles_a_row * row.row);
    window.slots.clear();
    Index slots = 0;
    for (std::size_t r = 0; r < rows_.size(); r += lane_rows) {
      Index longest = 0;
      for (Index lane = 0; lane < lane_rows; ++lane)
        longest = std::max(longest, rows_[r + lane].count);
      window.slots.push_back(longest);
      slots += longest;
    }
    window.partners.clear();  // or it would grow to twice what it needs
    window.partners.resize(static_cast<std::size_t>(slots) * lane_rows);
    Index* at = window.partners.data();
    for (std::size_t r = 0; r < rows_.size(); r += lane_rows) {
      const Index longest = window.slots[r / lane_rows];
      for (Index lane = 0; lane < lane_rows; ++lane) {
        const Row& row = rows_[r + lane];
        for (Index s = 0; s < longest; ++s)
          at[s * lane_rows + lane] =
              doubles_a_row * (s < row.count ? partners_[row.first + s] : row.row);
      }
      at += longest * lane_rows;
    }
    rows_.clear();
    partners_.clear();
    first_ = 0;
  }

  /// Largest numbers first; stable.
  void sort(Index Row::*number) {
    start_.clear();
    for (const Row& row : rows_) {
      if (row.*number >= static_cast<Index>(start_.size())) start_.resize(row.*number + 1, 0);
      ++start_[row.*number];
    }
    std::exclusive_scan(start_.rbegin(), start_.rend(), start_.rbegin(), 0);
    sorted_.resize(rows_.size());
    for (const Row& row : rows_) sorted_[start_[row.*number]++] = row;
    rows_.swap(sorted_);
  }

  Grouping grouping_;
  std::vector<NearWindow>& windows_;
  std::size_t made_ = 0;
  std::vector<Row> rows_, sorted_;
  std::vector<Index> start_;
  std::vector<Index> partners_;
  Index first_ = 0;
};

}  // namespace

void find_near_pairs(const Bodies& bodies, const Reach& reach, Grouping grouping,
                     std::vector<NearWindow>& windows, BodyId members) {
  constexpr Index most = std::numeric_limits<Index>::max() / doubles_a_row;  // windows name places
  require(bodies.size() <= most,
          "{} bodies and ghosts lie on a rank, and at most {} can: take more", bodies.size(), most);
  WindowMaker maker(grouping, windows);
  find_partners(bodies, reach, ListedWith::first_cell, maker.partners(),
                [&](Index row, Index near) {
                  if (members > 1)
                    near = maker.drop(near, [&](Index partner) {
                      return bodies.id[partner] / members == bodies.id[row] / members;
                    });
                  maker.end_row(row, near);
                });
  maker.finish();
}

namespace {
constexpr double slot_work = 0.1;  // of a pair, beside that of a body
}

std::vector<double> work_of(const Bodies& bodies, const NearPairs& near, double slot) {
  std::vector<double> work(bodies.owned, 1.0);
  if (near.skin == 0) return work;
  for (const NearWindow& window : near.windows)
    for (Index r = 0; r < window.count; ++r)
      work[window.rows[r] / doubles_a_row] += slot * window.slots[r / lane_rows];
  return work;
}

std::vector<double> work_of(const Bodies& bodies, const NearPairs& near) {
  return work_of(bodies, near, slot_work);
}

Links links_of(const std::vector<NearWindow>& windows) {
  Links links;
  for_each_pair(windows, [&](std::size_t, std::size_t, std::size_t, Index i, Index j) {
    links.i.push_back(i);
    links.j.push_back(j);
  });
  return links;
}

void book_search(const Comm& comm, NearPairs& near) {
  near.moved = 0;
  near.steps = 0;
  double pairs = 0;
  for (const NearWindow& window : near.windows)
    pairs += static_cast<double>(window.partners.size());
  near.pairs = comm.sum(pairs);
}

void find_near_pairs(const Comm& comm, Bodies& bodies, const Period& period, const PairReach& reach,
                     double skin, const BondReach& bonded, const std::optional<Bonds>& bonds,
                     NearPairs& near) {
  near.bonds = {};
  near.bonds_break = static_cast<bool>(bonded);
  near.reach = reach.most;
  near.skin = skin = skin_within(period, reach.most, skin);
  const double widest = reach.most + skin;
  {
    std::vector<double> halo(bodies.owned);
    for (Index b = 0; b < bodies.owned; ++b) {
      const double own = reach.radii > 0 ? 2 * reach.radii * bodies.radius[b] + skin : widest;
      halo[b] = own / 2 - bodies.radius[b];
    }
    find_ghosts(comm, bodies, period, halo, near);
  }
  near.cells =
      period.any() ? MotionCells() : MotionCells(comm, near.found_at, motion_cell * widest);
  if (reach.radii > 0) {
    std::vector<double> own(bodies.radius);
    for (double& r : own) r = reach.radii * r + skin / 2;
    find_near_pairs(bodies, {.of_rows = own, .points = true, .skin = skin}, Grouping::by_partners,
                    near.windows);
  } else {
    find_near_pairs(bodies, {.common = widest / 2, .points = true, .skin = skin},
                    Grouping::by_partners, near.windows);
  }
  if (bonded && bonds)
    recall_bonds(bodies, *bonds, near);
  else if (bonded)
    make_bonds(bodies, near, bonded);
  book_search(comm, near);
}

void search_near_pairs(const Comm& comm, Bodies& bodies, const Period& period,
                       const PairReach& reach, double skin, const BondReach& bonded,
                       NearPairs& near) {
  require(!bonded || bodies.has(Field::bonds),
          "bonds that break need fields that the bodies were made without");
  search_anew(
      comm, bodies, near, [&] { return work_of(bodies, near); },
      [&](bool) { return bonded ? bonds_of(bodies, near) : std::nullopt; },
      [&](const std::optional<Bonds>& bonds) {
        find_near_pairs(comm, bodies, period, reach, skin, bonded, bonds, near);
      });
}

}  // namespace spall
