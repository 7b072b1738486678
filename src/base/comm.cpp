// Collective calls with their return codes checked.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/comm.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <petscsys.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <map>
#include <new>
#include <numeric>

#include "base/kernels.hpp"
#include "base/reduce.hpp"
#include "base/traffic.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

template <class T>
MPI_Datatype mpi_type();
template <>
MPI_Datatype mpi_type<double>() {
  return MPI_DOUBLE;
}
template <>
MPI_Datatype mpi_type<std::int64_t>() {
  return MPI_INT64_T;
}
template <>
MPI_Datatype mpi_type<std::uint64_t>() {
  return MPI_UINT64_T;
}

/// As MPI counts. Throws Error where it cannot, on all ranks where all have as many.
int mpi_count(std::size_t numbers) {
  require(numbers <= std::numeric_limits<int>::max(),
          "a message of {} numbers: MPI takes 2^31 - 1 at most", numbers);
  return static_cast<int>(numbers);
}

template <class T>
void reduce(MPI_Comm comm, std::span<T> values, MPI_Op op) {
  ++traffic().collectives;
  traffic().reduced += static_cast<std::int64_t>(values.size_bytes());
  check_mpi(
      MPI_Allreduce(MPI_IN_PLACE, values.data(), mpi_count(values.size()), mpi_type<T>(), op, comm),
      "MPI_Allreduce");
}

template <class T>
T reduce(MPI_Comm comm, T value, MPI_Op op) {
  ++traffic().collectives;
  traffic().reduced += static_cast<std::int64_t>(sizeof(T));
  T result = value;
  check_mpi(MPI_Allreduce(&value, &result, 1, mpi_type<T>(), op, comm), "MPI_Allreduce");
  return result;
}

/// Of rows [number of sums, sums, largest ones].
void add_and_compare(void* from, void* to, int* rows, MPI_Datatype* type) {
  int bytes = 0;
  MPI_Type_size(*type, &bytes);
  const auto width = static_cast<std::size_t>(bytes) / sizeof(double);
  const auto* theirs = static_cast<const double*>(from);
  auto* own = static_cast<double*>(to);
  for (int row = 0; row < *rows; ++row, theirs += width, own += width)
    for (std::size_t k = 1; k < width; ++k)
      own[k] =
          k <= static_cast<std::size_t>(own[0]) ? own[k] + theirs[k] : std::max(own[k], theirs[k]);
}

template <class T>
std::vector<T> all_gather_values(const Comm& comm, std::span<const T> values,
                                 std::size_t* first = nullptr) {
  const int count = mpi_count(values.size());
  std::vector<int> counts(comm.size), starts(comm.size + 1, 0);
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm.raw),
            "MPI_Allgather");
  mpi_count(std::accumulate(counts.begin(), counts.end(), std::size_t{0}));
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  if (first) *first = static_cast<std::size_t>(starts[comm.rank]);
  std::vector<T> all(starts.back());
  check_mpi(MPI_Allgatherv(values.data(), count, mpi_type<T>(), all.data(), counts.data(),
                           starts.data(), mpi_type<T>(), comm.raw),
            "MPI_Allgatherv");
  ++traffic().collectives;
  traffic().gathered +=
      static_cast<std::int64_t>(sizeof(int) * counts.size() + sizeof(T) * all.size());
  return all;
}

template <class T>
ByRank<T> exchange_rows(const Comm& comm, ByRank<T> outgoing) {
  ++traffic().collectives;
  ByRank<T> incoming;
  std::erase_if(outgoing, [](const auto& row) { return row.second.empty(); });
  if (auto own = outgoing.extract(comm.rank)) incoming.insert(std::move(own));
  if (comm.size == 1) return incoming;
  std::vector<PetscMPIInt> to, lengths;
  for (const auto& [rank, rows] : outgoing) {
    to.push_back(rank);
    lengths.push_back(mpi_count(rows.size()));
  }
  // Up to 1,024 ranks by a reduction, beyond by messages and a barrier that does not block
  // (Hoefler, Siebert, Lumsdaine 2010).
  PetscMPIInt count = 0, *from = nullptr, *coming = nullptr;
  check_petsc(PetscCommBuildTwoSided(comm.raw, 1, MPI_INT, static_cast<int>(to.size()), to.data(),
                                     lengths.data(), &count, &from, &coming),
              "PetscCommBuildTwoSided");
  std::vector<MPI_Request> requests;
  for (int k = 0; k < count; ++k) {
    std::vector<T>& rows = incoming[from[k]];
    rows.resize(coming[k]);
    check_mpi(MPI_Irecv(rows.data(), coming[k], mpi_type<T>(), from[k], 0, comm.raw,
                        &requests.emplace_back()),
              "MPI_Irecv");
  }
  for (const auto& [rank, rows] : outgoing)
    check_mpi(MPI_Isend(rows.data(), static_cast<int>(rows.size()), mpi_type<T>(), rank, 0,
                        comm.raw, &requests.emplace_back()),
              "MPI_Isend");
  check_mpi(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
            "MPI_Waitall");
  traffic().sources = std::max<std::int64_t>(traffic().sources, count);
  for (int length : lengths) {
    ++traffic().messages;
    traffic().bytes += static_cast<std::int64_t>(sizeof(T)) * length;
  }
  check_petsc(PetscFree(from), "PetscFree");
  check_petsc(PetscFree(coming), "PetscFree");
  return incoming;
}

