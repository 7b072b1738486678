// Ping-pong: short messages tell the latency, long ones the bandwidth.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/network.hpp"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include "spall/error.hpp"

namespace spall {
namespace {

/// s, one way, of a message of so many bytes: the least of several turns, which others did not
/// disturb. The same on all ranks. Collective.
double one_way(const Comm& comm, int bytes, int repeats) {
  std::vector<char> row(bytes);
  constexpr int turns = 9;
  double least = infinity;
  for (int turn = 0; turn < turns; ++turn) {
    check_mpi(MPI_Barrier(comm.raw), "MPI_Barrier");
    const double start = MPI_Wtime();
    for (int k = 0; k < 2 * repeats && comm.rank < 2; ++k)
      if (k % 2 == comm.rank)
        check_mpi(MPI_Send(row.data(), bytes, MPI_CHAR, 1 - comm.rank, 0, comm.raw), "MPI_Send");
      else
        check_mpi(
            MPI_Recv(row.data(), bytes, MPI_CHAR, 1 - comm.rank, 0, comm.raw, MPI_STATUS_IGNORE),
            "MPI_Recv");
    if (comm.rank < 2) least = std::min(least, (MPI_Wtime() - start) / (2 * repeats));
  }
  return comm.min(least);
}

}  // namespace

Network measure_network(const Comm& comm) {
  require(comm.size > 1, "--calibrate sends messages between two ranks: call it by mpirun -n 2");
  constexpr int short_bytes = 8, long_bytes = 1 << 22;
  const double latency = one_way(comm, short_bytes, 1000);
  return {latency, long_bytes / std::max(one_way(comm, long_bytes, 10) - latency, 1e-9)};
}

double parse_bandwidth(std::string_view text) {
  double value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  std::string_view unit(end, text.data() + text.size());
  unit.remove_prefix(std::min(unit.find_first_not_of(' '), unit.size()));
  constexpr std::pair<std::string_view, double> units[] = {
      {"B/s", 1}, {"kB/s", 1e3}, {"MB/s", 1e6}, {"GB/s", 1e9}};
  const auto found = std::ranges::find(units, unit, &std::pair<std::string_view, double>::first);
  require(error == std::errc() && found != std::end(units) && value > 0 && value < infinity,
          "'{}' is no bandwidth such as \"10 GB/s\"", text);
  return value * found->second;
}

}  // namespace spall
