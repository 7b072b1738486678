// Planes by bisection; or METIS, for which every rank holds the whole graph of coarse cells.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/partition.hpp"

#include <metis.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>
#include <set>

#include "base/reduce.hpp"
#include "domain/bisection.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr double cells_a_rank = 64;
constexpr std::int64_t most_cells_a_rank = 512;
constexpr double ghost_limit = 1.5;       // beyond it the bodies of two ranks have mixed
constexpr int longest_without_cut = 100;  // searches: bodies' order in memory ages as they move

using CellIndex = std::array<std::int64_t, 3>;

struct Cell {
  double work = 0;
  std::map<int, double> work_on;  // by the rank that owns it now
};

std::vector<CellIndex> cells_of(const Bodies& bodies, double edge) {
  std::vector<CellIndex> cell(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b)
    for (int k = 0; k < 3; ++k)
      cell[b][k] = static_cast<std::int64_t>(std::floor(bodies.position[b][k] / edge));
  return cell;
}

/// How many different cells the bodies of all ranks are in, whoever owns them.
std::int64_t count_cells(const Comm& comm, const std::vector<CellIndex>& cell) {
  const std::set<CellIndex> mine(cell.begin(), cell.end());
  ByRank<std::int64_t> outgoing;
  for (const auto& index : mine) {
    // Any rule will do by which all ranks send a cell to the same one.
    const auto mixed = static_cast<std::uint64_t>(index[0] + 31 * index[1] + 1009 * index[2]);
    auto& row = outgoing[static_cast<int>(mixed % comm.size)];
    row.insert(row.end(), index.begin(), index.end());
  }
  std::set<CellIndex> here;
  for (const auto& [rank, row] : comm.exchange(std::move(outgoing)))
    for (std::size_t k = 0; k < row.size(); k += 3) here.insert({row[k], row[k + 1], row[k + 2]});
  return comm.sum(static_cast<std::int64_t>(here.size()));
}

/// The cell of each owned body. Cells are as wide as `cells_a_rank` cells a rank are at the density
/// of a pile; in a dilute cloud, where they would hold a body each and have no neighbours, wider by
/// powers of two until they are few.
std::vector<CellIndex> choose_cells(const Comm& comm, const Bodies& bodies) {
  std::array<double, 2> sums{static_cast<double>(bodies.owned), 0};
  for (Index b = 0; b < bodies.owned; ++b) sums[1] += bodies.radius[b];
  comm.sum(sums);
  const double bodies_a_cell = std::max(1.0, sums[0] / (cells_a_rank * comm.size));
  for (double edge = 2 * sums[1] / sums[0] * std::cbrt(bodies_a_cell);; edge *= 2) {
    auto cell = cells_of(bodies, edge);
    if (count_cells(comm, cell) <= most_cells_a_rank * comm.size) return cell;
  }
}

/// All occupied cells with their work, the same on every rank.
std::map<CellIndex, Cell> gather_cells(const Comm& comm, const std::vector<CellIndex>& cell_of,
                                       std::span<const double> work) {
  std::map<CellIndex, double> mine;
  for (std::size_t b = 0; b < cell_of.size(); ++b) mine[cell_of[b]] += work[b];
  std::vector<double> packed;
  for (const auto& [cell, sum] : mine)
    packed.insert(packed.end(),
                  {static_cast<double>(cell[0]), static_cast<double>(cell[1]),
                   static_cast<double>(cell[2]), sum, static_cast<double>(comm.rank)});
  const auto all = comm.all_gather(std::span<const double>(packed));
  std::map<CellIndex, Cell> cells;
  for (std::size_t k = 0; k + 4 < all.size(); k += 5) {
    Cell& cell = cells[{std::llround(all[k]), std::llround(all[k + 1]), std::llround(all[k + 2])}];
    cell.work += all[k + 3];
    cell.work_on[static_cast<int>(all[k + 4])] += all[k + 3];
  }
  return cells;
}

/// METIS's cut of the graph of neighbouring cells into `parts`.
std::vector<idx_t> cut(const std::map<CellIndex, Cell>& cells, idx_t parts) {
  std::map<CellIndex, idx_t> number;
  for (const auto& [index, cell] : cells) number.emplace(index, static_cast<idx_t>(number.size()));
  double largest = 0;
  for (const auto& [index, cell] : cells) largest = std::max(largest, cell.work);
  auto weight = [&](double work) {
    return static_cast<idx_t>(1 + std::llround(1e4 * work / std::max(largest, 1e-300)));
  };
  std::vector<idx_t> start{0}, neighbour, vertex_weight, edge_weight;
  for (const auto& [index, cell] : cells) {
    for (int k = 0; k < 27; ++k) {
      const CellIndex other{index[0] + k % 3 - 1, index[1] + k / 3 % 3 - 1, index[2] + k / 9 - 1};
      const auto found = k == 13 ? number.end() : number.find(other);
      if (found == number.end()) continue;
      neighbour.push_back(found->second);
      // Cells that share a face exchange far more ghosts than those that share a corner.
      const int apart = (k % 3 != 1) + (k / 3 % 3 != 1) + (k / 9 != 1);
      const double across = std::min(cell.work, cells.at(other).work);
      edge_weight.push_back(weight(across) / (apart == 1 ? 1 : apart == 2 ? 4 : 16) + 1);
    }
    start.push_back(static_cast<idx_t>(neighbour.size()));
    vertex_weight.push_back(weight(cell.work));
  }
  idx_t count = static_cast<idx_t>(cells.size()), constraints = 1, cut_weight = 0;
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_UFACTOR] = 20;  // parts within 2 % of the mean
  std::vector<idx_t> part(cells.size(), 0);
  const int status = METIS_PartGraphRecursive(
      &count, &constraints, start.data(), neighbour.data(), vertex_weight.data(), nullptr,
      edge_weight.data(), &parts, nullptr, nullptr, options, &cut_weight, part.data());
  require(status == METIS_OK, "METIS_PartGraphRecursive failed with code {}", status);
  return part;
}

