// Who is near whom in a piece, for sweeps of many lanes.
// SPDX-License-Identifier: BSD-3-Clause
#include "solid/piece_pairs.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <span>
#include <tuple>

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

void tell_slow(const Bodies& bodies, Elastoplastic& engine) {
  std::vector<double> is_slow(bodies.size());
  for (const Index b : engine.strides.slow) is_slow[b] = 1;
  engine.near.ghosts.gather(is_slow.data(), 1);
  engine.strides.is_slow.assign(is_slow.begin(), is_slow.end());
}

void note_paces(const std::vector<std::uint8_t>& is_slow, std::vector<PieceWindow>& windows) {
  const auto pace = [&](Index place) {
    return is_slow[place / doubles_a_row] ? Pace::slow : Pace::brisk;
  };
  for (PieceWindow& window : windows) {
    const Index* partners = window.partners.data();
    std::uint8_t* holds = window.holds.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      const Index* own = window.rows.data() + g * pair_lanes;
      for (Index s = 0; s < window.slots[g]; ++s, partners += pair_lanes) {
        std::uint8_t all = 0;
        for (std::size_t l = 0; l < pair_lanes; ++l)
          if (partners[l] != own[l]) all |= pace(own[l]) | pace(partners[l]);
        *holds++ = all;
      }
    }
  }
}

namespace {

/// The pairs of one piece of all that were found, with bodies where they were found, but for what
/// rests. Those that are slow stand last, so that few slots hold both.
std::vector<PieceWindow> pairs_of_pieces(const Bodies& bodies, const Elastoplastic& engine) {
  const std::vector<NearWindow>& windows = engine.near.windows;
  const std::vector<std::uint8_t>& is_slow = engine.strides.is_slow;
  const std::vector<double>& reach = engine.reach;
  // Whether a partner is slow, its distance squared, its place: one number is sorted soonest.
  const auto key_of = [](std::uint8_t slow, double distance2, Index place) {
    return std::uint64_t{slow} << 63 |
           std::uint64_t{std::bit_cast<std::uint32_t>(static_cast<float>(distance2))} << 32 |
           static_cast<std::uint32_t>(place);
  };
  const auto place_of = [](std::uint64_t key) { return static_cast<Index>(key & 0xffffffff); };
  struct Row {
    Index place;
    std::uint8_t slow;
    int within;  // partners
    std::vector<std::uint64_t> partners;
  };
  std::vector<PieceWindow> pieces(windows.size());
  std::vector<Row> all;  // their partners keep their memory from window to window
  for (std::size_t n = 0; n < windows.size(); ++n) {
    const NearWindow& window = windows[n];
    all.resize(std::max(all.size(), window.rows.size()));
    for (std::size_t r = 0; r < window.rows.size(); ++r) {
      all[r].place = window.rows[r];
      all[r].slow = is_slow[window.rows[r] / doubles_a_row];
      all[r].within = 0;
      all[r].partners.clear();
    }
    const Index* partners = window.partners.data();
    for (std::size_t g = 0; g < window.slots.size(); ++g)
      for (Index s = 0; s < window.slots[g]; ++s)
        for (std::size_t l = 0; l < lane_count; ++l) {
          Row& row = all[g * lane_count + l];
          const Index place = *partners++, i = row.place / doubles_a_row, j = place / doubles_a_row;
          if (place == row.place || bodies.group[i] != bodies.group[j] || rests(bodies, engine, i))
            continue;
          const double distance2 = (bodies.position[j] - bodies.position[i]).squaredNorm();
          row.within += distance2 < reach[i] * reach[i];
          row.partners.push_back(key_of(is_slow[j], distance2, place));
        }
    const auto rest = std::ranges::stable_partition(
        all.begin(), all.begin() + window.count,
        [&](const Row& row) { return !rests(bodies, engine, row.place / doubles_a_row); });
    const std::span rows(all.begin(), rest.begin());
    PieceWindow& piece = pieces[n];
    for (Row& row : rows) {
      std::ranges::sort(row.partners);
      piece.bodies.push_back(row.place / doubles_a_row);
    }
    std::ranges::stable_sort(rows, [](const Row& a, const Row& b) {
      return std::tuple(a.slow, b.within) < std::tuple(b.slow, a.within);
    });
    for (std::size_t first = 0; first < rows.size(); first += pair_lanes) {
      std::size_t most = 0;
      for (std::size_t l = 0; l < pair_lanes; ++l) {
        const std::size_t r = std::min(first + l, rows.size() - 1);
        piece.rows.push_back(rows[r].place);
        most = std::max(most, rows[r].partners.size());
      }
      piece.slots.push_back(static_cast<Index>(most));
      piece.holds.resize(piece.holds.size() + most);
      for (std::size_t s = 0; s < most; ++s)
        for (std::size_t r = first; r < first + pair_lanes; ++r) {
          const bool has = r < rows.size() && s < rows[r].partners.size();
          piece.partners.push_back(has ? place_of(rows[r].partners[s])
                                       : rows[std::min(r, rows.size() - 1)].place);
        }
    }
  }
  return pieces;
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
  return best_skin(world.comm, world.bodies, near, crowd, 0, skins_of_lattice(sums[0] / sums[1]));
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
  if (within_stride) {
    for (Index b = 0; b < world.bodies.owned; ++b) strides.from[b] += engine.rows[b].place;
    tell_slow(world.bodies, engine);
  } else {
    forget_slow(world.bodies, engine);
  }
  engine.pairs = pairs_of_pieces(world.bodies, engine);
  note_paces(strides.is_slow, engine.pairs);
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
    near.moved = approach_since_search(world, near);
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