constexpr int exit_error = 2;

void leave(int) {
  _exit(exit_error);
}

/// Of the ranks of a node: 1 as soon as one tells an error. Null without a session.
std::atomic<int>* has_spoken = nullptr;
MPI_Win shared_word = MPI_WIN_NULL;

void share_word() {
  MPI_Comm node = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node),
            "MPI_Comm_split_type");
  int rank = 0, unit = 0;
  MPI_Comm_rank(node, &rank);
  MPI_Aint size = rank == 0 ? sizeof(std::atomic<int>) : 0;
  void* word = nullptr;
  check_mpi(MPI_Win_allocate_shared(size, 1, MPI_INFO_NULL, node, &word, &shared_word),
            "MPI_Win_allocate_shared");
  check_mpi(MPI_Win_shared_query(shared_word, 0, &size, &unit, &word), "MPI_Win_shared_query");
  if (rank == 0) new (word) std::atomic<int>(0);
  check_mpi(MPI_Barrier(node), "MPI_Barrier");
  has_spoken = static_cast<std::atomic<int>*>(word);
  MPI_Comm_free(&node);
}

/// PETSc's copy of the communicator of all ranks, which each exchange asks for. Where nobody holds
/// it, it is made and freed each time.
MPI_Comm held_by_petsc = MPI_COMM_NULL;

int say_nothing(const char*, const char*, bool, ...) {
  return 0;
}

/// Open MPI tells of each abort in nine lines, in which the error's own would be lost. Its function
/// for such texts is a pointer; other implementations have no such name and say what they say.
void silence_open_mpi() {
  using ShowHelp = int (*)(const char* file, const char* topic, bool header, ...);
  if (auto* show_help = static_cast<ShowHelp*>(dlsym(RTLD_DEFAULT, "opal_show_help")))
    *show_help = say_nothing;
  // Its event loop warns of what the launcher has closed already.
  [[maybe_unused]] const auto* silent = std::freopen("/dev/null", "w", stderr);
}

}  // namespace

Traffic& traffic() {
  static Traffic own;
  return own;
}

Comm::Comm(MPI_Comm communicator) : raw(communicator) {
  check_mpi(MPI_Comm_rank(raw, &rank), "MPI_Comm_rank");
  check_mpi(MPI_Comm_size(raw, &size), "MPI_Comm_size");
}

double Comm::sum(double value) const {
  return reduce(raw, value, MPI_SUM);
}
std::int64_t Comm::sum(std::int64_t value) const {
  return reduce(raw, value, MPI_SUM);
}
double Comm::max(double value) const {
  return reduce(raw, value, MPI_MAX);
}
double Comm::min(double value) const {
  return reduce(raw, value, MPI_MIN);
}
bool Comm::any(bool value) const {
  return reduce<std::int64_t>(raw, value, MPI_MAX) != 0;
}
void Comm::any(std::span<std::uint64_t> bits) const {
  reduce(raw, bits, MPI_BOR);
}

Vec3 Comm::sum(const Vec3& value) const {
  Vec3 result = value;
  sum(std::span<double>(result.data(), 3));
  return result;
}

void Comm::sum(std::span<double> values) const {
  reduce(raw, values, MPI_SUM);
}
void Comm::max(std::span<double> values) const {
  reduce(raw, values, MPI_MAX);
}

