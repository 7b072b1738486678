// Many ranks are cut into groups, which get the keys of their bodies and cut their part alike.
// SPDX-License-Identifier: BSD-3-Clause
#include "gravity/curve_parts.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "base/rank_blocks.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

constexpr int most_at_once = 32;  // ranks that are dealt to: each then gets its share to 1/32
constexpr int group_count = 16;   // of more ranks: each gets its share to 1/64

struct Group {
  RankBlock ranks;
  std::uint64_t begin = key_end, end = key_end;
};

/// Groups of `ranks` ranks, of one each where they are few.
std::vector<Group> deal_out(int ranks, std::span<const Stretch> all) {
  const int count = ranks <= most_at_once ? ranks : group_count;
  std::vector<Group> groups(count);
  for (int k = 0; k < count; ++k) {
    const auto first = static_cast<int>(part_begin(ranks, k, count));
    groups[k].ranks = {first, static_cast<int>(part_begin(ranks, k + 1, count)) - first};
  }
  double before = 0;
  std::size_t next = 0;
  const auto deal = [&](auto&& self, Index s) -> void {
    if (all[s].children[0] != Cell::none) {
      for (Index child : all[s].children) self(self, child);
      return;
    }
    const double middle = before + all[s].bodies / 2;
    before += all[s].bodies;
    while (next < groups.size() && groups[next].ranks.first * all[0].bodies <= middle * ranks)
      groups[next++].begin = all[s].low;
  };
  deal(deal, 0);
  groups[0].begin = 0;
  for (int k = 1; k < count; ++k) groups[k - 1].end = groups[k].begin;
  return groups;
}

std::span<const KeyedRow> rows_in(std::span<const KeyedRow> rows, std::uint64_t begin,
                                  std::uint64_t end) {
  const std::size_t first = first_at(rows, begin);
  return rows.subspan(first, first_at(rows, end) - first);
}

std::vector<Stretch> divide_among(const Comm& comm, std::span<const KeyedRow> rows, int leaf_size) {
  const double bodies = comm.sum(static_cast<double>(rows.size()));
  return divide_curve(comm, rows, bodies, leaf_size);
}

/// Parts that a group has found for itself are within its own.
void confine(std::vector<CurvePart>& parts, const Group& group) {
  for (CurvePart& part : parts) {
    part.begin = std::clamp(part.begin, group.begin, group.end);
    part.end = std::clamp(part.end, group.begin, group.end);
  }
}

struct SubComm {
  Comm comm;
  SubComm(const Comm& all, const RankBlock& ranks) {
    MPI_Group everyone = MPI_GROUP_NULL, some = MPI_GROUP_NULL;
    MPI_Comm raw = MPI_COMM_NULL;
    int range[1][3] = {{ranks.first, ranks.first + ranks.count - 1, 1}};
    check_mpi(MPI_Comm_group(all.raw, &everyone), "MPI_Comm_group");
    check_mpi(MPI_Group_range_incl(everyone, 1, range, &some), "MPI_Group_range_incl");
    check_mpi(MPI_Comm_create_group(all.raw, some, 0, &raw), "MPI_Comm_create_group");
    MPI_Group_free(&some);
    MPI_Group_free(&everyone);
    comm = Comm(raw);
  }
  ~SubComm() { MPI_Comm_free(&comm.raw); }
  SubComm(const SubComm&) = delete;
  SubComm& operator=(const SubComm&) = delete;
};

}  // namespace

