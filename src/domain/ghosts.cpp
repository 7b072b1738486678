// PetscSF does the messages; its roots are owned rows, its leaves ghost rows of the same array.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/ghosts.hpp"

#include <petscsf.h>

#include <algorithm>
#include <map>

#include "base/traffic.hpp"
#include "spall/error.hpp"

namespace spall {

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
  /// Books an exchange of rows of so many doubles, from their owners to all copies or back.
  void count(int width, bool to_copies) const {
    const std::int64_t rows = to_copies ? copies : ghosts;
    traffic().messages += to_copies ? told : asked;
    traffic().bytes += rows * width * static_cast<std::int64_t>(sizeof(double));
    traffic().sources = std::max(traffic().sources, to_copies ? asked : told);
    ++traffic().exchanges;
    traffic().row_bytes += width * static_cast<std::int64_t>(sizeof(double));
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
  PetscInt count = 0;
  const PetscMPIInt* ranks = nullptr;
  const PetscInt *offsets = nullptr, *rows = nullptr, *remote_rows = nullptr;
  check_petsc(PetscSFGetRootRanks(plan_->sf, &count, &ranks, &offsets, &rows, &remote_rows),
              "PetscSFGetRootRanks");
  plan_->asked = std::count_if(ranks, ranks + count, [&](int r) { return r != comm.rank; });
  check_petsc(PetscSFGetLeafRanks(plan_->sf, &count, &ranks, &offsets, &rows),
              "PetscSFGetLeafRanks");
  for (PetscInt k = 0; k < count; ++k) {
    if (ranks[k] == comm.rank) continue;  // images of own bodies
    ++plan_->told;
    plan_->copies += offsets[k + 1] - offsets[k];
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
  plan_->count(width, true);
  check_petsc(PetscSFBcastBegin(plan_->sf, plan_->unit(width), rows, rows, MPI_REPLACE),
              "PetscSFBcastBegin");
}

void Ghosts::gather_end(double* rows, int width) const {
  if (!plan_->sf) return;
  check_petsc(PetscSFBcastEnd(plan_->sf, plan_->unit(width), rows, rows, MPI_REPLACE),
              "PetscSFBcastEnd");
}

void Ghosts::scatter_add(double* rows, int width) const {
  if (!plan_->sf) return;
  plan_->count(width, false);
  // MPI_SUM has no meaning for a derived type in MPI itself; PetscSF defines it for contiguous
  // doubles.
  check_petsc(PetscSFReduceBegin(plan_->sf, plan_->unit(width), rows, rows, MPI_SUM),
              "PetscSFReduceBegin");
  check_petsc(PetscSFReduceEnd(plan_->sf, plan_->unit(width), rows, rows, MPI_SUM),
              "PetscSFReduceEnd");
}

Ghosts::Holders Ghosts::holders() const {
  Holders result;
  result.start.assign(plan_->owned + 1, 0);
  if (!plan_->sf) return result;
  PetscInt count = 0;
  const PetscMPIInt* ranks = nullptr;
  const PetscInt *offsets = nullptr, *rows = nullptr;
  check_petsc(PetscSFGetLeafRanks(plan_->sf, &count, &ranks, &offsets, &rows),
              "PetscSFGetLeafRanks");
  for (PetscInt k = 0; k < offsets[count]; ++k) ++result.start[rows[k] + 1];
  for (Index b = 0; b < plan_->owned; ++b) result.start[b + 1] += result.start[b];
  result.ranks.resize(result.start.back());
  std::vector<Index> next(result.start.begin(), result.start.end() - 1);
  for (PetscInt r = 0; r < count; ++r)
    for (PetscInt k = offsets[r]; k < offsets[r + 1]; ++k) result.ranks[next[rows[k]]++] = ranks[r];
  return result;
}

}  // namespace spall
