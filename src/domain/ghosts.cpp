// PetscSF does the messages; its roots are owned rows, its leaves ghost rows of the same array.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/ghosts.hpp"

#include <petscsf.h>

#include <algorithm>
#include <map>

#include "base/traffic.hpp"
#include "spall/error.hpp"

namespace spall {

namespace {

/// Rows [start[k], start[k+1]) of `row` belong to the rank `rank[k]`.
struct RowsByRank {
  PetscInt ranks = 0;
  const PetscMPIInt* rank = nullptr;
  const PetscInt *start = nullptr, *row = nullptr;
};

}  // namespace

struct Ghosts::Plan {
  Comm comm;
  Index owned = 0;
  Index ghosts = 0;
  PetscSF sf = nullptr;
  std::int64_t told = 0;              // other ranks with copies of rows of this one
  std::int64_t copies = 0;            // rows that they have
  std::int64_t asked = 0;             // other ranks whose rows are copied here
  std::map<int, MPI_Datatype> units;  // contiguous doubles, by width; committed once

  MPI_Datatype unit(int width) {
    auto [it, is_new] = units.try_emplace(width, MPI_DATATYPE_NULL);
    if (is_new) {
      check_mpi(MPI_Type_contiguous(width, MPI_DOUBLE, &it->second), "MPI_Type_contiguous");
      check_mpi(MPI_Type_commit(&it->second), "MPI_Type_commit");
    }
    return it->second;
  }
  /// Books an exchange of rows of so many doubles.
  void count(int width) const {
    traffic().messages += told;
    traffic().bytes += copies * width * static_cast<std::int64_t>(sizeof(double));
    traffic().sources = std::max(traffic().sources, asked);
    ++traffic().exchanges;
    traffic().row_bytes += width * static_cast<std::int64_t>(sizeof(double));
  }
  /// Owned rows that other ranks, or images of own bodies, copy.
  RowsByRank wanted() const {
    RowsByRank rows;
    check_petsc(PetscSFGetLeafRanks(sf, &rows.ranks, &rows.rank, &rows.start, &rows.row),
                "PetscSFGetLeafRanks");
    return rows;
  }
  /// Ghost rows by the rank of their originals.
  RowsByRank expected() const {
    RowsByRank rows;
    const PetscInt* there = nullptr;
    check_petsc(PetscSFGetRootRanks(sf, &rows.ranks, &rows.rank, &rows.start, &rows.row, &there),
                "PetscSFGetRootRanks");
    return rows;
  }
  ~Plan() {
    for (auto& [width, type] : units) MPI_Type_free(&type);
    if (sf) PetscSFDestroy(&sf);
  }
};

Ghosts::Ghosts() : plan_(std::make_unique<Plan>()) {}

Ghosts::Ghosts(Comm comm, Index owned, std::span<const Origin> origins)
    : plan_(std::make_unique<Plan>()) {
  plan_->comm = comm;
  plan_->owned = owned;
  plan_->ghosts = static_cast<Index>(origins.size());
  std::vector<PetscInt> local(origins.size());
  std::vector<PetscSFNode> remote(origins.size());
  for (std::size_t g = 0; g < origins.size(); ++g) {
    local[g] = owned + static_cast<PetscInt>(g);
    remote[g] = {origins[g].rank, origins[g].row};
  }
  check_petsc(PetscSFCreate(comm.raw, &plan_->sf), "PetscSFCreate");
  check_petsc(PetscSFSetGraph(plan_->sf, owned, static_cast<PetscInt>(origins.size()), local.data(),
                              PETSC_COPY_VALUES, remote.data(), PETSC_COPY_VALUES),
              "PetscSFSetGraph");
  check_petsc(PetscSFSetUp(plan_->sf), "PetscSFSetUp");
  const RowsByRank expected = plan_->expected(), wanted = plan_->wanted();
  plan_->asked = std::count_if(expected.rank, expected.rank + expected.ranks,
                               [&](int rank) { return rank != comm.rank; });
  for (PetscInt k = 0; k < wanted.ranks; ++k) {
    if (wanted.rank[k] == comm.rank) continue;  // images of own bodies
    ++plan_->told;
    plan_->copies += wanted.start[k + 1] - wanted.start[k];
  }
}

Ghosts::~Ghosts() = default;
Ghosts::Ghosts(Ghosts&&) noexcept = default;
Ghosts& Ghosts::operator=(Ghosts&&) noexcept = default;

Index Ghosts::owned() const {
  return plan_->owned;
}
Index Ghosts::ghosts() const {
  return plan_->ghosts;
}
const Comm& Ghosts::comm() const {
  return plan_->comm;
}

void Ghosts::gather_begin(double* rows, int width) const {
  if (!plan_->sf) return;
  plan_->count(width);
  check_petsc(PetscSFBcastBegin(plan_->sf, plan_->unit(width), rows, rows, MPI_REPLACE),
              "PetscSFBcastBegin");
}

void Ghosts::gather_end(double* rows, int width) const {
  if (!plan_->sf) return;
  check_petsc(PetscSFBcastEnd(plan_->sf, plan_->unit(width), rows, rows, MPI_REPLACE),
              "PetscSFBcastEnd");
}

void Ghosts::gather(std::span<const FieldRows> fields) const {
  if (!plan_->sf) return;
  int width = 0;
  for (const FieldRows& field : fields) width += field.width;
  plan_->count(width);
  // The star forest knows which rows each rank wants, in the order in which that rank expects them.
  const RowsByRank wanted = plan_->wanted(), expected = plan_->expected();
  const auto buffer = [&](const RowsByRank& by_rank) {
    return std::vector<double>(static_cast<std::size_t>(by_rank.start[by_rank.ranks]) * width);
  };
  std::vector<double> going = buffer(wanted), coming = buffer(expected);
  std::vector<MPI_Request> requests;
  const auto part = [&](std::vector<double>& all, const RowsByRank& by_rank, PetscInt k) {
    return std::span(all).subspan(static_cast<std::size_t>(by_rank.start[k]) * width,
                                  (by_rank.start[k + 1] - by_rank.start[k]) * width);
  };
  constexpr int tag = 1;  // Comm::exchange has 0
  for (PetscInt k = 0; k < expected.ranks; ++k) {
    const std::span<double> from = part(coming, expected, k);
    check_mpi(MPI_Irecv(from.data(), static_cast<int>(from.size()), MPI_DOUBLE, expected.rank[k],
                        tag, plan_->comm.raw, &requests.emplace_back()),
              "MPI_Irecv");
  }
  for (PetscInt k = 0; k < wanted.ranks; ++k) {
    const std::span<double> to = part(going, wanted, k);
    double* next = to.data();
    for (PetscInt row = wanted.start[k]; row < wanted.start[k + 1]; ++row)
      for (const FieldRows& field : fields)
        next = std::copy_n(field.rows + static_cast<std::ptrdiff_t>(wanted.row[row]) * field.width,
                           field.width, next);
    check_mpi(MPI_Isend(to.data(), static_cast<int>(to.size()), MPI_DOUBLE, wanted.rank[k], tag,
                        plan_->comm.raw, &requests.emplace_back()),
              "MPI_Isend");
  }
  check_mpi(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
            "MPI_Waitall");
  const double* next = coming.data();
  for (PetscInt row = 0; row < expected.start[expected.ranks]; ++row)
    for (const FieldRows& field : fields) {
      std::copy_n(next, field.width,
                  field.rows + static_cast<std::ptrdiff_t>(expected.row[row]) * field.width);
      next += field.width;
    }
}

}  // namespace spall
