// Rows travel as doubles with the bits of whatever they hold.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/migration.hpp"

#include <algorithm>
#include <bit>
#include <numeric>
#include <unordered_map>

#include "base/morton.hpp"
#include "spall/error.hpp"
#include "state/pack.hpp"

namespace spall {
namespace {

/// Where each of `wanted` lives now, from a directory in which rank (id mod ranks) keeps the owner
/// of id.
std::unordered_map<BodyId, int> find_owners(const Comm& comm, const Bodies& bodies,
                                            const std::vector<BodyId>& wanted) {
  using Rows = std::vector<std::vector<std::int64_t>>;
  Rows mine(comm.size);
  for (Index b = 0; b < bodies.owned; ++b) mine[bodies.id[b] % comm.size].push_back(bodies.id[b]);
  const Rows owned_by = comm.exchange(mine);
  std::unordered_map<BodyId, int> directory;
  for (int r = 0; r < comm.size; ++r)
    for (BodyId id : owned_by[r]) directory[id] = r;

  Rows questions(comm.size);
  for (BodyId id : wanted) questions[id % comm.size].push_back(id);
  const Rows asked = comm.exchange(questions);
  Rows answers(comm.size);
  for (int r = 0; r < comm.size; ++r)
    for (BodyId id : asked[r]) answers[r].push_back(directory.at(id));
  const Rows answered = comm.exchange(answers);
  std::unordered_map<BodyId, int> owners;
  for (int r = 0; r < comm.size; ++r)
    for (std::size_t k = 0; k < questions[r].size(); ++k)
      owners[questions[r][k]] = static_cast<int>(answered[r][k]);
  return owners;
}

void send_memory(const Comm& comm, const Bodies& bodies, ContactMemory& memory) {
  std::vector<BodyId> wanted(memory.i);
  for (BodyId id : memory.j)
    if (id >= 0) wanted.push_back(id);
  std::sort(wanted.begin(), wanted.end());
  wanted.erase(std::unique(wanted.begin(), wanted.end()), wanted.end());
  const auto owners = find_owners(comm, bodies, wanted);

  std::vector<std::vector<double>> outgoing(comm.size);
  for (std::size_t c = 0; c < memory.i.size(); ++c) {
    const int first = owners.at(memory.i[c]);
    const int second = memory.j[c] < 0 ? first : owners.at(memory.j[c]);
    for (int rank : {first, second}) {
      auto& row = outgoing[rank];
      row.push_back(std::bit_cast<double>(memory.i[c]));
      row.push_back(std::bit_cast<double>(memory.j[c]));
      for (const Vec3& v : {memory.impulse[c], memory.rolling_of(c)})
        row.insert(row.end(), v.data(), v.data() + 3);
      if (second == first) break;
    }
  }
  memory = {};
  for (const auto& row : comm.exchange(outgoing)) {
    for (std::size_t k = 0; k < row.size(); k += 8)
      memory.add(std::bit_cast<BodyId>(row[k]), std::bit_cast<BodyId>(row[k + 1]),
                 {row[k + 2], row[k + 3], row[k + 4]}, {row[k + 5], row[k + 6], row[k + 7]});
  }
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

void migrate(const Comm& comm, Bodies& bodies, ContactMemory& memory,
             const std::vector<int>& owner) {
  // Most bodies stay: only those that leave are packed. They may be half of all: nothing here grows
  // by more than it needs.
  const std::size_t width = packed_row_width(bodies, trait::migrated);
  std::vector<std::size_t> leave(comm.size, 0);
  for (Index b = 0; b < bodies.owned; ++b) ++leave[owner[b]];
  std::vector<std::vector<double>> outgoing(comm.size);
  for (int r = 0; r < comm.size; ++r)
    if (r != comm.rank) outgoing[r].reserve(width * leave[r]);
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
  stays = std::vector<Index>();
  auto incoming = comm.exchange(outgoing);
  outgoing.clear();
  std::size_t arriving = 0;
  for (const auto& rows : incoming) arriving += rows.size() / width;
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(field.size() + arriving); });
  for (const auto& rows : incoming) unpack_rows(bodies, rows, trait::migrated);
  incoming.clear();
  bodies.owned = bodies.size();
  sort_bodies(comm, bodies);
  send_memory(comm, bodies, memory);
}

}  // namespace spall
