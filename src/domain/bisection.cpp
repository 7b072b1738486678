// Each halving sends the places of bodies to the ranks of their half.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/bisection.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "spall/error.hpp"

namespace spall {
namespace {

struct Place {
  Vec3 position;
  double work;
  double rank, row;  // of the body
};
constexpr std::size_t doubles_a_place = sizeof(Place) / sizeof(double);
static_assert(doubles_a_place == 6);

/// The direction in which work is spread farthest: a few bodies far away do not count for much.
int longest_direction(const Comm& comm, std::span<const Place> places) {
  std::array<double, 4> first{};  // sums of work, work x
  for (const Place& p : places) {
    first[0] += p.work;
    for (int k = 0; k < 3; ++k) first[k + 1] += p.work * p.position[k];
  }
  comm.sum(first);
  const Vec3 centre = Vec3::Map(&first[1]) / first[0];
  Vec3 squares = Vec3::Zero();
  for (const Place& p : places) squares += p.work * (p.position - centre).cwiseAbs2();
  squares = comm.sum(squares);
  // The first of those that are equal but for round-off, which is another on other ranks.
  constexpr double round_off = 1e-9;
  int longest = 0;
  for (int k : {1, 2})
    if (squares[k] > (1 + round_off) * squares[longest]) longest = k;
  return longest;
}

/// The coordinate below which `share` of the work lies. Layers of bodies at one coordinate, but for
/// round-off, are not parted: no cut is finer than a small part of `radius` (m).
double cut_at(const Comm& comm, std::span<const Place> places, int direction, double share,
              double radius) {
  constexpr std::size_t bins = 64;
  constexpr double enough = 1e-3;  // of all work, by which a cut may miss its share
  constexpr double finest = 0.01;  // radii
  std::array<double, 2> ends{-infinity, -infinity};  // -low, high
  for (const Place& p : places) {
    ends[0] = std::max(ends[0], -p.position[direction]);
    ends[1] = std::max(ends[1], p.position[direction]);
  }
  comm.max(ends);
  // Uneven margins, or edges of bins would lie in layers of a lattice.
  double low = -ends[0] - 0.382 * radius, high = ends[1] + 0.618 * radius;
  double below = 0, all = 0;
  while (true) {
    std::array<double, bins> work{};
    const double width = (high - low) / bins;
    for (const Place& p : places) {
      const double x = p.position[direction];
      if (x < low || x > high) continue;
      work[std::min(bins - 1, static_cast<std::size_t>((x - low) / width))] += p.work;
    }
    comm.sum(work);
    if (all == 0)
      for (double w : work) all += w;
    std::size_t bin = 0;
    while (bin + 1 < bins && below + work[bin] < share * all) below += work[bin++];
    low += static_cast<double>(bin) * width;
    high = low + width;
    const double more = below + work[bin] - share * all, less = share * all - below;
    if (std::min(more, less) <= enough * all || !(width > finest * radius))
      return more < less ? high : low;
  }
}

/// All places of one half to its ranks; each of them takes what some of the other half hold.
std::vector<Place> send_over(const Comm& comm, int left, int direction, double cut,
                             std::vector<Place> places) {
  const bool is_left = comm.rank < left;
  const auto goes = [&](const Place& p) { return (p.position[direction] <= cut) != is_left; };
  const int right = comm.size - left;
  const int to = is_left ? left + comm.rank * right / left : (comm.rank - left) * left / right;
  ByRank<double> outgoing;
  for (const Place& p : places)
    if (goes(p))
      outgoing[to].insert(outgoing[to].end(),
                          {p.position[0], p.position[1], p.position[2], p.work, p.rank, p.row});
  std::erase_if(places, goes);
  for (const auto& [from, rows] : comm.exchange(std::move(outgoing)))
    for (std::size_t k = 0; k < rows.size(); k += doubles_a_place)
      places.push_back({Vec3(&rows[k]), rows[k + 3], rows[k + 4], rows[k + 5]});
  return places;
}

/// The plane between the places of two halves of `parts` ranks.
struct Halving {
  int left;  // ranks below it
  int direction;
  double at;
};
Halving halve(const Comm& comm, std::span<const Place> places, int parts, double radius) {
  const int left = parts / 2;
  const int direction = longest_direction(comm, places);
  return {left, direction,
          cut_at(comm, places, direction, static_cast<double>(left) / parts, radius)};
}

/// Ends with the places that are this rank's.
std::vector<Place> bisect(const Comm& comm, std::vector<Place> places, double radius) {
  if (comm.size == 1) return places;
  const auto [left, direction, cut] = halve(comm, places, comm.size, radius);
  places = send_over(comm, left, direction, cut, std::move(places));
  MPI_Comm half = MPI_COMM_NULL;
  check_mpi(MPI_Comm_split(comm.raw, comm.rank < left, comm.rank, &half), "MPI_Comm_split");
  places = bisect(Comm(half), std::move(places), radius);
  check_mpi(MPI_Comm_free(&half), "MPI_Comm_free");
  return places;
}

/// Ends with the ranks from `first` on, of which there are `parts`, as those of the places.
void bisect(const Comm& comm, std::span<Place> places, int first, int parts, double radius) {
  if (parts == 1) {
    for (Place& p : places) p.rank = first;
    return;
  }
  const auto [left, direction, cut] = halve(comm, places, parts, radius);
  const std::span<Place> above(std::ranges::stable_partition(
      places, [&](const Place& p) { return p.position[direction] <= cut; }));
  bisect(comm, places.first(places.size() - above.size()), first, left, radius);
  bisect(comm, above, first + left, parts - left, radius);
}

double mean_radius(const Comm& comm, const Bodies& bodies) {
  std::array<double, 2> sums{static_cast<double>(bodies.owned), 0};
  for (Index b = 0; b < bodies.owned; ++b) sums[1] += bodies.radius[b];
  comm.sum(sums);
  return sums[0] > 0 ? sums[1] / sums[0] : 0;
}

std::vector<Place> places_of(const Comm& comm, const Bodies& bodies, std::span<const double> work) {
  std::vector<Place> places;
  places.reserve(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b)
    places.push_back(
        {bodies.position[b], work[b], static_cast<double>(comm.rank), static_cast<double>(b)});
  return places;
}

}  // namespace

std::vector<int> bisect(const Comm& comm, const Bodies& bodies, std::span<const double> work) {
  ByRank<std::int64_t> mine;
  for (const Place& p : bisect(comm, places_of(comm, bodies, work), mean_radius(comm, bodies)))
    mine[static_cast<int>(p.rank)].push_back(static_cast<std::int64_t>(p.row));
  std::vector<int> owner(bodies.owned, -1);
  for (const auto& [rank, rows] : comm.exchange(std::move(mine)))
    for (std::int64_t row : rows) owner[row] = rank;
  return owner;
}

std::vector<int> bisect(const Comm& comm, const Bodies& bodies, std::span<const double> work,
                        int parts) {
  std::vector<Place> places = places_of(comm, bodies, work);
  bisect(comm, places, 0, parts, mean_radius(comm, bodies));
  std::vector<int> owner(bodies.owned);
  for (const Place& p : places) owner[static_cast<Index>(p.row)] = static_cast<int>(p.rank);
  return owner;
}

}  // namespace spall
