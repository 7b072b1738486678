// Springs go by the ids of their bodies from one search to the next, whatever the rows are then.
// SPDX-License-Identifier: BSD-3-Clause
#include "penalty/touch_pairs.hpp"

#include <algorithm>
#include <array>
#include <bit>

#include "pairs/recall.hpp"
#include "spall/error.hpp"
#include "spall/lanes.hpp"

namespace spall {
namespace {

constexpr Index lane_rows = lane_count;
constexpr double slot_work = 0.3;  // of a pair, beside that of a body

Index row_of(Index place) {
  return place / doubles_a_row;
}

/// Calls `f(row, partner, sliding, rolling)` for every touching pair of a window.
template <class F>
void for_each_touching(const NearWindow& window, const WindowSprings& springs, F&& f) {
  std::size_t at = 0;
  for_each_slot(window, [&](std::size_t slot, const Index* own, const Index* partners) {
    for (unsigned left = springs.touching[slot]; left != 0; left &= left - 1, ++at) {
      const int l = std::countr_zero(left);
      f(row_of(own[l]), row_of(partners[l]), springs.sliding[at], springs.rolling[at]);
    }
  });
}
template <class F>
void for_each_touching(const TouchPairs& touch, F&& f) {
  for (std::size_t w = 0; w < touch.windows.size(); ++w)
    for_each_touching(touch.windows[w], touch.springs[w], f);
}

/// What a contact remembered, seen from one of its bodies.
struct Found {
  bool touching = false;
  Vec3 sliding = Vec3::Zero(), rolling = Vec3::Zero();
};

/// The springs that were kept.
class Kept {
 public:
  Kept(const Bodies& bodies, const ContactMemory& memory)
      : bodies_(bodies), memory_(memory), recall_(bodies, memory) {}

  Found of_pair(Index i, Index j) const {
    return found(recall_.of_pair(i, j), bodies_.id[i] < bodies_.id[j] ? 1 : -1);
  }
  Found of_wall(Index row, std::int32_t wall) const { return found(recall_.of_wall(row, wall), 1); }

 private:
  /// Sliding has the other sign from the other body.
  Found found(Index m, double sign) const {
    if (m < 0) return {};
    return {true, sign * memory_.impulse[m], memory_.rolling_of(m)};
  }

