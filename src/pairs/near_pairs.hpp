// Pairs within a range for forces between many neighbours, laid out for eight of them at a time.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "pairs/bonds.hpp"
#include "pairs/grid.hpp"
#include "pairs/links.hpp"
#include "pairs/motion_cells.hpp"
#include "pairs/search.hpp"
#include "spall/bodies.hpp"
#include "spall/comm.hpp"
#include "spall/lanes.hpp"

namespace spall {

/// A sweep over pairs keeps eight doubles of each body together; pairs name them by the place of
/// the first: eight times the row.
inline constexpr Index doubles_a_row = 8;

/// Bodies of one stretch of the space-filling curve with their partners: every pair is with its
/// body that comes first on the curve. A group is eight bodies, one a lane; their partners stand
/// slot by slot, lane by lane. Bodies share a group as `Grouping` says; one with fewer partners is
/// its own in the slots that are left, and so is the last body where it fills up the last group.
struct NearWindow {
  Index count = 0;                  ///< bodies
  std::vector<Index> rows;          ///< 8 places a group
  std::vector<Index> slots;         ///< of each group
  std::vector<Index> partners;      ///< 8 places a slot
  std::vector<std::uint8_t> bound;  ///< of each slot, a bit a lane; empty where bonds do not break
};

/// Edge of the cells of motion, of the range of pairs: what moves alike is no wider, what is so far
/// apart does not meet soon.
inline constexpr double motion_cell = 3;

/// A body is partner in no window after its own: once a window is done, nothing later in the same
/// sweep changes the forces on its bodies or looks at their positions, so that they may move on at
/// once while they are in the cache. A pair with a ghost is on both ranks, each time with the owned
/// body.
struct NearPairs : Search {
  std::vector<NearWindow> windows;
  bool bonds_break = false;    ///< the pairs tell which are bound
  std::optional<Bonds> bonds;  ///< for the first search, where there were any before
  double reach = 0;            ///< m, between centres, up to which any bodies may act on each other
  double skin = 0;             ///< m, beyond it, up to which pairs are listed; 0: search now
  MotionCells cells;           ///< of the places where pairs were found, where none repeats
  double moved = 0;  ///< m: no two bodies have come nearer to each other by more since then
  int steps = 0;     ///< that the pairs have served
  double pairs = 0;  ///< over all ranks, of the last search
};

/// Which bodies share a group: those with about as many partners where all of them cost the same,
/// or as many beside those in the skin alone, where these cost little.
enum class Grouping { by_partners, by_near_partners };

/// Finds all pairs with an owned body whose spheres meet when grown by `reach`; ghosts current.
/// Slots of those in the skin alone come last: a sweep passes them over as long as they stay there.
/// Rows whose ids, over `members`, are the same are parts of one body, and no pair.
void find_near_pairs(const Bodies& bodies, const Reach& reach, Grouping grouping,
                     std::vector<NearWindow>& windows, BodyId members = 1);

/// How far two bodies may act on each other, between their centres.
struct PairReach {
  double most;       ///< m, any two
  double radii = 0;  ///< not 0: so many times the sum of their radii, no more than `most`
};

/// Finds ghosts and pairs up to `reach` + `skin` (m) anew. Without `bonds` from before, bodies
/// nearer than `bonded` says are bound. The skin is less, and Error is thrown, as `skin_within`
/// says. Collective.
void find_near_pairs(const Comm& comm, Bodies& bodies, const Period& period, const PairReach& reach,
                     double skin, const BondReach& bonded, const std::optional<Bonds>& bonds,
                     NearPairs& near);

/// Finds ghosts and pairs up to `reach` + `skin` (m) anew; cuts the domain before where the ranks'
/// work differs by more than a tenth. Where bonds break they stay with their pairs; the first
/// search binds bodies nearer than `bonded` says. Collective.
void search_near_pairs(const Comm& comm, Bodies& bodies, const Period& period,
                       const PairReach& reach, double skin, const BondReach& bonded,
                       NearPairs& near);

/// Calls `f(slot, own, partners)` for every slot of a window, with the places of eight pairs.
template <class F>
void for_each_slot(const NearWindow& window, F&& f) {
  std::size_t slot = 0;
  for (std::size_t g = 0; g < window.slots.size(); ++g)
    for (const std::size_t end = slot + window.slots[g]; slot < end; ++slot)
      f(slot, &window.rows[g * lane_count], &window.partners[slot * lane_count]);
}

/// Calls `f(window, slot, lane, row, partner)` for every pair.
template <class F>
void for_each_pair(const std::vector<NearWindow>& windows, F&& f) {
  for (std::size_t w = 0; w < windows.size(); ++w)
    for_each_slot(windows[w], [&](std::size_t slot, const Index* own, const Index* partners) {
      for (std::size_t l = 0; l < lane_count; ++l)
        if (partners[l] != own[l])
          f(w, slot, l, own[l] / doubles_a_row, partners[l] / doubles_a_row);
    });
}

/// All pairs.
Links links_of(const std::vector<NearWindow>& windows);

/// Of owned bodies: 1 each, and `slot` for each place for a partner.
std::vector<double> work_of(const Bodies& bodies, const NearPairs& near, double slot);
/// The same as the domain is cut by for forces that are swept over all pairs.
std::vector<double> work_of(const Bodies& bodies, const NearPairs& near);
/// Pairs are found. Collective.
void book_search(const Comm& comm, NearPairs& near);

}  // namespace spall
