// How bodies are shared out: ghosts and imbalance of both cuts, in four shapes.
// usage: mpirun -n RANKS bench_partition [points along an edge]
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/partition.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <functional>
#include <random>

#include "domain/halo.hpp"
#include "domain/migration.hpp"

using namespace spall;

namespace {

using Uniform = std::function<double()>;  // in [0, 1)

/// Calls `add` with the places of unit spheres.
struct Shape {
  const char* name;
  void (*fill)(int n, const Uniform& uniform, const std::function<void(const Vec3&)>& add);
};

void fill_box(const Vec3& low, const std::array<int, 3>& counts,
              const std::function<void(const Vec3&)>& add) {
  for (int z = 0; z < counts[2]; ++z)
    for (int y = 0; y < counts[1]; ++y)
      for (int x = 0; x < counts[0]; ++x) add(low + Vec3(x, y, z));
}

Vec3 shaken(const Vec3& x, const Uniform& uniform) {
  const double dx = uniform(), dy = uniform(), dz = uniform();
  return x + 0.3 * Vec3(dx, dy, dz);
}

const Shape shapes[] = {
    {"cube",
     [](int n, const Uniform& uniform, const auto& add) {
       fill_box(Vec3::Zero(), {n, n, n}, [&](const Vec3& x) { add(shaken(x, uniform)); });
     }},
    {"ball",
     [](int n, const Uniform& uniform, const auto& add) {
       const double half = n / 2.0;
       fill_box(Vec3::Constant(-half), {n, n, n}, [&](const Vec3& x) {
         const Vec3 place = shaken(x, uniform);
         if (place.norm() < half) add(place);
       });
     }},
    {"plate and ball",
     [](int n, const Uniform&, const auto& add) {
       fill_box(Vec3::Zero(), {3 * n, 3 * n, n / 9}, add);
       const double radius = n / 6.0;
       fill_box(Vec3::Constant(-radius), {n / 3, n / 3, n / 3}, [&](const Vec3& x) {
         if (x.norm() < radius) add(x + Vec3(1.5 * n, 1.5 * n, n / 9 + 2 + radius));
       });
     }},
    {"cube in its debris",  // a fifth of all, up to 55 times as far away as it was
     [](int n, const Uniform& uniform, const auto& add) {
       fill_box(Vec3::Constant(-n / 2.0), {n, n, n}, [&](const Vec3& x) {
         const bool flies = uniform() < 0.2;
         add((flies ? std::exp(4 * uniform()) : 1) * shaken(x, uniform));
       });
     }},
};

void measure(const Comm& comm, const Shape& shape, int n, Cut by) {
  std::mt19937_64 random(7);
  const Uniform uniform = [&] { return std::ldexp(static_cast<double>(random() >> 11), -53); };
  Bodies mine;
  BodyId count = 0;
  shape.fill(n, uniform, [&](const Vec3& x) {
    const BodyId id = count++;
    if (id % comm.size != comm.rank) return;
    resize(mine, mine.size() + 1);
    mine.id.back() = id;
    mine.position.back() = x;
    mine.radius.back() = 0.5;
  });
  mine.owned = mine.size();
  SharedContacts none;
  for (int cut = 0; cut < 2; ++cut)  // METIS's cells depend on where bodies are at first
    migrate(comm, mine, none, partition(comm, mine, std::vector<double>(mine.owned, 1.0), by));
  std::vector<double> reach(mine.owned, 0.05);
  const Ghosts halo = make_halo(comm, mine, reach);
  const double ghosts = halo.ghosts();
  const double mean = comm.sum(ghosts) / comm.size, most = comm.max(ghosts);
  const double uneven = imbalance(comm, mine.owned);
  if (comm.rank == 0)
    fmt::print("{},{},{},{},{:.0f},{:.0f},{:.3f}\n", shape.name, count, comm.size,
               by == Cut::metis ? "metis" : "bisection", mean, most, uneven);
}

}  // namespace

int main(int argc, char** argv) {
  Session session;
  const int n = argc > 1 ? std::atoi(argv[1]) : 40;
  for (const Shape& shape : shapes)
    for (Cut by : {Cut::bisection, Cut::metis}) measure(session.world(), shape, n, by);
}
