// Rows travel as doubles with the bits of whatever they hold.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/migration.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "base/let_go.hpp"
#include "base/morton.hpp"
#include "spall/error.hpp"
#include "state/pack.hpp"
#include "state/rows_of_ids.hpp"

namespace spall {
namespace {

/// Where each of `wanted` goes, from a directory in which rank (id mod ranks) keeps what becomes of
/// the body `id`.
std::unordered_map<BodyId, int> find_owners(const Comm& comm, const Bodies& bodies,
                                            const std::vector<int>& owner,
                                            const std::vector<BodyId>& wanted) {
  if (!comm.any(!wanted.empty())) return {};
  const auto keeper = [&](BodyId id) { return static_cast<int>(id % comm.size); };
  ByRank<std::int64_t> mine;
  for (Index b = 0; b < bodies.owned; ++b) {
    auto& known = mine[keeper(bodies.id[b])];
    known.insert(known.end(), {bodies.id[b], owner[b]});
  }
  std::unordered_map<BodyId, int> directory;
  for (const auto& [rank, known] : comm.exchange(std::move(mine)))
    for (std::size_t k = 0; k < known.size(); k += 2)
      directory[known[k]] = static_cast<int>(known[k + 1]);

  ByRank<std::int64_t> questions, answers;
  for (BodyId id : wanted) questions[keeper(id)].push_back(id);
  for (const auto& [rank, ids] : comm.exchange(questions))
    for (BodyId id : ids) answers[rank].push_back(directory.at(id));
  std::unordered_map<BodyId, int> owners;
  for (const auto& [rank, answered] : comm.exchange(std::move(answers)))
    for (std::size_t k = 0; k < answered.size(); ++k)
      owners[questions[rank][k]] = static_cast<int>(answered[k]);
  return owners;
}

/// What goes to each rank: to those of both bodies. `named`: entries tell which spheres touch.
ByRank<double> pack_memory(const Comm& comm, const Bodies& bodies, const ContactMemory& memory,
                           const std::vector<int>& owner, bool named) {
  const RowsOfIds rows(bodies, static_cast<Index>(owner.size()));
  std::vector<BodyId> unknown;
  for (const auto* ids : {&memory.i, &memory.j})
    for (BodyId id : *ids)
      if (id >= 0 && rows.find(id) < 0) unknown.push_back(id);
  std::sort(unknown.begin(), unknown.end());
  unknown.erase(std::unique(unknown.begin(), unknown.end()), unknown.end());
  const auto owners = find_owners(comm, bodies, owner, unknown);
  const auto goes_to = [&](BodyId id) {
    const Index row = rows.find(id);
    return row >= 0 ? owner[row] : owners.at(id);
  };

  ByRank<double> outgoing;
  for (std::size_t c = 0; c < memory.i.size(); ++c) {
    const int first = goes_to(memory.i[c]);
    const int second = memory.j[c] < 0 ? first : goes_to(memory.j[c]);
    for (int rank : {first, second}) {
      auto& row = outgoing[rank];
      row.push_back(std::bit_cast<double>(memory.i[c]));
      row.push_back(std::bit_cast<double>(memory.j[c]));
      for (const Vec3& v : {memory.impulse[c], memory.rolling_of(c)})
        row.insert(row.end(), v.data(), v.data() + 3);
      if (named) row.push_back(std::bit_cast<double>(memory.spheres_of(c)));
      if (second == first) break;
    }
  }
  return outgoing;
}

ContactMemory unpack_memory(const ByRank<double>& incoming, bool named) {
  ContactMemory memory;
  for (const auto& [rank, row] : incoming)
    for (std::size_t k = 0; k < row.size(); k += named ? 9 : 8) {
      memory.add(std::bit_cast<BodyId>(row[k]), std::bit_cast<BodyId>(row[k + 1]),
                 {row[k + 2], row[k + 3], row[k + 4]}, {row[k + 5], row[k + 6], row[k + 7]});
      if (named) memory.name_spheres(std::bit_cast<std::array<std::int32_t, 2>>(row[k + 8]));
    }
  return memory;
}

}  // namespace

void sort_bodies(const Comm& comm, Bodies& bodies) {
  resize(bodies, bodies.owned);
  double sum = 0;
  for (double r : bodies.radius) sum += r;
  const double count = comm.sum(static_cast<double>(bodies.owned));
  const double edge = 2 * comm.sum(sum) / count;
  std::vector<std::uint64_t> key(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b) key[b] = morton_key(bodies.position[b], edge);
  std::vector<Index> order(bodies.owned);
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](Index a, Index b) {
    return key[a] != key[b] ? key[a] < key[b] : bodies.id[a] < bodies.id[b];
  });
  for_each_field(bodies, [&](const auto&, auto& field) {
    auto sorted = field;
    for (Index b = 0; b < bodies.owned; ++b) sorted[b] = field[order[b]];
    field.swap(sorted);
  });
}

void migrate(const Comm& comm, Bodies& bodies, SharedContacts& memory,
             const std::vector<int>& owner) {
  const bool named = bodies.has(Field::shape) && comm.any(!memory->spheres.empty());
  ByRank<double> remembered = pack_memory(comm, bodies, memory, owner, named);
  memory = {};
  memory = unpack_memory(comm.exchange(std::move(remembered)), named);
  // Most bodies stay: only those that leave are packed. They may be half of all: nothing here grows
  // by more than it needs.
  const std::size_t width = packed_row_width(bodies, trait::migrated);
  std::map<int, std::size_t> leave;
  for (Index b = 0; b < bodies.owned; ++b)
    if (owner[b] != comm.rank) ++leave[owner[b]];
  ByRank<double> outgoing;
  for (const auto& [rank, count] : leave) outgoing[rank].reserve(width * count);
  std::vector<Index> stays;
  for (Index b = 0; b < bodies.owned; ++b)
    if (owner[b] == comm.rank)
      stays.push_back(b);
    else
      pack_row(bodies, b, trait::migrated, outgoing[owner[b]]);
  for_each_field(bodies, [&](const auto&, auto& field) {
    for (std::size_t k = 0; k < stays.size(); ++k) field[k] = field[stays[k]];
  });
  resize(bodies, static_cast<Index>(stays.size()));
  let_go(stays);
  auto incoming = comm.exchange(std::move(outgoing));
  std::size_t arriving = 0;
  for (const auto& [rank, rows] : incoming) arriving += rows.size() / width;
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(field.size() + arriving); });
  for (const auto& [rank, rows] : incoming) unpack_rows(bodies, rows, trait::migrated);
  incoming.clear();
  bodies.owned = bodies.size();
  sort_bodies(comm, bodies);
}

}  // namespace spall
