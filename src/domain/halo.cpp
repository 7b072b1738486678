// Ranks publish boxes around small clusters of their bodies; a body goes where it touches a box.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/halo.hpp"

#include <algorithm>
#include <array>

#include "spall/error.hpp"
#include "state/pack.hpp"

namespace spall {
namespace {

constexpr Index bodies_a_box = 16;  // along the space-filling curve: boxes are compact
constexpr std::size_t clusters_at_once = 64;
constexpr double large = 4;  // a body this many times the mean radius gets a box of its own

struct Box {
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  void add(const Vec3& center, double radius) {
    low = low.cwiseMin(center - Vec3::Constant(radius));
    high = high.cwiseMax(center + Vec3::Constant(radius));
  }
  void add(const Box& other) {
    low = low.cwiseMin(other.low);
    high = high.cwiseMax(other.high);
  }
  bool meets(const Box& other) const {
    return (low.array() <= other.high.array()).all() && (other.low.array() <= high.array()).all();
  }
};

struct Cluster {
  Box box;
  Index first, last;  // rows
};

struct RemoteBox {
  Box box;
  int rank;
  Vec3 shift;  ///< of a body that meets the box, to where it is seen from there
};

/// All by which an image may be away from its body, none first.
std::vector<Vec3> shifts_of(const Period& period) {
  std::vector<Vec3> shifts{Vec3::Zero()};
  for (int k = 0; k < 3; ++k)
    for (std::size_t s = 0, before = shifts.size(); s < before && period.size[k] > 0; ++s)
      for (double sign : {-1.0, 1.0})
        shifts.push_back(shifts[s] + sign * period.size[k] * Vec3::Unit(k));
  return shifts;
}

std::vector<Cluster> cluster_bodies(const Bodies& bodies, std::span<const double> reach) {
  double mean = 0;
  for (Index b = 0; b < bodies.owned; ++b) mean += bodies.radius[b] + reach[b];
  mean /= std::max<Index>(bodies.owned, 1);
  std::vector<Cluster> clusters;
  bool open = false;
  for (Index b = 0; b < bodies.owned; ++b) {
    const double radius = bodies.radius[b] + reach[b];
    const bool alone = radius > large * mean;
    if (alone || !open || clusters.back().last - clusters.back().first == bodies_a_box)
      clusters.push_back({{}, b, b});
    clusters.back().box.add(bodies.position[b], radius);
    clusters.back().last = b + 1;
    open = !alone;
  }
  return clusters;
}

}  // namespace

Ghosts make_halo(const Comm& comm, Bodies& bodies, std::vector<double>& reach, const Period& period,
                 std::vector<Vec3>& shifts) {
  resize(bodies, bodies.owned);
  reach.resize(bodies.owned);
  const auto clusters = cluster_bodies(bodies, reach);
  std::vector<double> packed;
  for (const auto& cluster : clusters) {
    packed.push_back(comm.rank);
    packed.insert(packed.end(), cluster.box.low.data(), cluster.box.low.data() + 3);
    packed.insert(packed.end(), cluster.box.high.data(), cluster.box.high.data() + 3);
  }
  const auto all = comm.all_gather(std::span<const double>(packed));

  // Boxes of other ranks that meet anything of ours; then those that meet some clusters, then one,
  // then a body.
  Box whole;
  for (const auto& cluster : clusters) whole.add(cluster.box);
  std::vector<RemoteBox> around, beside, near;
  for (const Vec3& shift : shifts_of(period))
    for (std::size_t k = 0; k < all.size(); k += 7) {
      const RemoteBox box{{Vec3(all[k + 1], all[k + 2], all[k + 3]) - shift,
                           Vec3(all[k + 4], all[k + 5], all[k + 6]) - shift},
                          static_cast<int>(all[k]),
                          shift};
      const bool itself = box.rank == comm.rank && shift.isZero(0);
      if (!itself && whole.meets(box.box)) around.push_back(box);
    }
  std::vector<std::vector<double>> outgoing(comm.size);
  const auto keep_meeting = [](const std::vector<RemoteBox>& from, const Box& box,
                               std::vector<RemoteBox>& to) {
    to.clear();
    std::copy_if(from.begin(), from.end(), std::back_inserter(to),
                 [&](const RemoteBox& remote) { return remote.box.meets(box); });
  };
  for (std::size_t k = 0; k < clusters.size(); ++k) {
    if (k % clusters_at_once == 0) {
      Box several;
      for (std::size_t m = k; m < std::min(k + clusters_at_once, clusters.size()); ++m)
        several.add(clusters[m].box);
      keep_meeting(around, several, beside);
    }
    const Cluster& cluster = clusters[k];
    keep_meeting(beside, cluster.box, near);
    for (Index b = cluster.first; b < cluster.last && !near.empty(); ++b) {
      Box own;
      own.add(bodies.position[b], bodies.radius[b] + reach[b]);
      // Boxes come image by image and rank by rank: a rank gets one copy of each image.
      const RemoteBox* last = nullptr;
      for (const auto& remote : near) {
        if ((last && remote.rank == last->rank && remote.shift == last->shift) ||
            !own.meets(remote.box))
          continue;
        last = &remote;
        auto& row = outgoing[remote.rank];
        row.insert(row.end(), remote.shift.data(), remote.shift.data() + 3);
        row.push_back(b);
        row.push_back(reach[b]);
        pack_row(bodies, b, trait::ghosted, row);
      }
    }
  }

  const auto incoming = comm.exchange(outgoing);
  const std::size_t width = 5 + packed_row_width(bodies, trait::ghosted);
  // Fields grow once, and by no more than they need.
  std::size_t arriving = 0;
  for (const auto& rows : incoming) arriving += rows.size();
  const std::size_t size = bodies.owned + arriving / width;
  for_each_field(bodies, [&](const auto&, auto& field) { field.reserve(size); });
  std::vector<Origin> origins;
  shifts.clear();
  for (int rank = 0; rank < comm.size; ++rank) {
    const auto& rows = incoming[rank];
    for (std::size_t k = 0; k < rows.size(); k += width) {
      shifts.emplace_back(rows[k], rows[k + 1], rows[k + 2]);
      origins.push_back({rank, static_cast<Index>(rows[k + 3])});
      reach.push_back(rows[k + 4]);
      unpack_rows(bodies, std::span(rows).subspan(k + 5, width - 5), trait::ghosted);
      bodies.position.back() += shifts.back();
    }
  }
  return Ghosts(comm, bodies.owned, origins);
}

void refresh_ghosts(const Ghosts& ghosts, Bodies& bodies) {
  const auto for_each_refreshed = [&](auto&& f) {
    for_each_field(bodies, [&]<class T>(const TypedField<T>& info, auto& field) {
      if (info.is(trait::refreshed))
        f(reinterpret_cast<double*>(field.data()), static_cast<int>(packed_width<T>));
    });
  };
  for_each_refreshed([&](double* rows, int width) { ghosts.gather_begin(rows, width); });
  for_each_refreshed([&](double* rows, int width) { ghosts.gather_end(rows, width); });
}

}  // namespace spall