void reduce(const Comm& comm, std::span<double> sums, std::span<double> largest) {
  static MPI_Op operation = MPI_OP_NULL;  // one for the life of MPI, as the types
  static std::map<std::size_t, MPI_Datatype> types;
  std::vector<double> row{static_cast<double>(sums.size())};
  row.insert(row.end(), sums.begin(), sums.end());
  row.insert(row.end(), largest.begin(), largest.end());
  if (operation == MPI_OP_NULL)
    check_mpi(MPI_Op_create(add_and_compare, true, &operation), "MPI_Op_create");
  const auto [type, is_new] = types.try_emplace(row.size(), MPI_DATATYPE_NULL);
  if (is_new) {
    check_mpi(MPI_Type_contiguous(static_cast<int>(row.size()), MPI_DOUBLE, &type->second),
              "MPI_Type_contiguous");
    check_mpi(MPI_Type_commit(&type->second), "MPI_Type_commit");
  }
  ++traffic().collectives;
  traffic().reduced += static_cast<std::int64_t>(row.size() * sizeof(double));
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, row.data(), 1, type->second, operation, comm.raw),
            "MPI_Allreduce");
  const auto after = std::copy_n(row.begin() + 1, sums.size(), sums.begin()) - sums.begin();
  std::copy(row.begin() + 1 + after, row.end(), largest.begin());
}

std::int64_t Comm::sum_before(std::int64_t value) const {
  ++traffic().collectives;
  std::int64_t before = 0;
  check_mpi(MPI_Exscan(&value, &before, 1, MPI_INT64_T, MPI_SUM, raw), "MPI_Exscan");
  return rank == 0 ? 0 : before;  // MPI leaves rank 0's result undefined
}

void Comm::broadcast(std::span<double> values, int root) const {
  ++traffic().collectives;
  check_mpi(MPI_Bcast(values.data(), mpi_count(values.size()), MPI_DOUBLE, root, raw), "MPI_Bcast");
}

std::vector<double> Comm::all_gather(std::span<const double> values) const {
  return all_gather_values(*this, values);
}
std::vector<double> all_gather(const Comm& comm, std::span<const double> values,
                               std::size_t& first) {
  return all_gather_values(comm, values, &first);
}
std::vector<std::int64_t> Comm::all_gather(std::span<const std::int64_t> values) const {
  return all_gather_values(*this, values);
}

ByRank<double> Comm::exchange(ByRank<double> outgoing) const {
  return exchange_rows(*this, std::move(outgoing));
}
ByRank<std::int64_t> Comm::exchange(ByRank<std::int64_t> outgoing) const {
  return exchange_rows(*this, std::move(outgoing));
}

Session::Session() {
  // Open MPI's own MPI-IO leaves ranks waiting where the write of one fails; ROMIO tells all.
  setenv("OMPI_MCA_io", "romio321", 0);
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr) != 0) std::abort();
  PetscPopSignalHandler();
  check_petsc(PetscCommDuplicate(PETSC_COMM_WORLD, &held_by_petsc, nullptr), "PetscCommDuplicate");
  share_word();
  use_instructions(static_cast<Instructions>(world().min(static_cast<double>(instructions()))));
}

Session::~Session() {
  has_spoken = nullptr;
  MPI_Win_free(&shared_word);
  PetscCommDestroy(&held_by_petsc);
  PetscFinalize();
}

Comm Session::world() const {
  return Comm(PETSC_COMM_WORLD);
}

void Session::abort_all(const std::string& message, bool knows_cause) {
  const Comm comm(MPI_COMM_WORLD);
  // The first to speak ends the others, whom the launcher tells by these signals; the seconds are
  // long beside what ranks differ by.
  std::signal(SIGCONT, leave);
  std::signal(SIGTERM, leave);
  const int turn = (comm.rank > 0 ? 1 : 0) + (knows_cause ? 0 : 2);
  sleep(turn);
  constexpr int longest_end = 5;
  if (has_spoken && has_spoken->exchange(1) != 0)
    sleep(longest_end);
  else if (comm.rank == 0 || comm.size == 1)
    fmt::print(stderr, "spall: {}\n", message);
  else
    fmt::print(stderr, "spall: rank {}: {}\n", comm.rank, message);
  std::fflush(stderr);
  silence_open_mpi();
  MPI_Abort(MPI_COMM_WORLD, exit_error);
  std::abort();
}

}  // namespace spall
