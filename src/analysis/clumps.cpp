// Union-find on each rank, then the smallest id wanders across the boundaries until it rests.
// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/clumps.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace spall {

namespace {

/// Root of a row's tree; halves the path on the way.
Index root(std::vector<Index>& parent, Index b) {
  while (parent[b] != b) b = parent[b] = parent[parent[b]];
  return b;
}

/// Count, mass and first moments of one clump, as they travel between ranks.
using Sums = std::array<double, 8>;

void add(Sums& sums, const Sums& more) {
  for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += more[k];
}

Sums sums_of(const Bodies& bodies, Index b) {
  const double m = bodies.mass[b];
  const Vec3 x = m * bodies.position[b], v = m * bodies.velocity[b];
  return {1, m, x[0], x[1], x[2], v[0], v[1], v[2]};
}

Clump clump_of(BodyId name, const Sums& s) {
  return {name, static_cast<std::int64_t>(s[0]), s[1], Vec3(s[2], s[3], s[4]) / s[1],
          Vec3(s[5], s[6], s[7]) / s[1]};
}

/// Rows (name, sums…) as doubles: ids stay below 2^53.
void pack(std::vector<double>& rows, BodyId name, const Sums& sums) {
  rows.push_back(static_cast<double>(name));
  rows.insert(rows.end(), sums.begin(), sums.end());
}

template <class F>
void for_each_packed(const std::vector<double>& rows, F&& f) {
  Sums sums;
  for (std::size_t at = 0; at < rows.size(); at += 1 + sums.size()) {
    std::copy_n(rows.begin() + at + 1, sums.size(), sums.begin());
    f(static_cast<BodyId>(rows[at]), sums);
  }
}

}  // namespace

std::vector<BodyId> find_clumps(const Comm& comm, const Ghosts& ghosts, const Bodies& bodies,
                                const Links& links) {
  std::vector<Index> parent(bodies.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t k = 0; k < links.i.size(); ++k) {
    const Index a = root(parent, links.i[k]), b = root(parent, links.j[k]);
    parent[std::max(a, b)] = std::min(a, b);
  }
  // A tree takes the smallest name of its rows, ghosts take their owner's: names only fall, so this
  // ends, after as many rounds as the longest chain crosses boundaries.
  std::vector<double> name(bodies.id.begin(), bodies.id.end());
  for (bool changed = true; comm.any(changed);) {
    changed = false;
    ghosts.gather(name.data(), 1);
    for (Index b = 0; b < bodies.size(); ++b) {
      double& tree = name[root(parent, b)];
      tree = std::min(tree, name[b]);
    }
    for (Index b = 0; b < bodies.size(); ++b) {
      const double tree = name[root(parent, b)];
      changed |= tree < name[b];
      name[b] = tree;
    }
  }
  return {name.begin(), name.end()};
}

namespace {

/// Each clump is summed on one rank, in the order of ranks: the same bits on a repeated run.
std::map<BodyId, Sums> sums_of_share(const Comm& comm, const Bodies& bodies,
                                     std::span<const BodyId> name) {
  std::map<BodyId, Sums> mine;
  for (Index b = 0; b < bodies.owned; ++b)
    if (name[b] >= 0) add(mine[name[b]], sums_of(bodies, b));
  ByRank<double> outgoing;
  for (const auto& [clump, sums] : mine)
    pack(outgoing[static_cast<int>(clump % comm.size)], clump, sums);
  std::map<BodyId, Sums> share;
  for (const auto& [rank, rows] : comm.exchange(std::move(outgoing)))
    for_each_packed(rows, [&](BodyId clump, const Sums& sums) { add(share[clump], sums); });
  return share;
}

}  // namespace

std::vector<Clump> share_of_clumps(const Comm& comm, const Bodies& bodies,
                                   std::span<const BodyId> name) {
  std::vector<Clump> clumps;
  for (const auto& [clump, sums] : sums_of_share(comm, bodies, name))
    clumps.push_back(clump_of(clump, sums));
  return clumps;
}

std::vector<Clump> heaviest_clumps(const Comm& comm, const Bodies& bodies,
                                   std::span<const BodyId> name, std::size_t listed) {
  const std::map<BodyId, Sums> share = sums_of_share(comm, bodies, name);

  // Only the heaviest of each rank can be among the heaviest of all.
  const auto heavier = [](const auto& a, const auto& b) {
    return a.second[1] != b.second[1] ? a.second[1] > b.second[1] : a.first < b.first;
  };
  std::vector<std::pair<BodyId, Sums>> order(share.begin(), share.end());
  std::sort(order.begin(), order.end(), heavier);
  std::vector<double> rows;
  for (std::size_t k = 0; k < std::min(listed, order.size()); ++k)
    pack(rows, order[k].first, order[k].second);
  order.clear();
  for_each_packed(comm.all_gather(rows),
                  [&](BodyId clump, const Sums& sums) { order.emplace_back(clump, sums); });
  std::sort(order.begin(), order.end(), heavier);

  std::vector<Clump> heaviest;
  for (std::size_t k = 0; k < std::min(listed, order.size()); ++k)
    heaviest.push_back(clump_of(order[k].first, order[k].second));
  return heaviest;
}

bool is_bound(const Vec3& position, const Vec3& velocity, double mass, const Clump& clump,
              double gravity_constant) {
  const double energy = 0.5 * (velocity - clump.velocity).squaredNorm();
  const double distance = (position - clump.position).norm();
  return energy * distance < gravity_constant * (clump.mass + mass);
}

Clump add_bound_bodies(const Comm& comm, const Bodies& bodies, double gravity_constant,
                       const Clump& clump, std::span<BodyId> name) {
  Clump whole = clump;
  for (bool grew = true; comm.any(grew);) {
    grew = false;
    Sums sums{};
    for (Index b = 0; b < bodies.owned; ++b) {
      if (name[b] >= 0 && name[b] != whole.name) {
        const bool joins = is_bound(bodies.position[b], bodies.velocity[b], bodies.mass[b], whole,
                                    gravity_constant);
        if (joins) name[b] = whole.name;
        grew |= joins;
      }
      if (name[b] == whole.name) add(sums, sums_of(bodies, b));
    }
    comm.sum(sums);
    whole = clump_of(whole.name, sums);
  }
  return whole;
}

}  // namespace spall
