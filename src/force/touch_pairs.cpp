// Springs go by the ids of their bodies from one search to the next, whatever the rows are then.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/force/touch_pairs.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <numeric>

#include "spall/base/require.hpp"
#include "spall/contact/rows_of_ids.hpp"
#include "spall/domain/migration.hpp"
#include "spall/domain/partition.hpp"
#include "spall/force/lanes.hpp"

namespace spall {
namespace {

constexpr double slot_work = 0.3;  // of a pair, beside that of a body

Index row_of(Index place) {
  return place / doubles_a_row;
}

/// Calls `f(row, partner, sliding, rolling)` for every touching pair of a window.
template <class F>
void for_each_touching(const NearWindow& window, const WindowSprings& springs, F&& f) {
  std::size_t at = 0;
  for_each_slot(window, [&](std::size_t slot, const Index* own, const Index* partners) {
    const unsigned lanes = springs.touching[slot];
    const int count = std::popcount(lanes);
    for (unsigned left = lanes; left != 0; left &= left - 1, ++at) {
      const int l = std::countr_zero(left);
      const auto spring = [&](const std::vector<double>& of) -> Vec3 {
        if (of.empty()) return Vec3::Zero();
        return {of[at], of[at + count], of[at + 2 * count]};
      };
      f(row_of(own[l]), row_of(partners[l]), spring(springs.sliding), spring(springs.rolling));
    }
    at += 2 * count;
  });
}
template <class F>
void for_each_touching(const TouchPairs& touch, F&& f) {
  for (std::size_t w = 0; w < touch.windows.size(); ++w)
    for_each_touching(touch.windows[w], touch.springs[w], f);
}

/// The springs of each row's contacts by the other body's id, or by -1 - wall.
class Kept {
 public:
  struct Found {
    bool touching = false;
    Vec3 sliding = Vec3::Zero(), rolling = Vec3::Zero();
  };

  /// From the pairs themselves: rows are as they were.
  Kept(const Bodies& bodies, const TouchPairs& touch, bool rolling) : has_rolling_(rolling) {
    start_.assign(bodies.owned + 1, 0);
    for_each_touching(touch, [&](Index i, Index, const Vec3&, const Vec3&) { ++start_[i + 1]; });
    for (const WallTouch& t : touch.walls)
      if (t.touching) ++start_[t.row + 1];
    allocate();
    for_each_touching(touch, [&](Index i, Index j, const Vec3& sliding, const Vec3& roll) {
      add(i, bodies.id[j], sliding, roll);
    });
    for (const WallTouch& t : touch.walls)
      if (t.touching) add(t.row, -1 - t.wall, t.sliding, t.rolling);
  }

  /// From memory: every entry has a body here.
  Kept(const Bodies& bodies, const ContactMemory& memory, bool rolling) : has_rolling_(rolling) {
    const RowsOfIds rows(bodies);
    std::vector<Index> row(memory.i.size());
    start_.assign(bodies.owned + 1, 0);
    for (std::size_t m = 0; m < row.size(); ++m) {
      row[m] = rows.find(memory.i[m]);
      ++start_[(row[m] >= 0 ? row[m] : rows.find(memory.j[m])) + 1];
    }
    allocate();
    for (std::size_t m = 0; m < row.size(); ++m) {
      if (row[m] >= 0)
        add(row[m], memory.j[m], memory.impulse[m], memory.rolling_of(m));
      else
        add(rows.find(memory.j[m]), memory.i[m], -memory.impulse[m], memory.rolling_of(m));
    }
  }

  Found find(Index row, BodyId other) const {
    for (Index k = row > 0 ? start_[row - 1] : 0; k < start_[row]; ++k)
      if (other_[k] == other) return {true, sliding_[k], has_rolling_ ? rolling_[k] : Vec3::Zero()};
    return {};
  }
  /// A pair may have been kept with either body, from which its sliding has the other sign.
  Found find(const Bodies& bodies, Index i, Index j) const {
    Found found = find(i, bodies.id[j]);
    if (found.touching || j >= bodies.owned) return found;
    found = find(j, bodies.id[i]);
    found.sliding = -found.sliding;
    return found;
  }

