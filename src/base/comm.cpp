// Collective calls with their return codes checked.
// SPDX-License-Identifier: BSD-3-Clause
#include "spall/comm.hpp"

#include <dlfcn.h>
#include <fmt/format.h>
#include <petscsys.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <numeric>

#include "base/kernels.hpp"
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

template <class T>
T reduce(MPI_Comm comm, T value, MPI_Op op) {
  T result = value;
  check_mpi(MPI_Allreduce(&value, &result, 1, mpi_type<T>(), op, comm), "MPI_Allreduce");
  return result;
}

template <class T>
std::vector<T> all_gather_values(const Comm& comm, std::span<const T> values) {
  const int count = static_cast<int>(values.size());
  std::vector<int> counts(comm.size), starts(comm.size + 1, 0);
  check_mpi(MPI_Allgather(&count, 1, MPI_INT, counts.data(), 1, MPI_INT, comm.raw),
            "MPI_Allgather");
  std::partial_sum(counts.begin(), counts.end(), starts.begin() + 1);
  std::vector<T> all(starts.back());
  check_mpi(MPI_Allgatherv(values.data(), count, mpi_type<T>(), all.data(), counts.data(),
                           starts.data(), mpi_type<T>(), comm.raw),
            "MPI_Allgatherv");
  return all;
}

template <class T>
std::vector<std::vector<T>> exchange_rows(const Comm& comm,
                                          const std::vector<std::vector<T>>& outgoing) {
  std::vector<int> send(comm.size), receive(comm.size);
  for (int r = 0; r < comm.size; ++r) send[r] = static_cast<int>(outgoing[r].size());
  check_mpi(MPI_Alltoall(send.data(), 1, MPI_INT, receive.data(), 1, MPI_INT, comm.raw),
            "MPI_Alltoall");
  // From and to where the rows are: they may be most of what a rank holds.
  std::vector<std::vector<T>> incoming(comm.size);
  std::vector<MPI_Request> requests;
  for (int r = 0; r < comm.size; ++r) {
    incoming[r].resize(receive[r]);
    if (receive[r] > 0)
      check_mpi(MPI_Irecv(incoming[r].data(), receive[r], mpi_type<T>(), r, 0, comm.raw,
                          &requests.emplace_back()),
                "MPI_Irecv");
  }
  for (int r = 0; r < comm.size; ++r)
    if (send[r] > 0)
      check_mpi(MPI_Isend(outgoing[r].data(), send[r], mpi_type<T>(), r, 0, comm.raw,
                          &requests.emplace_back()),
                "MPI_Isend");
  check_mpi(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE),
            "MPI_Waitall");
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

int say_nothing(const char*, const char*, bool, ...) {
  return 0;
}

/// Open MPI tells of each abort in nine lines, in which the error's own would be lost. Its function
/// for such texts is a pointer; other implementations have no such name and say what they say.
void silence_open_mpi() {
  using ShowHelp = int (*)(const char* file, const char* topic, bool header, ...);
  if (auto* show_help = static_cast<ShowHelp*>(dlsym(RTLD_DEFAULT, "opal_show_help")))
    *show_help = say_nothing;
}

}  // namespace

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

Vec3 Comm::sum(const Vec3& value) const {
  Vec3 result = value;
  sum(std::span<double>(result.data(), 3));
  return result;
}

void Comm::sum(std::span<double> values) const {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE,
                          MPI_SUM, raw),
            "MPI_Allreduce");
}
void Comm::max(std::span<double> values) const {
  check_mpi(MPI_Allreduce(MPI_IN_PLACE, values.data(), static_cast<int>(values.size()), MPI_DOUBLE,
                          MPI_MAX, raw),
            "MPI_Allreduce");
}

std::int64_t Comm::sum_before(std::int64_t value) const {
  std::int64_t before = 0;
  check_mpi(MPI_Exscan(&value, &before, 1, MPI_INT64_T, MPI_SUM, raw), "MPI_Exscan");
  return rank == 0 ? 0 : before;  // MPI leaves rank 0's result undefined
}

void Comm::broadcast(std::span<double> values, int root) const {
  check_mpi(MPI_Bcast(values.data(), static_cast<int>(values.size()), MPI_DOUBLE, root, raw),
            "MPI_Bcast");
}

std::vector<double> Comm::all_gather(std::span<const double> values) const {
  return all_gather_values(*this, values);
}
std::vector<std::int64_t> Comm::all_gather(std::span<const std::int64_t> values) const {
  return all_gather_values(*this, values);
}

std::vector<std::vector<double>> Comm::exchange(
    const std::vector<std::vector<double>>& outgoing) const {
  return exchange_rows(*this, outgoing);
}
std::vector<std::vector<std::int64_t>> Comm::exchange(
    const std::vector<std::vector<std::int64_t>>& outgoing) const {
  return exchange_rows(*this, outgoing);
}

Session::Session(int& argc, char**& argv) {
  // PETSc reads its options from PETSC_OPTIONS alone: the command line is ours.
  (void)argc;
  (void)argv;
  // Open MPI's own MPI-IO leaves ranks waiting where the write of one fails; ROMIO tells all.
  setenv("OMPI_MCA_io", "romio321", 0);
  if (PetscInitialize(nullptr, nullptr, nullptr, nullptr) != 0) std::abort();
  PetscPopSignalHandler();
  share_word();
  use_instructions(static_cast<Instructions>(world().min(static_cast<double>(instructions()))));
}

Session::~Session() {
  has_spoken = nullptr;
  MPI_Win_free(&shared_word);
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