  const Bodies& bodies_;
  const ContactMemory& memory_;
  Recall recall_;
};

void recall_springs(const Kept& kept, bool rolling, TouchPairs& touch) {
  touch.springs.resize(touch.windows.size());
  std::vector<Found> found;
  for (std::size_t w = 0; w < touch.windows.size(); ++w) {
    WindowSprings& springs = touch.springs[w];
    springs.touching.reserve(touch.windows[w].partners.size() / lane_count);
    found.clear();
    for_each_slot(touch.windows[w], [&](std::size_t, const Index* own, const Index* partners) {
      unsigned lanes = 0;
      for (std::size_t l = 0; l < lane_count; ++l) {
        if (partners[l] == own[l]) continue;
        const Found one = kept.of_pair(row_of(own[l]), row_of(partners[l]));
        if (!one.touching) continue;
        lanes |= 1u << l;
        found.push_back(one);
      }
      springs.touching.push_back(static_cast<std::uint8_t>(lanes));
    });
    springs.sliding.fill(found.size(), [&](std::size_t k) { return found[k].sliding; });
    if (rolling)
      springs.rolling.fill(found.size(), [&](std::size_t k) { return found[k].rolling; });
  }
}

/// Of each window, whether all its bodies and partners are of one size, mass and material: a few
/// that never move, are larger or of another law cost no more than their own windows.
std::vector<std::uint8_t> equal_windows(const Bodies& bodies,
                                        const std::vector<NearWindow>& windows) {
  std::vector<std::uint8_t> equal;
  equal.reserve(windows.size());
  for (const NearWindow& window : windows) {
    const Index first = row_of(window.rows[0]);
    const auto alike = [&](Index place) {
      const Index b = row_of(place);
      return bodies.radius[b] == bodies.radius[first] && bodies.mass[b] == bodies.mass[first] &&
             bodies.material[b] == bodies.material[first];
    };
    equal.push_back(std::ranges::all_of(window.rows, alike) &&
                    std::ranges::all_of(window.partners, alike));
  }
  return equal;
}

void find_walls(const Bodies& bodies, const Walls& walls, double reach, const Kept& kept,
                std::vector<WallTouch>& touches) {
  touches.clear();
  for (Index b = 0; b < bodies.owned; ++b)
    for (std::size_t w = 0; w < walls.size(); ++w) {
      if (face_of(walls, w, bodies.position[b]).height > bodies.radius[b] + reach) continue;
      const auto wall = static_cast<std::int32_t>(w);
      const Found found = kept.of_wall(b, wall);
      touches.push_back({b, wall, found.touching, found.sliding, found.rolling});
    }
}

}  // namespace

void SpringList::make_room(std::size_t count) {
  if (count <= room_ && 3 * room_ == all_.size()) return;
  room_ = count;
  // A vector's own growth would take twice the memory.
  if (3 * count > all_.capacity()) all_.reserve(3 * count + count / 5);
  all_.resize(3 * count);
}

void SpringList::take(const SpringList& from, std::size_t count) {
  room_ = 0;
  make_room(count);
  std::copy_n(from.x(), count, x());
  std::copy_n(from.y(), count, y());
  std::copy_n(from.z(), count, z());
}

unsigned touched(const WindowSprings& springs, const Index* places, std::size_t left) {
  unsigned pairs = 0;
  for (std::size_t l = 0; l < std::min(left, lane_count); ++l)
    pairs |= (springs.touching[places[l] / lane_rows] >> places[l] % lane_rows & 1u) << l;
  return pairs;
}

void toggle_touched(unsigned pairs, const Index* places, WindowSprings& springs) {
  for (; pairs != 0; pairs &= pairs - 1) {
    const Index place = places[std::countr_zero(pairs)];
    springs.touching[place / lane_rows] ^= static_cast<std::uint8_t>(1u << place % lane_rows);
  }
}

ContactMemory remember(const Bodies& bodies, const TouchPairs& touch, bool once) {
  ContactMemory memory;
  std::size_t most = touch.walls.size();
  for (const WindowSprings& springs : touch.springs)
    for (std::uint8_t lanes : springs.touching) most += std::popcount(lanes);
  memory.reserve(most);  // many: it does not grow by halves
  for_each_touching(touch, [&](Index a, Index b, const Vec3& sliding, const Vec3& rolling) {
    const BodyId i = bodies.id[a], j = bodies.id[b];
    if (i < j)
      memory.add(i, j, sliding, rolling);
    else if (!once || b < bodies.owned)
      memory.add(j, i, -sliding, rolling);
  });
  for (const WallTouch& t : touch.walls)
    if (t.touching) memory.add(bodies.id[t.row], -1 - t.wall, t.sliding, t.rolling);
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

std::vector<double> work_of(const Bodies& bodies, const TouchPairs& touch) {
  return work_of(bodies, touch, slot_work);
}

void find_touch_pairs(const Comm& comm, Bodies& bodies, const Walls& walls, const Period& period,
                      const TouchRange& range, const ContactMemory& memory, TouchPairs& touch) {
  double largest = 0;
  for (Index b = 0; b < bodies.owned; ++b) largest = std::max(largest, bodies.radius[b]);
  const double skin = skin_within(period, 2 * comm.max(largest) + range.gap, range.skin);
  const double slack = range.gap + skin;
  {
    std::vector<double> reaches(bodies.owned, slack / 2);
    find_ghosts(comm, bodies, period, reaches, touch);
  }
  find_near_pairs(bodies, {.common = slack / 2, .skin = skin}, Grouping::by_near_partners,
                  touch.windows, range.members);
  const Kept kept(bodies, memory);
  recall_springs(kept, range.rolling, touch);
  find_walls(bodies, walls, slack, kept, touch.walls);
  touch.equal = equal_windows(bodies, touch.windows);
  touch.gap = range.gap;
  touch.skin = skin;
  book_search(comm, touch);
}

}  // namespace spall