std::vector<CurvePart> find_parts(const Comm& comm, std::span<const KeyedRow> rows,
                                  std::span<const Stretch> stretches, int leaf_size) {
  const std::vector<Group> groups = deal_out(comm.size, stretches);
  std::vector<CurvePart> parts;
  if (comm.size <= most_at_once) {
    for (const Group& group : groups) parts.push_back({group.begin, group.end, group.ranks.first});
    return parts;
  }

  // Each group learns of its bodies: a rank of it from about one rank elsewhere.
  ByRank<std::int64_t> keys;
  for (const Group& group : groups)
    for (const KeyedRow& row : rows_in(rows, group.begin, group.end))
      keys[group.ranks.partner_of(comm.rank)].push_back(static_cast<std::int64_t>(row.key));
  keys = comm.exchange(std::move(keys));
  std::vector<KeyedRow> told;
  for (const auto& [rank, row] : keys)
    for (std::int64_t key : row) told.push_back({static_cast<std::uint64_t>(key), 0});
  sort_by_key(told);

  const Group& own =
      *std::ranges::find_if(groups, [&](const Group& g) { return g.ranks.has(comm.rank); });
  {
    const SubComm members(comm, own.ranks);
    parts = find_parts(members.comm, told, divide_among(members.comm, told, leaf_size), leaf_size);
  }
  for (CurvePart& part : parts) part.rank += own.ranks.first;
  confine(parts, own);

  // It tells back whose they are.
  ByRank<std::int64_t> answers;
  for (const auto& [rank, row] : keys)
    for (const CurvePart& part : parts) {
      const auto key = std::ranges::lower_bound(row, static_cast<std::int64_t>(part.begin));
      if (key != row.end() && static_cast<std::uint64_t>(*key) < part.end)
        for (std::uint64_t value : {static_cast<std::uint64_t>(part.rank), part.begin, part.end})
          answers[rank].push_back(static_cast<std::int64_t>(value));
    }
  std::map<int, CurvePart> known;
  for (const CurvePart& part : parts) known[part.rank] = part;
  for (const auto& [rank, row] : comm.exchange(std::move(answers)))
    for (std::size_t at = 0; at < row.size(); at += 3)
      known[static_cast<int>(row[at])] = {static_cast<std::uint64_t>(row[at + 1]),
                                          static_cast<std::uint64_t>(row[at + 2]),
                                          static_cast<int>(row[at])};
  parts.clear();
  for (const auto& [rank, part] : known) parts.push_back(part);
  return parts;
}

namespace {

/// Messages of the ranks `holder` of the rows to their partners in a group, and back.
void count_messages(std::span<const KeyedRow> rows, std::span<const int> holder,
                    std::span<const int> partner, const std::vector<CurvePart>& parts,
                    std::vector<Traffic>& sent) {
  struct Told {
    std::int64_t keys = 0, parts = 0;
    const CurvePart* last = nullptr;
    int partner = 0;
  };
  std::map<int, Told> by_holder;
  auto part = parts.begin();
  for (std::size_t k = 0; k < rows.size(); ++k) {
    while (rows[k].key >= part->end) ++part;
    Told& told = by_holder[holder[k]];
    ++told.keys;
    told.parts += told.last != &*part;
    told.last = &*part;
    told.partner = partner[k];
  }
  for (const auto& [rank, told] : by_holder) {
    if (told.partner == rank) continue;
    ++sent[rank].messages;
    ++sent[told.partner].messages;
    sent[rank].bytes += told.keys * static_cast<std::int64_t>(sizeof(std::int64_t));
    sent[told.partner].bytes += told.parts * static_cast<std::int64_t>(3 * sizeof(std::int64_t));
  }
}

std::vector<CurvePart> foretell(const Comm& alone, std::span<const KeyedRow> rows,
                                std::span<const Stretch> stretches, int leaf_size,
                                const RankBlock& ranks, std::span<const int> holder,
                                std::vector<Traffic>& sent) {
  std::vector<CurvePart> parts;
  for (const Group& group : deal_out(ranks.count, stretches)) {
    const RankBlock members{ranks.first + group.ranks.first, group.ranks.count};
    if (ranks.count <= most_at_once) {
      parts.push_back({group.begin, group.end, members.first});
      continue;
    }
    const auto held = rows_in(rows, group.begin, group.end);
    const auto from = holder.subspan(held.data() - rows.data(), held.size());
    std::vector<int> partner;
    for (int rank : from) partner.push_back(members.partner_of(rank - ranks.first));
    const Traffic before = std::exchange(traffic(), {});
    std::vector<CurvePart> inner = foretell(alone, held, divide_among(alone, held, leaf_size),
                                            leaf_size, members, partner, sent);
    const Traffic of_group = std::exchange(traffic(), before);
    for (int rank = members.first; rank < members.first + members.count; ++rank) {
      sent[rank].add(of_group);
      sent[rank].collectives += 2;  // exchanges
    }
    confine(inner, group);
    count_messages(held, from, partner, inner, sent);
    parts.insert(parts.end(), inner.begin(), inner.end());
  }
  return parts;
}

}  // namespace

std::vector<CurvePart> foretell_parts(const Comm& alone, std::span<const KeyedRow> rows,
                                      std::span<const Stretch> stretches, int leaf_size,
                                      PlannedRanks& ranks) {
  std::vector<int> holder;
  for (const KeyedRow& row : rows) holder.push_back(ranks.owner[row.row]);
  return foretell(alone, rows, stretches, leaf_size, {0, static_cast<int>(ranks.sent.size())},
                  holder, ranks.sent);
}

}  // namespace spall
