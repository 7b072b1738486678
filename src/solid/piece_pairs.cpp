// Who is near whom in a piece, for sweeps of many lanes.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/piece_pairs.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>

#include "pairs/flight.hpp"
#include "solid/bodies_step.hpp"

namespace spall {

void fill_rows(const World& world, Elastoplastic& engine) {
  const Bodies& bodies = world.bodies;
  const auto size = static_cast<std::size_t>(bodies.size());
  engine.rest_volume = rest_volumes(bodies, engine.laws);
  engine.reach.resize(size);
  engine.rows.resize(size);
  engine.shapes.resize(size);
  engine.responses.resize(size);
  engine.impulses.assign(size, PushRow{});
  engine.waves.resize(bodies.owned);
  for (Index b = 0; b < bodies.size(); ++b) {
    engine.reach[b] = neighbour_reach * 2 * bodies.radius[b];
    engine.rows[b] = {
        half_row(bodies.position[b], engine.rest_volume[b] / std::max(1.0, bodies.compression[b])),
        half_row(bodies.velocity[b], bodies.damage[b] >= 1 ? infinity : bodies.pressure[b])};
  }
}

void take_positions(World& world, const Elastoplastic& engine) {
  for (Index b = 0; b < world.bodies.owned; ++b)
    world.bodies.position[b] = vector_of(engine.rows[b].place);
}

double widest_spacing(const World& world) {
  double radius = 0;
  for (Index b = 0; b < world.bodies.owned; ++b) radius = std::max(radius, world.bodies.radius[b]);
  return 2 * world.comm.max(radius);
}

PairReach reach_of_pieces(const World& world) {
  return {.most = neighbour_reach * widest_spacing(world), .radii = neighbour_reach};
}

namespace {

/// A step leaves such a body as it is, among others that are as still.
bool is_still(const Bodies& bodies, Index b) {
  return bodies.velocity[b].isZero(0) && bodies.kick[b].isZero(0) &&
         bodies.direct_stress[b].isZero(0) && bodies.shear_stress[b].isZero(0) &&
         bodies.pressure[b] == 0 && bodies.compression[b] == 1 && bodies.heat[b] == 0 &&
         bodies.internal_energy[b] == 0 && (!bodies.has(Field::crushed) || bodies.crushed[b] == 0);
}

bool rests(const Bodies& bodies, const Elastoplastic& engine, Index b) {
  return !engine.rests.empty() && engine.rests[static_cast<std::size_t>(bodies.group[b])];
}

/// As `Elastoplastic::rests`, of the pairs of bodies of two groups, and of bodies and walls, that
/// are listed; empty where no group rests. Collective.
std::vector<std::uint8_t> resting_groups(const World& world, const SolidContacts& contacts) {
  const Bodies& bodies = world.bodies;
  if (world.has_gravity() || !world.own_forces.empty()) return {};
  double groups = 0;
  for (Index b = 0; b < bodies.owned; ++b) groups = std::max(groups, bodies.group[b] + 1.0);
  std::vector<double> acts(static_cast<std::size_t>(world.comm.max(groups)));
  const auto note = [&](Index b) { acts[static_cast<std::size_t>(bodies.group[b])] = 1; };
  for (Index b = 0; b < bodies.owned; ++b)
    if (!is_still(bodies, b)) note(b);
  for (const PieceContact& c : contacts.pieces) note(c.i), note(c.j);
  for (const WallContact& c : contacts.walls) note(c.row);
  world.comm.max(acts);
  if (std::ranges::count(acts, 0) == 0) return {};
  std::vector<std::uint8_t> rest(acts.size());
  for (std::size_t g = 0; g < acts.size(); ++g) rest[g] = acts[g] == 0;
  return rest;
}

}  // namespace

void wake_what_moves(const World& world, Elastoplastic& engine) {
  if (engine.rests.empty()) return;
  double moves = world.own_forces.empty() ? 0 : 1;
  for (Index b = 0; b < world.bodies.owned; ++b)
    if (rests(world.bodies, engine, b) && !is_still(world.bodies, b)) moves = 1;
  if (world.comm.max(moves) == 0) return;
  engine.near.skin = 0;
  engine.next_part = 0;  // that of others, or of none
}

void forget_slow(const Bodies& bodies, Elastoplastic& engine) {
  Strides& strides = engine.strides;
  strides.lasts = 0;
  strides.work = 1;
  strides.is_slow.assign(bodies.size(), 0);
  strides.slow.clear();
  strides.brisk.clear();
  for (Index b = 0; b < bodies.owned; ++b)
    if (!rests(bodies, engine, b)) strides.brisk.push_back(b);
}

namespace {

/// A body and its partners in a window.
struct WindowRow {
  Index place;
  std::size_t weight;  ///< rows of about the same stand in one group: how many partners act
  std::vector<Index> partners;
};

/// Adds a window of these rows, which are put into order.
void add_window(std::span<WindowRow> rows, std::span<const Index> bodies, PiecePairs& pairs) {
  std::ranges::stable_sort(rows, std::ranges::less(), &WindowRow::weight);
  for (std::size_t first = 0; first < rows.size(); first += pair_lanes) {
    const std::span group = rows.subspan(first, std::min(pair_lanes, rows.size() - first));
    std::size_t slots = 0;
    for (const WindowRow& row : group) slots = std::max(slots, row.partners.size());
    pairs.slots.push_back(static_cast<Index>(slots));
    const std::size_t before = pairs.partners.size();
    pairs.partners.resize(before + slots * pair_lanes, group.back().place);
    for (std::size_t l = 0; l < pair_lanes; ++l) {
      const WindowRow& row = group[std::min(l, group.size() - 1)];
      pairs.rows.push_back(row.place);
      if (l >= group.size()) continue;
      for (std::size_t s = 0; s < slots; ++s)
        pairs.partners[before + s * pair_lanes + l] =
            s < row.partners.size() ? row.partners[s] : row.place;
    }
  }
  pairs.bodies.insert(pairs.bodies.end(), bodies.begin(), bodies.end());
  pairs.windows.push_back({pairs.slots.size(), pairs.bodies.size()});
}

/// Of each window those pairs that have a brisk body.
void find_brisk_pairs(const PiecePairs& all, const std::vector<std::uint8_t>& is_slow,
                      PiecePairs& brisk) {
  brisk.clear();
  std::vector<WindowRow> rows;  // their partners keep their memory from window to window
  const Index* partners = all.partners.data();
  for (std::size_t n = 0, g = 0; n < all.windows.size(); ++n) {
    const std::size_t groups = all.windows[n].groups;
    rows.resize(std::max(rows.size(), (groups - g) * pair_lanes));
    std::size_t count = 0;
    for (; g < groups; ++g) {
      const Index* own = all.rows.data() + g * pair_lanes;
      for (std::size_t l = 0; l < pair_lanes; ++l) {
        WindowRow& row = rows[count];
        row.place = own[l];
        row.partners.clear();
        const std::uint8_t slow = is_slow[own[l] / doubles_a_row];
        for (Index s = 0; s < all.slots[g]; ++s) {
          const Index place = partners[static_cast<std::size_t>(s) * pair_lanes + l];
          if (place != own[l] && !(slow & is_slow[place / doubles_a_row]))
            row.partners.push_back(place);
        }
        row.weight = row.partners.size();
        count += row.weight > 0;
      }
      partners += static_cast<std::size_t>(all.slots[g]) * pair_lanes;
    }
    add_window({rows.data(), count}, all.bodies_of(n), brisk);
  }
}

}  // namespace

void tell_slow(const Bodies& bodies, Elastoplastic& engine) {
  Strides& strides = engine.strides;
  std::vector<double> is_slow(bodies.size());
  for (const Index b : strides.slow) is_slow[b] = 1;
  engine.near.ghosts.gather(is_slow.data(), 1);
  strides.is_slow.assign(is_slow.begin(), is_slow.end());
  find_brisk_pairs(engine.pairs, strides.is_slow, strides.brisk_pairs);
}

namespace {

/// The pairs of one piece of all that were found, with bodies where they were found, but for what
/// rests.
void find_piece_pairs(const Bodies& bodies, Elastoplastic& engine) {
  const std::vector<NearWindow>& windows = engine.near.windows;
  // Partners within reach stand first, then those in parts of the skin, as they may come within.
  constexpr std::size_t shells = 4;
  std::array<std::vector<Index>, shells> of_row;
  std::vector<WindowRow> rows;  // their partners keep their memory from window to window
  std::vector<Index> moving;
  engine.pairs.clear();
  for (const NearWindow& window : windows) {
    rows.resize(std::max(rows.size(), window.rows.size()));
    moving.clear();
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      for (std::size_t l = 0; l < lane_count; ++l) {
        const std::size_t r = g * lane_count + l;
        const Index i = window.rows[r] / doubles_a_row;
        if (r >= static_cast<std::size_t>(window.count) || rests(bodies, engine, i)) continue;
        std::array<double, shells - 1> end2;
        for (std::size_t k = 0; k < end2.size(); ++k) {
          const double end = engine.reach[i] + engine.near.skin * k / end2.size();
          end2[k] = end * end;
        }
        for (auto& shell : of_row) shell.clear();
        for (Index s = 0; s < window.slots[g]; ++s) {
          const Index place = partners[s * static_cast<Index>(lane_count) + l];
          const Index j = place / doubles_a_row;
          if (i == j || bodies.group[i] != bodies.group[j]) continue;
          const double distance2 = (bodies.position[j] - bodies.position[i]).squaredNorm();
          std::size_t shell = 0;
          for (const double end : end2) shell += distance2 >= end;
          of_row[shell].push_back(place);
        }
        WindowRow& row = rows[moving.size()];
        row.place = window.rows[r];
        row.weight = of_row[0].size();
        row.partners.clear();
        for (const auto& shell : of_row)
          row.partners.insert(row.partners.end(), shell.begin(), shell.end());
        moving.push_back(i);
      }
      partners += window.slots[g] * static_cast<Index>(lane_count);
    }
    add_window({rows.data(), moving.size()}, moving, engine.pairs);
  }
}

/// The skin of the next search. A body in a lattice of the spacing d has as many partners as
/// (1.7 + skin/d)^3, whatever d.
double skin_of(const World& world, const NearPairs& near) {
  std::array<double, 4> sums{};  // of the powers of 1/d
  for (Index b = 0; b < world.bodies.owned; ++b) {
    const double inverse = 1 / (2 * world.bodies.radius[b]);
    const std::array<double, 4> powers{1, inverse, inverse * inverse, inverse * inverse * inverse};
    for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += powers[k];
  }
  world.comm.sum(sums);
  const double R = neighbour_reach;
  const Crowd crowd{R * sums[2] / sums[3], R * R * sums[1] / sums[3],
                    R * R * R * sums[0] / sums[3]};
  // Two sweeps take longer than one, so a search counts for less than elsewhere.
  SkinRange range = skins_of_lattice(sums[0] / sums[1]);
  range.search = 90;
  range.lists = inner_lists;
  range.list = 0.25;
  return best_skin(world.comm, world.bodies, near, crowd, 0, range);
}

/// What rests from now on. Within a stride nothing falls asleep, and what wakes is brisk.
/// Collective.
void find_resting(const World& world, Elastoplastic& engine, bool within_stride) {
  std::vector<std::uint8_t> now = resting_groups(world, engine.contacts);
  if (within_stride) {
    now.resize(engine.rests.size());
    for (std::size_t g = 0; g < now.size(); ++g) now[g] &= engine.rests[g];
    Strides& strides = engine.strides;
    for (Index b = 0; b < world.bodies.owned; ++b) {
      if (!rests(world.bodies, engine, b) || now[static_cast<std::size_t>(world.bodies.group[b])])
        continue;
      strides.brisk.push_back(b);
      strides.kick_by_slow[b] = Vec3::Zero();
    }
    std::ranges::sort(strides.brisk);
  }
  engine.rests = std::move(now);
}

/// Pairs and ghosts anew. Within a stride the domain is not cut: bodies stay where they are.
void search_pairs(World& world, Elastoplastic& engine) {
  NearPairs& near = engine.near;
  Strides& strides = engine.strides;
  const double skin = skin_of(world, near);
  const bool within_stride = strides.lasts > 0;
  if (within_stride)
    for (Index b = 0; b < world.bodies.owned; ++b) strides.from[b] -= engine.rows[b].place;
  take_positions(world, engine);
  wrap_bodies(world);
  if (within_stride)
    find_near_pairs(world.comm, world.bodies, world.period, reach_of_pieces(world), skin, {}, {},
                    near);
  else
    search_near_pairs(world.comm, world.bodies, world.period, reach_of_pieces(world), skin, {},
                      near);
  engine.contacts = find_contacts(world, near.windows, near.skin);
  find_resting(world, engine, within_stride);
  fill_rows(world, engine);
  find_piece_pairs(world.bodies, engine);
  if (within_stride) {
    for (Index b = 0; b < world.bodies.owned; ++b) strides.from[b] += engine.rows[b].place;
    tell_slow(world.bodies, engine);
  } else {
    forget_slow(world.bodies, engine);
  }
  strides.served = 0;
  strides.cut_waits = within_stride && world.comm.size > 1;
}

}  // namespace

void update_pairs(World& world, Elastoplastic& engine) {
  StageTimer timer(world.stages, "neighbours");
  NearPairs& near = engine.near;
  near.cut = world.cut;
  if (near.skin > 0 && near.moved > near.skin) {
    take_positions(world, engine);
    const double booked = near.moved;
    near.moved = approach_since_search(world, near);
    // Inner lists hold for as long as before.
    for (PiecePairs* pairs : {&engine.pairs, &engine.strides.brisk_pairs})
      pairs->inner_at -= booked - near.moved;
  }
  // Where the last search could not cut the domain, the next step's first one does.
  const bool cut_waits = engine.strides.cut_waits && engine.strides.lasts == 0;
  if (near.skin == 0 || near.moved > near.skin || cut_waits)
    search_pairs(world, engine);
  else
    near.steps = static_cast<int>(engine.strides.served += engine.strides.work);
  near.ghosts.gather(doubles(engine.rows), doubles_a_row);
  if (world.period.any())
    for (Index g = 0; g < near.ghosts.ghosts(); ++g)
      engine.rows[world.bodies.owned + g].place += half_row(near.shifts[g], 0);
}

}  // namespace spall
