// Bodies that may touch each other or a wall within some steps, with the springs of those that do.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "pairs/near_pairs.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "spall/lanes.hpp"
#include "state/contact_memory.hpp"
#include "state/walls.hpp"

namespace spall {

/// Springs of pairs, one after another (m): all x, then all y, then all z.
class SpringList {
 public:
  double* x() { return all_.data(); }
  double* y() { return all_.data() + room_; }
  double* z() { return all_.data() + 2 * room_; }
  const double* x() const { return all_.data(); }
  const double* y() const { return all_.data() + room_; }
  const double* z() const { return all_.data() + 2 * room_; }
  /// Zero where there are none.
  Vec3 operator[](std::size_t k) const {
    return k < room_ ? Vec3(x()[k], y()[k], z()[k]) : Vec3(Vec3::Zero());
  }
  /// Room for so many, whose values mean nothing yet.
  void make_room(std::size_t count);
  /// So many, number k of which is `spring(k)`.
  template <class Spring>
  void fill(std::size_t count, Spring&& spring) {
    make_room(count);
    for (std::size_t k = 0; k < count; ++k) {
      const Vec3 one = spring(k);
      x()[k] = one.x();
      y()[k] = one.y();
      z()[k] = one.z();
    }
  }
  /// The first `count` of `from`.
  void take(const SpringList& from, std::size_t count);

 private:
  std::size_t room_ = 0;
  std::vector<double> all_;
};

/// What the pairs of a window that touch keep from step to step, in the order of slots and lanes:
/// sliding of the partner against the body, rolling the same from either side.
struct WindowSprings {
  SpringList sliding, rolling;         ///< `rolling` is empty without rolling friction
  std::vector<std::uint8_t> touching;  ///< of each slot, a bit a lane
};

/// A bit for each of the next pairs, eight or as many as are `left`: whether it touched. `places`:
/// 8 slot + lane.
unsigned touched(const WindowSprings& springs, const Index* places, std::size_t left);
/// The pairs of these bits touch if they did not, and the other way round.
void toggle_touched(unsigned pairs, const Index* places, WindowSprings& springs);

/// What a sweep adds up for a body; zero before it.
struct alignas(64) ForceRow {
  RowHalf force;   ///< N, and the power (W) that the body loses
  RowHalf torque;  ///< N m
};
static_assert(sizeof(ForceRow) == doubles_a_row * sizeof(double));

/// A body near a wall; springs are of the wall against the body.
struct WallTouch {
  Index row;
  std::int32_t wall;
  bool touching = false;
  Vec3 sliding = Vec3::Zero(), rolling = Vec3::Zero();
};

struct TouchPairs : NearPairs {
  std::vector<WindowSprings> springs;  ///< of each window
  std::vector<WallTouch> walls;
  SharedContacts carried;  ///< springs to start from, of a restart; taken by the next search. Of
                           ///< clumps by the ids of bodies
  double gap = 0;          ///< m, at which bodies may act on each other
  std::vector<std::uint8_t> equal;  ///< of each window: its bodies, partners too, are of one size,
                                    ///< mass and material
};

/// How near bodies must come to be listed.
struct TouchRange {
  double gap = 0;        ///< m, at which bodies may act on each other
  double skin = 0;       ///< m
  bool rolling = false;  ///< rolling springs are kept
  BodyId members = 1;    ///< rows whose ids agree over it are of one body, and do not meet
};

/// Of owned bodies, as the domain is cut by.
std::vector<double> work_of(const Bodies& bodies, const TouchPairs& touch);

/// Finds ghosts and pairs anew, with the springs of `memory`. Throws as `search_touch_pairs`
/// (penalty/members.hpp). Collective.
void find_touch_pairs(const Comm& comm, Bodies& bodies, const Walls& walls, const Period& period,
                      const TouchRange& range, const ContactMemory& memory, TouchPairs& touch);

/// The springs of all touching pairs by id; each on one rank with `once`, else on every rank that
/// has it.
ContactMemory remember(const Bodies& bodies, const TouchPairs& touch, bool once);

/// Contacts that this rank counts: all of its own bodies, one with a ghost on the lower id's rank.
std::int64_t count_touching(const Bodies& bodies, const TouchPairs& touch);

}  // namespace spall