 private:
  // While entries are added start_[row] is where the next one goes, afterwards the row's end.
  void allocate() {
    std::partial_sum(start_.begin(), start_.end(), start_.begin());
    other_.resize(start_.back());
    sliding_.resize(start_.back());
    if (has_rolling_) rolling_.resize(start_.back());
  }
  void add(Index row, BodyId other, const Vec3& sliding, const Vec3& rolling) {
    const Index at = start_[row]++;
    other_[at] = other;
    sliding_[at] = sliding;
    if (has_rolling_) rolling_[at] = rolling;
  }

  bool has_rolling_;
  std::vector<Index> start_;
  std::vector<BodyId> other_;
  std::vector<Vec3> sliding_, rolling_;
};

void recall_springs(const Bodies& bodies, const Kept& kept, bool rolling, TouchPairs& touch) {
  touch.springs.resize(touch.windows.size());
  std::vector<double> slides, rolls;
  for (std::size_t w = 0; w < touch.windows.size(); ++w) {
    WindowSprings& springs = touch.springs[w];
    springs.touching.reserve(touch.windows[w].partners.size() / lane_count);
    slides.clear();
    rolls.clear();
    for_each_slot(touch.windows[w], [&](std::size_t, const Index* own, const Index* partners) {
      std::array<Kept::Found, lane_count> found;
      unsigned lanes = 0;
      for (std::size_t l = 0; l < lane_count; ++l) {
        if (partners[l] == own[l]) continue;
        found[l] = kept.find(bodies, row_of(own[l]), row_of(partners[l]));
        if (found[l].touching) lanes |= 1u << l;
      }
      springs.touching.push_back(static_cast<std::uint8_t>(lanes));
      for (int k = 0; k < 3; ++k)
        for (const Kept::Found& one : found) {
          if (!one.touching) continue;
          slides.push_back(one.sliding[k]);
          if (rolling) rolls.push_back(one.rolling[k]);
        }
    });
    springs.sliding = slides;
    springs.rolling = rolls;
  }
}

void find_walls(const Bodies& bodies, const Walls& walls, double reach, const Kept& kept,
                std::vector<WallTouch>& touches) {
  touches.clear();
  for (Index b = 0; b < bodies.owned; ++b)
    for (std::size_t w = 0; w < walls.size(); ++w) {
      if (face_of(walls, w, bodies.position[b]).height > bodies.radius[b] + reach) continue;
      WallTouch& t = touches.emplace_back(WallTouch{b, static_cast<std::int32_t>(w)});
      const Kept::Found found = kept.find(b, -1 - t.wall);
      t.touching = found.touching;
      t.sliding = found.sliding;
      t.rolling = found.rolling;
    }
}

}  // namespace

void set_touching(WindowSprings& springs, std::size_t slot, std::size_t at, unsigned touching,
                  bool rolling) {
  const int before = 3 * std::popcount(unsigned{springs.touching[slot]});
  const int now = 3 * std::popcount(touching);
  const auto make_room = [&](std::vector<double>& of) {
    const auto place = of.begin() + static_cast<std::ptrdiff_t>(at);
    if (now <= before) {
      of.erase(place, place + (before - now));
      return;
    }
    const std::size_t size = of.size() + (now - before);
    // A vector's own growth would take twice the memory.
    if (size > of.capacity()) of.reserve(size + size / 16);
    of.insert(of.begin() + static_cast<std::ptrdiff_t>(at), now - before, 0.0);
  };
  make_room(springs.sliding);
  if (rolling) make_room(springs.rolling);
  springs.touching[slot] = static_cast<std::uint8_t>(touching);
}

ContactMemory remember(const Bodies& bodies, const TouchPairs& touch) {
  ContactMemory memory;
  for_each_touching(touch, [&](Index a, Index b, const Vec3& sliding, const Vec3& rolling) {
    const BodyId i = bodies.id[a], j = bodies.id[b];
    if (i < j)
      memory.add(i, j, sliding, rolling);
    else if (b < bodies.owned)
      memory.add(j, i, -sliding, rolling);
  });
  for (const WallTouch& t : touch.walls)
    if (t.touching) memory.add(bodies.id[t.row], -1 - t.wall, t.sliding, t.rolling);
  const ContactMemory& carried = touch.carried;
  for (std::size_t m = 0; m < carried.i.size(); ++m)
    memory.add(carried.i[m], carried.j[m], carried.impulse[m], carried.rolling_of(m));
  return memory;
}

std::int64_t count_touching(const Bodies& bodies, const TouchPairs& touch) {
  std::int64_t count = 0;
  for_each_touching(touch, [&](Index i, Index j, const Vec3&, const Vec3&) {
    count += j < bodies.owned || bodies.id[i] < bodies.id[j];
  });
  return count + std::count_if(touch.walls.begin(), touch.walls.end(),
                               [](const WallTouch& t) { return t.touching; });
}

void search_touch_pairs(const Comm& comm, Bodies& bodies, const Walls& walls, const Period& period,
                        const TouchRange& range, TouchPairs& touch) {
  auto work = work_of(bodies, touch, slot_work);
  const bool cut = needs_cut(comm, work, touch.ghosts, touch.last_cut);
  // What comes needs the memory.
  touch.found_at = std::vector<Vec3>();
  const auto forget = [&] {
    touch.springs.clear();
    touch.windows.clear();
    work = std::vector<double>();
  };
  const Kept kept = [&] {
    if (!cut) return Kept(bodies, touch, range.rolling);
    ContactMemory memory = remember(bodies, touch);
    touch.carried = {};
    const std::vector<int> owner = partition(comm, bodies, work);
    forget();
    migrate(comm, bodies, memory, owner);
    return Kept(bodies, memory, range.rolling);
  }();
  forget();

  const double slack = range.gap + range.skin;
  double largest = 0;
  for (Index b = 0; b < bodies.owned; ++b) largest = std::max(largest, bodies.radius[b]);
  const double reach = 2 * comm.max(largest) + slack;
  for (int k = 0; k < 3; ++k)
    require(
        period.size[k] == 0 || period.size[k] >= 2 * reach,
        "periodic.size: {:g} m in direction {} is less than twice {:.4g} m, the reach of a body: "
        "it would meet two images of another",
        period.size[k], "xyz"[k], reach);
  if (period.any())
    for (Index b = 0; b < bodies.owned; ++b)
      bodies.position[b] = period.wrapped(bodies.position[b]);
  {
    std::vector<double> reaches(bodies.owned, slack / 2);
    touch.ghosts = make_halo(comm, bodies, reaches, period, touch.shifts);
  }
  touch.found_at.assign(bodies.position.begin(), bodies.position.begin() + bodies.owned);
  find_near_pairs(bodies, 2 * range.ordinary, 2 * range.ordinary + slack,
                  {.above = range.ordinary, .slack = slack}, touch.windows);
  recall_springs(bodies, kept, range.rolling, touch);
  find_walls(bodies, walls, slack, kept, touch.walls);
  const auto all_equal = [](const std::vector<double>& values) {
    return std::adjacent_find(values.begin(), values.end(), std::not_equal_to<>()) == values.end();
  };
  touch.equal = all_equal(bodies.radius) && all_equal(bodies.mass);
  touch.gap = range.gap;
  touch.reach = 2 * range.ordinary + range.gap;
  touch.skin = range.skin;
  book_search(comm, bodies, cut, slot_work, touch);
}

}  // namespace spall
