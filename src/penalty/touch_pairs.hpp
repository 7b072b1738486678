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

/// What the pairs of a window that touch keep from step to step: slot by slot x, then y, then z of
/// the lanes that touch (m; sliding of the partner against the body, rolling the same from either
/// side).
struct WindowSprings {
  std::vector<double> sliding, rolling;  ///< `rolling` is empty without rolling friction
  std::vector<std::uint8_t> touching;    ///< of each slot, a bit a lane
};

/// Other lanes of a slot, whose springs begin at `at`, are `touching` from now on: those behind it
/// make room or close up. What its own springs are is left to the caller.
void set_touching(WindowSprings& springs, std::size_t slot, std::size_t at, unsigned touching,
                  bool rolling);

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
  ContactMemory carried;  ///< springs to start from, of a restart; taken by the next search
  double gap = 0;         ///< m, at which bodies may act on each other
  std::vector<std::uint8_t> equal;  ///< of each window: its bodies, partners too, are of one size,
                                    ///< mass and material
};

/// How near bodies must come to be listed.
struct TouchRange {
  double gap = 0;        ///< m, at which bodies may act on each other
  double skin = 0;       ///< m
  bool rolling = false;  ///< rolling springs are kept
};

/// Of owned bodies, as the domain is cut by.
std::vector<double> work_of(const Bodies& bodies, const TouchPairs& touch);

/// Finds ghosts and pairs anew, with the springs of `memory`. Throws as `search_touch_pairs`.
/// Collective.
void find_touch_pairs(const Comm& comm, Bodies& bodies, const Walls& walls, const Period& period,
                      const TouchRange& range, const ContactMemory& memory, TouchPairs& touch);

/// Finds ghosts and pairs anew; cuts the domain before where the ranks' work differs by more than a
/// tenth. Springs stay with their pairs. Throws Error where space repeats itself so soon that a
/// body would meet two images of another. Collective.
void search_touch_pairs(const Comm& comm, Bodies& bodies, const Walls& walls, const Period& period,
                        const TouchRange& range, TouchPairs& touch);

/// The springs of all touching pairs by id; each on one rank with `once`, else on every rank that
/// has it.
ContactMemory remember(const Bodies& bodies, const TouchPairs& touch, bool once);

/// Contacts that this rank counts: all of its own bodies, one with a ghost on the lower id's rank.
std::int64_t count_touching(const Bodies& bodies, const TouchPairs& touch);

}  // namespace spall
