// Bodies over ranks: migration loses nothing, halos and pairs miss nothing.
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

#include "base/morton.hpp"
#include "domain/bisection.hpp"
#include "domain/halo.hpp"
#include "domain/migration.hpp"
#include "domain/partition.hpp"
#include "pairs/broad_phase.hpp"
#include "pairs/flight.hpp"
#include "pairs/motion_cells.hpp"
#include "pairs/near_pairs.hpp"
#include "pairs/neighbours.hpp"
#include "pairs/search.hpp"
#include "rigid/narrow_phase.hpp"
#include "state/pack.hpp"
#include "testing.hpp"

namespace spall {
namespace {

using PairSet = std::set<std::pair<BodyId, BodyId>>;

/// `count` spheres in a cube, radii over two decades, the same on any number of ranks; all of them.
Bodies random_bodies(int count, double spread = 100) {
  std::mt19937_64 random(7);
  auto uniform = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
  Bodies bodies;
  resize(bodies, count);
  for (Index b = 0; b < count; ++b) {
    bodies.id[b] = b;
    bodies.radius[b] = 0.05 * std::pow(spread, uniform() * uniform() * uniform());
    bodies.mass[b] = std::pow(bodies.radius[b], 3);
    bodies.position[b] = 10 * Vec3(uniform(), uniform(), uniform());
    bodies.velocity[b] = Vec3(uniform(), uniform(), uniform());
    bodies.angular_velocity[b] = Vec3(b, 2 * b, 3 * b);
    bodies.group[b] = b % 3;
    bodies.material[b] = b % 2;
    bodies.acceleration[b] = Vec3(-b, b, 1);
    bodies.heat[b] = 1 + b;
    bodies.kick[b] = Vec3(2, -b, b);
    bodies.bonds[b] = b % 13;
    bodies.damage[b] = 1.0 / (1 + b);
  }
  bodies.owned = count;
  return bodies;
}

std::vector<double> packed(const Bodies& bodies, Index b, unsigned any_of) {
  std::vector<double> row;
  pack_row(bodies, b, any_of, row);
  return row;
}

/// This rank's share, dealt out by id.
Bodies share(const Bodies& all, const Comm& comm) {
  Bodies mine;
  for (Index b = 0; b < all.size(); ++b) {
    if (b % comm.size != comm.rank) continue;
    unpack_rows(mine, packed(all, b, ~0u), ~0u);
  }
  mine.owned = mine.size();
  return mine;
}

PairSet brute_force(const Bodies& all, double reach) {
  PairSet pairs;
  for (Index a = 0; a < all.size(); ++a)
    for (Index b = a + 1; b < all.size(); ++b)
      if ((all.position[a] - all.position[b]).norm() <= all.radius[a] + all.radius[b] + 2 * reach)
        pairs.emplace(a, b);
  return pairs;
}

TEST(Migration, every_body_arrives_once_with_all_its_fields) {
  const Comm comm = testing_world();
  const Bodies all = random_bodies(500);
  Bodies mine = share(all, comm);
  SharedContacts memory;
  if (comm.rank == 0)
    memory = ContactMemory{{3, 7, 9},
                           {4, -1, 200},
                           {Vec3(1, 2, 3), Vec3(4, 5, 6), Vec3::Ones()},
                           std::vector<Vec3>(3, Vec3(7, 8, 9)),
                           {}};
  std::vector<int> owner(mine.owned);
  for (Index b = 0; b < mine.owned; ++b)
    owner[b] = static_cast<int>(mine.id[b] * 31 % 7) % comm.size;
  migrate(comm, mine, memory, owner);
  EXPECT_EQ(comm.sum(static_cast<std::int64_t>(mine.owned)), 500);
  std::set<BodyId> here;
  for (Index b = 0; b < mine.owned; ++b) {
    const auto id = mine.id[b];
    here.insert(id);
    EXPECT_EQ(static_cast<int>(id * 31 % 7) % comm.size, comm.rank);
    EXPECT_EQ(packed(mine, b, trait::migrated), packed(all, static_cast<Index>(id), ~0u));
  }
  // Memory is wherever one of the contact's bodies is.
  const std::set<BodyId> remembered(memory->i.begin(), memory->i.end());
  EXPECT_EQ(remembered.count(3), here.count(3) || here.count(4));
  EXPECT_EQ(remembered.count(7), here.count(7));
  EXPECT_EQ(remembered.count(9), here.count(9) || here.count(200));
}

TEST(Migration, memory_of_contacts_with_ghosts_goes_where_ghosts_go) {
  const Comm comm = testing_world();
  Bodies mine = share(random_bodies(500), comm);
  std::vector<double> reach(mine.owned, 0.5);
  const Ghosts ghosts = make_halo(comm, mine, reach);
  const auto goes_to = [&](BodyId id) { return static_cast<int>(id * 31 % 7) % comm.size; };
  ContactMemory known;
  for (Index g = mine.owned; g < mine.size(); ++g) {
    const auto [low, high] = std::minmax(mine.id[0], mine.id[g]);
    known.add(low, high, Vec3(static_cast<double>(low), static_cast<double>(high), 0));
  }
  double expected = 0;
  for (std::size_t m = 0; m < known.size(); ++m)
    expected += 1 + (goes_to(known.i[m]) != goes_to(known.j[m]));
  std::vector<int> owner(mine.owned);
  for (Index b = 0; b < mine.owned; ++b) owner[b] = goes_to(mine.id[b]);
  tell_ghosts(mine, ghosts, owner);
  ASSERT_EQ(std::ssize(owner), mine.size());
  for (Index b = 0; b < mine.size(); ++b) EXPECT_EQ(owner[b], goes_to(mine.id[b]));
  SharedContacts memory(known);
  migrate(comm, mine, memory, owner);
  EXPECT_EQ(comm.sum(static_cast<double>(memory->size())), comm.sum(expected));
  for (std::size_t m = 0; m < memory->size(); ++m) {
    EXPECT_TRUE(goes_to(memory->i[m]) == comm.rank || goes_to(memory->j[m]) == comm.rank);
    EXPECT_EQ(memory->impulse[m][1], static_cast<double>(memory->j[m]));
  }
}

class EachCut : public testing::TestWithParam<Cut> {};
INSTANTIATE_TEST_SUITE_P(Partition, EachCut, testing::Values(Cut::bisection, Cut::metis));

TEST_P(EachCut, makes_parts_that_are_balanced_and_compact) {
  const Comm comm = testing_world();
  Bodies all = random_bodies(4000, 1);
  Bodies mine = share(all, comm);
  const std::vector<double> work(mine.owned, 1.0);
  SharedContacts memory;
  migrate(comm, mine, memory, partition(comm, mine, work, GetParam()));
  // The width of the cells may depend on where bodies lie at first; from the second cut on it does
  // not.
  migrate(comm, mine, memory,
          partition(comm, mine, std::vector<double>(mine.owned, 1.0), GetParam()));
  EXPECT_LT(imbalance(comm, mine.owned), 1.1);
  std::vector<double> reach(mine.owned, 0.05);
  make_halo(comm, mine, reach);
  // A quarter of a cube in slabs or columns has few bodies near its faces.
  EXPECT_LT(mine.ghosts(), 0.5 * mine.owned);
  // Cut again: nobody moves.
  const auto again = partition(comm, mine, std::vector<double>(mine.owned, 1.0), GetParam());
  EXPECT_EQ(std::count(again.begin(), again.end(), comm.rank), mine.owned);
}

TEST(Bisection, shares_work_in_boxes_that_do_not_overlap_and_hardly_move) {
  const Comm comm = testing_world();
  const Bodies all = random_bodies(4000, 1);
  Bodies mine = share(all, comm);
  SharedContacts memory;
  const auto work_of = [](const Bodies& bodies) {  // more of it on one side, as in an impact
    std::vector<double> work;
    for (Index b = 0; b < bodies.owned; ++b) work.push_back(1 + bodies.position[b].x());
    return work;
  };
  for (int cut = 0; cut < 2; ++cut) migrate(comm, mine, memory, bisect(comm, mine, work_of(mine)));
  const auto work = work_of(mine);
  // A cut may miss its share by a thousandth of all that it halves, and by a body.
  EXPECT_LT(imbalance(comm, std::accumulate(work.begin(), work.end(), 0.0)), 1.02);
  std::vector<double> ends;
  for (int k = 0; k < 3; ++k) {
    double low = infinity, high = -infinity;
    for (Index b = 0; b < mine.owned; ++b) {
      low = std::min(low, mine.position[b][k]);
      high = std::max(high, mine.position[b][k]);
    }
    ends.insert(ends.end(), {low, high});
  }
  ends = comm.all_gather(ends);
  for (int a = 0; a < comm.size; ++a)
    for (int b = 0; b < a; ++b) {
      bool apart = false;
      for (int k = 0; k < 3; ++k)
        apart |= ends[6 * a + 2 * k] > ends[6 * b + 2 * k + 1] ||
                 ends[6 * b + 2 * k] > ends[6 * a + 2 * k + 1];
      EXPECT_TRUE(apart) << a << " " << b;
    }
  for (Index b = 0; b < mine.owned; ++b) mine.position[b] += 0.001 * mine.velocity[b];
  const auto again = bisect(comm, mine, work_of(mine));
  const auto stay = std::count(again.begin(), again.end(), comm.rank);
  EXPECT_GT(comm.sum(static_cast<std::int64_t>(stay)), 3950);
}

TEST(Bisection, shares_out_few_bodies_and_bodies_at_one_place) {
  const Comm comm = testing_world();
  for (int count : {0, 1, 3}) {
    Bodies all = random_bodies(count);
    for (Index b = 0; b < count; ++b) all.position[b] = Vec3(1, 2, 3);
    Bodies mine = share(all, comm);
    for (int owner : bisect(comm, mine, std::vector<double>(mine.owned, 1.0))) {
      EXPECT_GE(owner, 0);
      EXPECT_LT(owner, comm.size);
    }
  }
}

TEST(Halo, pairs_of_all_ranks_are_those_of_brute_force) {
  const Comm comm = testing_world();
  for (double spread : {1.0, 100.0}) {
    const Bodies all = random_bodies(800, spread);
    const double reach = 0.03;
    const PairSet expected = brute_force(all, reach);
    Bodies mine = share(all, comm);
    SharedContacts memory;
    migrate(comm, mine, memory, partition(comm, mine, std::vector<double>(mine.owned, 1.0)));
    std::vector<double> reaches(mine.owned, reach);
    const Ghosts ghosts = make_halo(comm, mine, reaches);
    EXPECT_EQ(ghosts.ghosts(), mine.ghosts());
    for (Index b = mine.owned; b < mine.size(); ++b) {
      const auto original = static_cast<Index>(mine.id[b]);
      EXPECT_EQ(packed(mine, b, trait::ghosted), packed(all, original, trait::ghosted));
      EXPECT_EQ(mine.heat[b], 0);  // which ghosts do not have
    }
    const Pairs pairs = find_pairs(mine, reaches, {});
    PairSet found;
    for (Index p = 0; p < pairs.size(); ++p) {
      const BodyId i = mine.id[pairs.i[p]], j = mine.id[pairs.j[p]];
      EXPECT_LT(i, j);
      EXPECT_TRUE(found.emplace(i, j).second) << i << " " << j << " twice";
      EXPECT_EQ(p < pairs.boundary, pairs.i[p] >= mine.owned || pairs.j[p] >= mine.owned);
      EXPECT_TRUE(expected.count({i, j}));
      EXPECT_EQ(pairs.plane[p], -1);
    }
    // Every pair is on each rank that owns one of its bodies.
    std::set<BodyId> here(mine.id.begin(), mine.id.begin() + mine.owned);
    for (const auto& [i, j] : expected)
      EXPECT_EQ(found.count({i, j}), here.count(i) || here.count(j)) << i << " " << j;
  }
}

TEST(Halo, has_the_ghosts_that_pairs_need_and_no_others_in_any_order_of_memory) {
  const Comm comm = testing_world();
  const int edge = 15;
  Bodies all = random_bodies(edge * edge * edge, 1);
  for (Index b = 0; b < all.size(); ++b)  // a grid, stirred: as dense as a packing
    all.position[b] = 0.1 * Vec3(b % edge, b / edge % edge, b / edge / edge) +
                      0.01 * (all.position[b] - Vec3::Constant(5));
  const Period period{.size = Vec3(0.1 * edge, 0, 0)};
  Bodies mine = share(all, comm);
  SharedContacts memory;
  migrate(comm, mine, memory, partition(comm, mine, std::vector<double>(mine.owned, 1.0)));
  for_each_field(mine, [&](const auto&, auto& field) {
    std::shuffle(field.begin(), field.end(), std::mt19937_64(3));
  });
  for (double reach : {0.025, 0.1}) {
    std::vector<double> reaches(mine.owned, reach);
    std::vector<Vec3> shifts;
    make_halo(comm, mine, reaches, period, shifts);
    const std::set<BodyId> here(mine.id.begin(), mine.id.begin() + mine.owned);
    std::map<std::pair<BodyId, int>, bool> needed;  // a body's image, and whether it is a ghost
    for (int image : {-1, 0, 1})
      for (Index b = 0; b < all.size(); ++b) {
        if (image == 0 && here.count(all.id[b])) continue;
        const Vec3 x = all.position[b] + image * period.size;
        for (Index own = 0; own < mine.owned; ++own)
          if ((x - mine.position[own]).norm() <= 2 * (all.radius[b] + reach)) {
            needed[{all.id[b], image}] = false;
            break;
          }
      }
    for (Index g = mine.owned; g < mine.size(); ++g) {
      const auto image = std::lround(shifts[g - mine.owned][0] / period.size[0]);
      const auto ghost = needed.find({mine.id[g], static_cast<int>(image)});
      ASSERT_NE(ghost, needed.end()) << "in vain";
      EXPECT_FALSE(ghost->second) << "twice";
      ghost->second = true;
    }
    for (const auto& [body, is_ghost] : needed) EXPECT_TRUE(is_ghost);
  }
}

TEST(Windows, bodies_with_as_many_near_partners_share_a_group) {
  Bodies all = random_bodies(600, 1);
  all.owned = all.size();
  std::vector<NearWindow> windows;
  find_near_pairs(all, {.common = 0.6, .skin = 0.6}, Grouping::by_near_partners, windows);
  const auto near = [&](Index own, Index partner) {
    const Index a = own / doubles_a_row, b = partner / doubles_a_row;
    return own != partner &&
           (all.position[a] - all.position[b]).norm() < all.radius[a] + all.radius[b] + 1.2 - 0.6;
  };
  int filled = 0;
  for (const NearWindow& window : windows) {
    std::size_t slot = 0;
    int fewest = 1 << 30;  // near partners of a body of the groups before
    for (std::size_t g = 0; g < window.slots.size(); ++g) {
      std::array<int, lane_count> count{};
      for (const std::size_t end = slot + window.slots[g]; slot < end; ++slot)
        for (std::size_t l = 0; l < lane_count; ++l)
          count[l] += near(window.rows[g * lane_count + l], window.partners[slot * lane_count + l]);
      EXPECT_LE(*std::ranges::max_element(count), fewest);
      fewest = *std::ranges::min_element(count);
      filled += count[0];
    }
  }
  EXPECT_GT(filled, 5);
}

TEST(Crowd, tells_the_mean_of_all_pairs) {
  const Comm comm = testing_world();
  const Bodies all = random_bodies(200, 10);
  const Crowd crowd = crowd_of(comm, share(all, comm), 1e9);
  for (double gap : {0.0, 0.03, 2.0}) {
    double sum = 0;
    for (double a : all.radius)
      for (double b : all.radius) sum += std::pow(a + b + gap, 3);
    EXPECT_NEAR(crowd.volume(gap), sum / 200 / 200, 1e-12 * crowd.volume(gap));
  }
}

TEST(Windows, list_each_pair_once_for_any_sizes_and_images) {
  const Comm comm = testing_world();
  using Image = std::tuple<BodyId, BodyId, int>;  // and how often j is displaced along x
  for (const auto& [spread, edge] :
       {std::pair(1.0, 0.0), std::pair(10.0, 10.0), std::pair(100.0, 0.0)}) {
    const Bodies all = random_bodies(600, spread);
    const double slack = 0.06, skin = 0.04;
    const Period period{.size = Vec3(edge, 0, 0)};
    const auto distance = [&](BodyId i, BodyId j, int images) {
      return (all.position[j] + images * period.size - all.position[i]).norm();
    };
    Bodies mine = share(all, comm);
    SharedContacts memory;
    migrate(comm, mine, memory, partition(comm, mine, std::vector<double>(mine.owned, 1.0)));
    std::vector<double> reaches(mine.owned, slack / 2);
    std::vector<Vec3> shifts;
    const Ghosts ghosts = make_halo(comm, mine, reaches, period, shifts);
    std::vector<NearWindow> windows;
    find_near_pairs(mine, {.common = slack / 2, .skin = skin}, Grouping::by_partners, windows);

    std::vector<std::size_t> window_of(mine.owned, windows.size());
    std::size_t bodies = 0;
    for (std::size_t w = 0; w < windows.size(); ++w)
      for (Index k = 0; k < windows[w].count; ++k, ++bodies)
        window_of[windows[w].rows[k] / doubles_a_row] = w;
    EXPECT_EQ(bodies, static_cast<std::size_t>(mine.owned));
    std::map<Image, int> found;
    std::vector<bool> in_skin(mine.owned, false);
    for_each_pair(windows, [&](std::size_t w, std::size_t, std::size_t, Index a, Index b) {
      ASSERT_LT(a, mine.owned);
      EXPECT_EQ(window_of[a], w);
      if (b < mine.owned) {
        EXPECT_GE(window_of[b], w) << "a partner's window is over";
      }
      const BodyId i = mine.id[a], j = mine.id[b];
      const int images =
          edge == 0
              ? 0
              : static_cast<int>(std::lround((mine.position[b][0] - all.position[j][0]) / edge));
      ++found[i < j ? Image(i, j, images) : Image(j, i, -images)];
      // Of one size those in the skin come last; larger ones' smaller ghosts come after these.
      const bool further = distance(i, j, images) >= mine.radius[a] + mine.radius[b] + slack - skin;
      if (spread == 1) {
        EXPECT_TRUE(further || !in_skin[a]);
      }
      in_skin[a] = in_skin[a] || further;
    });
    std::set<BodyId> here(mine.id.begin(), mine.id.begin() + mine.owned);
    std::size_t expected = 0;
    for (BodyId i = 0; i < all.size(); ++i)
      for (BodyId j = i + 1; j < all.size(); ++j)
        for (int images : {-1, 0, 1}) {
          if (edge == 0 && images != 0) continue;
          if (distance(i, j, images) >= all.radius[i] + all.radius[j] + slack) continue;
          // On one rank a pair of images is found from either body's side.
          const int times = images != 0 ? here.count(i) + here.count(j)
                                        : static_cast<int>(here.count(i) || here.count(j));
          expected += times > 0;
          const auto at = found.find({i, j, images});
          EXPECT_EQ(at == found.end() ? 0 : at->second, times)
              << spread << ": " << i << " " << j << " " << images;
        }
    EXPECT_EQ(found.size(), expected);
  }
}

TEST(NearPairs, of_two_spacings_are_those_whose_grown_spheres_meet) {
  const Comm comm = testing_world();
  // Two balls of lattices, one half as wide as the other, side by side.
  const double wide = 0.4, radii = 1.7, skin = 0.15;
  Bodies all;
  for (const auto& [d, x0] : {std::pair(wide, 0.0), std::pair(wide / 2, 2.1)})
    for (int i = -6; i <= 6; ++i)
      for (int j = -6; j <= 6; ++j)
        for (int k = -6; k <= 6; ++k) {
          if ((i + j + k) % 2 != 0 || i * i + j * j + k * k > 20) continue;
          const Index b = all.size();
          resize(all, b + 1);
          all.id[b] = b;
          all.radius[b] = d / 2;
          all.position[b] = d / std::sqrt(2.0) * Vec3(i, j, k) + Vec3(x0, 0, 0);
        }
  all.owned = all.size();
  for (const double edge : {0.0, 6.0}) {
    Bodies mine = share(all, comm);
    NearPairs near;
    search_near_pairs(comm, mine, {.size = Vec3(edge, 0, 0)}, {2 * radii * wide / 2, radii}, skin,
                      {}, near);
    EXPECT_EQ(near.reach, radii * wide);
    PairSet found, listed;  // on one rank a pair of images is listed from either body's side
    for_each_pair(near.windows, [&](std::size_t, std::size_t, std::size_t, Index a, Index b) {
      const std::pair<BodyId, BodyId> pair = std::minmax(mine.id[a], mine.id[b]);
      found.insert(pair);
      EXPECT_TRUE(listed.insert(b < mine.owned ? pair : std::pair(mine.id[a], mine.id[b])).second)
          << "twice";
    });
    const std::set<BodyId> here(mine.id.begin(), mine.id.begin() + mine.owned);
    PairSet expected;
    for (Index i = 0; i < all.size(); ++i)
      for (Index j = i + 1; j < all.size(); ++j)
        if ((here.contains(i) || here.contains(j)) &&
            (all.position[j] - all.position[i]).norm() <
                radii * (all.radius[i] + all.radius[j]) + skin)
          expected.emplace(i, j);
    EXPECT_EQ(found, expected);
  }
}

/// Flies 300 bodies, all of them `faster` than they are, for 60 steps, looks for missed contacts in
/// each, and returns how often pairs were searched.
int fly(const Vec3& faster) {
  const Comm comm = testing_world();
  Bodies mine = share(random_bodies(300, 10), comm);
  for (Vec3& v : mine.velocity) v += faster;
  Neighbours neighbours;
  int searches = 0;
  const double h = 0.02;
  for (int step = 0; step < 60; ++step) {
    update_neighbours(comm, mine, {}, h, 0.0, neighbours);
    searches += neighbours.drifted == h * neighbours.drift;
    const Contacts contacts = find_contacts(mine, {}, {}, neighbours.pairs, h, ContactLaw{});
    // All bodies, in the order of ids, on every rank.
    std::vector<double> row;
    for (Index b = 0; b < mine.owned; ++b)
      row.insert(row.end(), {static_cast<double>(mine.id[b]), mine.position[b][0],
                             mine.position[b][1], mine.position[b][2], mine.velocity[b][0],
                             mine.velocity[b][1], mine.velocity[b][2], mine.radius[b]});
    const auto everything = comm.all_gather(std::span<const double>(row));
    std::map<BodyId, const double*> at;
    for (std::size_t k = 0; k < everything.size(); k += 8)
      at[static_cast<BodyId>(everything[k])] = &everything[k];
    PairSet found;
    for (Index c = 0; c < contacts.size(); ++c)
      found.emplace(mine.id[contacts.i[c]], mine.id[contacts.j[c]]);
    std::set<BodyId> here(mine.id.begin(), mine.id.begin() + mine.owned);
    for (const auto& [i, a] : at)
      for (const auto& [j, b] : at) {
        if (i >= j || (!here.count(i) && !here.count(j))) continue;
        const Vec3 apart = Vec3(b[1], b[2], b[3]) - Vec3(a[1], a[2], a[3]);
        const double closing =
            -(Vec3(b[4], b[5], b[6]) - Vec3(a[4], a[5], a[6])).dot(apart.normalized());
        if (apart.norm() - a[7] - b[7] < h * std::max(closing, 0.0)) {
          EXPECT_TRUE(found.count({i, j})) << "step " << step << ": " << i << " " << j;
        }
      }
    for (Index b = 0; b < mine.size(); ++b) mine.position[b] += h * mine.velocity[b];
  }
  return searches;
}

TEST(Neighbours, no_contact_is_missed_while_bodies_fly) {
  const int searches = fly(Vec3::Zero());
  EXPECT_LT(searches, 60);
  EXPECT_NEAR(fly({300, -200, 100}), searches, 1) << "motion that all share is no reason to search";
}

TEST(Neighbours, impulses_stay_with_their_pairs_over_cuts) {
  const Comm comm = testing_world();
  Bodies mine = share(random_bodies(300, 10), comm);
  Neighbours neighbours;
  update_neighbours(comm, mine, {}, 0.01, 0.1, neighbours);
  auto value = [&](Index p) {
    const double i = static_cast<double>(mine.id[neighbours.pairs.i[p]]);
    const double j = static_cast<double>(mine.id[neighbours.pairs.j[p]]);
    return Vec3(1 + i, 1 + j, i * j);
  };
  for (Index p = 0; p < neighbours.pairs.size(); ++p)
    neighbours.pairs.carried.push_back({.pair = p, .impulse = value(p)});
  neighbours.valid = false;
  neighbours.last_cut = {};  // asks for a cut
  update_neighbours(comm, mine, {}, 0.01, 0.1, neighbours);
  ASSERT_GT(comm.sum(static_cast<std::int64_t>(neighbours.pairs.size())), 0);
  ASSERT_EQ(std::ssize(neighbours.pairs.carried), neighbours.pairs.size());
  for (Index p = 0; p < neighbours.pairs.size(); ++p) {
    EXPECT_EQ(neighbours.pairs.carried[p].pair, p);
    EXPECT_EQ(neighbours.pairs.carried[p].impulse, value(p));
  }
}

TEST(MotionCells, keys_around_a_cell_are_those_of_its_neighbours) {
  for (const Vec3& x : {Vec3(0.3, -0.2, 0.1), Vec3(-5.5, 7.9, -0.01), Vec3(1e3, -1e3, 64)}) {
    std::set<std::uint64_t> expected;
    for (int n = 0; n < 27; ++n)
      expected.insert(morton_key(x + 0.5 * Vec3(n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1), 0.5));
    const auto keys = keys_around(morton_key(x, 0.5));
    EXPECT_EQ(std::set<std::uint64_t>(keys.begin(), keys.end()), expected);
    EXPECT_EQ(expected.size(), 27u);
  }
}

/// Of a body by its id and place.
using Motion = std::function<Vec3(Index, const Vec3&)>;

std::vector<Vec3> of_owned(const Bodies& mine, const Motion& motion) {
  std::vector<Vec3> vectors;
  for (Index b = 0; b < mine.owned; ++b)
    vectors.push_back(motion(static_cast<Index>(mine.id[b]), mine.position[b]));
  return vectors;
}

TEST(MotionCells, they_know_how_near_bodies_come) {
  const Comm comm = testing_world();
  constexpr double range = 1, edge = 3;
  Bodies all = random_bodies(600);
  for (Index b = 0; b < all.size(); ++b)  // a cloud, and some far from it
    all.position[b] = b < 500 ? Vec3(2 * all.position[b])
                              : Vec3(3 * all.position[b] + Vec3::Constant(10 * (b % 4)));
  const Bodies mine = share(all, comm);
  const MotionCells cells(comm, std::span(mine.position.data(), mine.owned), edge);
  const auto noise = [](Index b) { return Vec3(std::sin(b), std::sin(3 * b), std::cos(7 * b)); };
  const std::pair<const char*, Motion> motions[] = {
      {"none", [](Index, const Vec3&) { return Vec3(0, 0, 0); }},
      {"together", [](Index, const Vec3&) { return Vec3(50, -70, 3); }},
      {"apart", [](Index, const Vec3& x) { return Vec3(0.01 * x); }},
      {"shear", [](Index, const Vec3& x) { return Vec3(0.1 * x[1], 0, 0); }},
      {"noise", [&](Index b, const Vec3&) { return Vec3(0.1 * noise(b)); }},
      {"bullet",
       [](Index b, const Vec3& x) { return b == 5 ? Vec3(8 - x[0], 0, 0) : Vec3(0, 0, 0); }},
      {"distant groups", [](Index b, const Vec3&) { return Vec3(b < 500 ? 0.5 : 0, 0, 0); }},
      {"every other", [](Index b, const Vec3&) { return Vec3(0, 0.3 * (b % 2), 0); }},
      {"every rank", [&](Index b, const Vec3&) { return Vec3(0, 0, 0.2 * (b % comm.size)); }}};
  std::map<std::string, double> bound;
  for (const auto& [name, motion] : motions) {
    bound[name] = cells.approach(comm, range, of_owned(mine, motion));
    double nearest = infinity;
    for (Index a = 0; a < all.size(); ++a)
      for (Index b = a + 1; b < all.size(); ++b) {
        const Vec3 apart = all.position[b] - all.position[a];
        if (apart.norm() < range) continue;
        const Vec3 moved = motion(b, all.position[b]) - motion(a, all.position[a]);
        nearest = std::min(nearest, (apart + moved).norm());
      }
    EXPECT_GE(nearest, range - bound[name] - 1e-12) << name;
  }
  EXPECT_LE(bound["none"], 0.0);
  EXPECT_LE(bound["together"], 1e-12);
  EXPECT_LE(bound["apart"], 0.01 * 2 * std::sqrt(3) * edge);  // however large the cloud
  EXPECT_LE(bound["noise"], 0.1 * 3 * std::sqrt(3));
  EXPECT_LE(bound["distant groups"], 0.5 + 1e-12);
}

TEST(MotionCells, they_know_at_what_speed_bodies_meet) {
  const Comm comm = testing_world();
  constexpr double range = 1, edge = 3;
  Bodies all = random_bodies(400);
  for (Vec3& x : all.position) x = 6 * x - Vec3::Constant(30);
  const Bodies mine = share(all, comm);
  const std::span places(mine.position.data(), mine.owned);
  const MotionCells cells(comm, places, edge);
  const auto bound = [&](const Motion& motion) {
    const double found = cells.closing_speed(comm, places, of_owned(mine, motion));
    EXPECT_GE(cells.closing_speed(comm, places, of_owned(mine, motion), 8), (1 - 1e-12) * found);
    double fastest = 0;
    for (Index a = 0; a < all.size(); ++a)
      for (Index b = a + 1; b < all.size(); ++b) {
        const Vec3 x = all.position[b] - all.position[a];
        const Vec3 v = motion(b, all.position[b]) - motion(a, all.position[a]);
        const double later = std::max(0.0, -x.dot(v) / std::max(v.squaredNorm(), 1e-300));
        if ((x + later * v).norm() < range && x.dot(v) < 0) fastest = std::max(fastest, v.norm());
      }
    EXPECT_GE(found, (1 - 1e-12) * fastest);
    return found;
  };
  const Vec3 way = (all.position[300] - all.position[5]).normalized();
  EXPECT_NEAR(bound([&](Index b, const Vec3&) { return Vec3(b == 5 ? 7 * way : Vec3(0, 0, 0)); }),
              7, 1e-12);
  EXPECT_LE(bound([](Index, const Vec3&) { return Vec3(50, -70, 3); }), 1e-12);
  // Neighbours in cells as wide as 3 may not be known to part, all others are.
  EXPECT_LE(bound([](Index, const Vec3& x) { return x; }), 18);
  EXPECT_GE(bound([](Index, const Vec3& x) { return Vec3(-x); }), 50);
  bound([](Index b, const Vec3&) { return Vec3(std::sin(b), std::sin(3 * b), std::cos(7 * b)); });
  bound([](Index, const Vec3& x) { return Vec3(x[1], 0, 0); });
  bound([&](Index b, const Vec3&) { return Vec3(0, b % comm.size, 0); });
}

}  // namespace
}  // namespace spall