/// A rank for each part: the heaviest overlaps of parts with their present owners first.
std::vector<int> keep_owners(const std::map<CellIndex, Cell>& cells, const std::vector<idx_t>& part,
                             int ranks) {
  std::map<std::array<int, 2>, double> overlap;  // of (part, rank), where there is any
  std::size_t k = 0;
  for (const auto& [index, cell] : cells) {
    for (const auto& [rank, work] : cell.work_on)
      overlap[{static_cast<int>(part[k]), rank}] += work;
    ++k;
  }
  std::vector<std::pair<std::array<int, 2>, double>> choices(overlap.begin(), overlap.end());
  std::ranges::stable_sort(choices, std::ranges::greater{}, &decltype(choices)::value_type::second);
  std::vector<int> owner(ranks, -1);
  std::vector<bool> taken(ranks, false);
  for (const auto& [choice, work] : choices) {
    const auto& [p, r] = choice;
    if (owner[p] >= 0 || taken[r]) continue;
    owner[p] = r;
    taken[r] = true;
  }
  int next = 0;  // what nobody has yet goes to those that have none
  for (int& r : owner) {
    if (r >= 0) continue;
    while (taken[next]) ++next;
    r = next++;
  }
  return owner;
}

/// Too few cells to cut (a handful of bodies): equal numbers of bodies by id.
std::vector<int> deal(const Comm& comm, const Bodies& bodies) {
  std::vector<std::int64_t> mine(bodies.id.begin(), bodies.id.begin() + bodies.owned);
  auto ids = comm.all_gather(std::span<const std::int64_t>(mine));
  std::sort(ids.begin(), ids.end());
  std::vector<int> owner(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b) {
    const auto place = std::lower_bound(ids.begin(), ids.end(), bodies.id[b]) - ids.begin();
    owner[b] = static_cast<int>(place * comm.size / static_cast<std::int64_t>(ids.size()));
  }
  return owner;
}

double sum(std::span<const double> work) {
  return std::accumulate(work.begin(), work.end(), 0.0);
}

double imbalance(int ranks, double most, double total) {
  return total > 0 ? most * ranks / total : 1;
}

}  // namespace

std::vector<int> partition(const Comm& comm, const Bodies& bodies, std::span<const double> work,
                           Cut by) {
  if (comm.size == 1) return std::vector<int>(bodies.owned, 0);
  if (by == Cut::bisection) return bisect(comm, bodies, work);
  const auto cell_of = choose_cells(comm, bodies);
  const auto cells = gather_cells(comm, cell_of, work);
  if (cells.size() < 4 * static_cast<std::size_t>(comm.size)) return deal(comm, bodies);
  const auto part = cut(cells, comm.size);
  const auto owner_of_part = keep_owners(cells, part, comm.size);
  std::map<CellIndex, int> owner_of_cell;
  for (const auto& [index, cell] : cells)
    owner_of_cell.emplace(index, owner_of_part[part[owner_of_cell.size()]]);
  std::vector<int> owner(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b) owner[b] = owner_of_cell.at(cell_of[b]);
  return owner;
}

double imbalance(const Comm& comm, double work) {
  double total = work, most = work;
  reduce(comm, {&total, 1}, {&most, 1});
  return imbalance(comm.size, most, total);
}

bool needs_cut(const Comm& comm, std::span<const double> work, const Ghosts& ghosts,
               const LastCut& last) {
  const bool mixed = ghosts.ghosts() > ghost_limit * last.ghosts + 0.1 * ghosts.owned();
  double total = sum(work);
  std::array<double, 2> most{total, mixed ? 1.0 : 0.0};
  reduce(comm, {&total, 1}, most);
  const double now = imbalance(comm.size, most[0], total);
  return last.imbalance == 0 || now > imbalance_limit * last.imbalance || most[1] > 0 ||
         last.searches >= longest_without_cut;
}

void book_search(const Comm& comm, bool cut, std::span<const double> work, const Ghosts& ghosts,
                 LastCut& last) {
  ++last.searches;
  if (!cut) return;
  // The first cut knows bodies only; its pairs may call for a second one.
  const bool first = last.imbalance == 0;
  last = {first ? 1 : imbalance(comm, sum(work)), ghosts.ghosts(), 0};
}

}  // namespace spall
