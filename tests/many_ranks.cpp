// On 64 ranks, and on 8 of them with as many bodies each: who hears of whom, and how much.
// SPDX-License-Identifier: BSD-3-Clause
#include <malloc.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <new>
#include <random>

#include "base/traffic.hpp"
#include "domain/bisection.hpp"
#include "domain/halo.hpp"
#include "domain/migration.hpp"
#include "engine/engine.hpp"
#include "gravity/essential_tree.hpp"
#include "gravity/field.hpp"
#include "spall/spall.hpp"
#include "state/world.hpp"
#include "testing.hpp"

namespace {

std::int64_t bytes_held = 0, most_held = 0;  // by what `new` gave

void* allocate(std::size_t size, std::size_t alignment) {
  const std::size_t whole =
      (std::max<std::size_t>(size, 1) + alignment - 1) / alignment * alignment;
  void* const place = std::aligned_alloc(alignment, whole);
  if (place == nullptr) throw std::bad_alloc();
  bytes_held += static_cast<std::int64_t>(malloc_usable_size(place));
  most_held = std::max(most_held, bytes_held);
  return place;
}

void release(void* place) {
  if (place != nullptr) bytes_held -= static_cast<std::int64_t>(malloc_usable_size(place));
  std::free(place);
}

}  // namespace

void* operator new(std::size_t size) {
  return allocate(size, alignof(std::max_align_t));
}
void* operator new(std::size_t size, std::align_val_t alignment) {
  return allocate(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* place) noexcept {
  release(place);
}
void operator delete(void* place, std::size_t) noexcept {
  release(place);
}
void operator delete(void* place, std::align_val_t) noexcept {
  release(place);
}
void operator delete(void* place, std::size_t, std::align_val_t) noexcept {
  release(place);
}

namespace spall {
namespace {

/// The first `size` ranks of all; `f` is called on them alone.
template <class F>
void on_ranks(int size, F&& f) {
  const Comm world = testing_world();
  MPI_Comm part = MPI_COMM_NULL;
  MPI_Comm_split(world.raw, world.rank < size ? 0 : MPI_UNDEFINED, world.rank, &part);
  if (part == MPI_COMM_NULL) return;
  f(Comm(part));
  MPI_Comm_free(&part);
}

constexpr int bodies_a_rank = 125;

/// This rank's part, by bisection, of spheres near the points of a cubic lattice.
Bodies lattice(const Comm& comm, int ranks) {
  const auto n = static_cast<int>(std::lround(std::cbrt(bodies_a_rank * ranks)));
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> uniform(-0.2, 0.2);
  Bodies mine;
  for (int k = 0; k < n * n * n; ++k) {
    const Vec3 x =
        Vec3(k % n, k / n % n, k / n / n) + Vec3(uniform(random), uniform(random), uniform(random));
    if (k % comm.size != comm.rank) continue;
    resize(mine, mine.size() + 1);
    mine.id.back() = k;
    mine.position.back() = x;
    mine.radius.back() = 0.5;
    mine.mass.back() = 1;
  }
  mine.owned = mine.size();
  SharedContacts memory;
  for (int cut = 0; cut < 2; ++cut)
    migrate(comm, mine, memory, bisect(comm, mine, std::vector<double>(mine.owned, 1.0)));
  return mine;
}

Bodies lattice(const Comm& comm) {
  return lattice(comm, comm.size);
}

TEST(ManyRanks, a_halo_comes_from_neighbours_and_takes_as_many_bytes_a_ghost) {
  double bytes_a_ghost[2] = {};
  for (int k = 0; k < 2; ++k)
    on_ranks(k == 0 ? 8 : 64, [&](const Comm& comm) {
      Bodies mine = lattice(comm);
      std::vector<double> reach(mine.owned, 0.05);
      traffic() = {};
      const Ghosts ghosts = make_halo(comm, mine, reach);
      const Traffic halo = traffic();
      // 4 x 4 x 4 boxes have 26 neighbours at most; planes of later cuts do not meet edge to edge.
      EXPECT_LE(halo.sources, 26 + 6);
      // The one thing that all ranks know of all: a box each.
      EXPECT_LE(halo.gathered, 64 * comm.size);
      bytes_a_ghost[k] = comm.sum(static_cast<double>(halo.bytes)) /
                         comm.sum(static_cast<double>(ghosts.ghosts()));
      traffic() = {};
      refresh_ghosts(ghosts, mine);
      EXPECT_LE(traffic().sources, 26 + 6);
      EXPECT_EQ(traffic().collectives, 0);
    });
  if (testing_world().rank < 8) {
    EXPECT_LT(bytes_a_ghost[1], 1.1 * bytes_a_ghost[0]);
  }
}

TEST(ManyRanks, the_tree_of_gravity_gives_the_exact_field) {
  on_ranks(64, [](const Comm& comm) {
    const Bodies mine = lattice(comm);
    GravitySettings settings;
    settings.constant = 1;
    settings.accuracy = 1e-3;
    GravityField field[2];
    for (int k = 0; k < 2; ++k) {
      settings.method = k == 0 ? GravityMethod::direct : GravityMethod::tree;
      field[k] = evaluate_gravity(comm, settings, mine.mass, mine.position, {});
    }
    double squares = 0, errors = 0;
    for (Index b = 0; b < mine.owned; ++b) {
      squares += field[0].acceleration[b].squaredNorm();
      errors += (field[1].acceleration[b] - field[0].acceleration[b]).squaredNorm();
    }
    EXPECT_LT(std::sqrt(comm.sum(errors) / comm.sum(squares)), settings.accuracy);
  });
}

constexpr int order = 4;
constexpr TreeSettings coarse{.order = order, .accuracy = 0.1};

/// Bytes of what this rank holds of others' cells and bodies, and of its bodies' way there.
double bytes_needed(const Comm& comm, const EssentialTree<order>& tree) {
  const std::vector<Cell>& cells = tree.octree.cells;
  std::size_t numbers = 4 * lane_count * tree.others.size();
  for (std::size_t c = 0; c < cells.size(); ++c) {
    const bool made_here = cells[c].inner() && cells[c].children[0] < static_cast<Index>(c);
    if (cells[c].holder == Cell::Holder::elsewhere && !made_here)
      numbers += Moments<order>::width + 4;
  }
  for (const auto& [rank, bodies] : tree.octree.went)
    if (rank != comm.rank) numbers += body_width(false) * bodies;
  return static_cast<double>(sizeof(double) * numbers);
}

TEST(ManyRanks, gravity_asks_near_ranks_and_as_little_of_each) {
  double more_bytes_a_message[2] = {};
  for (int k = 0; k < 2; ++k)
    on_ranks(k == 0 ? 8 : 64, [&](const Comm& comm) {
      const Bodies mine = lattice(comm);
      traffic() = {};
      const EssentialTree<order> tree(
          comm, grow_octree(comm, mine.mass, mine.position, {}, coarse.leaf_size, coarse.reach()),
          coarse);
      const Traffic told = traffic();
      EXPECT_EQ(told.gathered, 0);
      EXPECT_LE(told.sources, 26 + 6);
      const double more = comm.sum(static_cast<double>(told.bytes) - bytes_needed(comm, tree));
      more_bytes_a_message[k] = more / comm.sum(static_cast<double>(told.messages));
    });
  // A question has the asker's cells up to the root: twice as many levels above a rank's own.
  if (testing_world().rank < 8) {
    EXPECT_LT(more_bytes_a_message[1], 1.1 * std::log(64) / std::log(8) * more_bytes_a_message[0]);
  }
}

TEST(ManyRanks, what_gravity_tells_grows_with_the_logarithm_of_the_ranks) {
  if (testing_world().rank > 0) return;  // it tells what all would
  std::array<Traffic, 3> told;
  for (std::size_t k = 0; k < told.size(); ++k) {
    const int ranks = 8 << 3 * k;
    const Bodies all = lattice(alone(), ranks);
    const std::vector<int> owner = bisect(alone(), all, std::vector<double>(all.owned, 1.0), ranks);
    std::vector<int> sample;
    for (int n = 0; n < 8; ++n)
      sample.push_back(static_cast<int>(part_begin(ranks, 2 * n + 1, 16)));
    for (const TreeShare& share :
         foretell_gravity_tree(alone(), coarse, all.mass, all.position, {}, owner, ranks, sample))
      told[k].add(share.traffic);
  }
  // As much again for eight times the ranks; and fewer of them lie at the surface: in a cube of 8^3
  // ranks one touches 19.8 others in the mean, in a cube of 4^3 14.6.
  constexpr double more_neighbours = 1.36;
  for (auto count : {&Traffic::messages, &Traffic::bytes, &Traffic::collectives})
    EXPECT_LE(static_cast<double>(told[2].*count - told[1].*count),
              more_neighbours * static_cast<double>(told[1].*count - told[0].*count));
  for (const Traffic& of_sample : told) EXPECT_LE(of_sample.reduced, 8 * 128e3);
  EXPECT_EQ(told[2].gathered, 0);
}

constexpr double solved = 1e-10;
/// Where nothing is asked of impulses: 64 ranks on few cores wait long for each iteration.
constexpr double hardly_solved = 0.1;

/// A gas of grains in a cube of so many, with `more` keys.
Simulation gas(const Comm& comm, const std::string& method, double step, double tolerance,
               const std::string& more = "", int side = 10) {
  return Simulation(comm, Scene::from_text(fmt::format(R"(
[materials.rock]
density = 2000
[contact]
friction = 0.3
restitution = 0.8
[solver]
tolerance = {4}
max_iterations = 5000
[penalty]
model = "hooke"
stiffness = 1e6
[[groups]]
name = "gas"
material = "rock"
volume = {{shape = "box", size = [{0}, {0}, {0}]}}
packing = {{kind = "simple_cubic", radius = 0.1}}
thermal_velocity = {{rms = 1, seed = 3}}
[[phases]]
name = "only"
method = "{1}"
step = {2}
duration = 1
{3}
)",
                                                       0.2 * side, method, step, more, tolerance)));
}

/// J: the kinetic energy after some steps.
double energy_after(const Comm& comm, const std::string& method, double step) {
  Simulation simulation = gas(comm, method, step, solved);
  simulation.run_until(20 * step);
  return simulation.energies().kinetic;
}

/// Calls that all ranks take part in, of a step between searches: the median of some, without those
/// of the contact solver.
std::int64_t collectives_of_a_step(const std::string& method, const std::string& more = "") {
  Simulation simulation = gas(testing_world(), method, 1e-6, hardly_solved, more);
  simulation.step();
  std::vector<std::int64_t> calls;
  for (int step = 0; step < 9; ++step) {
    const auto of_solver = [&] { return simulation.world().stages["solver"].traffic.collectives; };
    const std::int64_t before = traffic().collectives - of_solver();
    simulation.advance(1, false);
    calls.push_back(traffic().collectives - of_solver() - before);
  }
  std::ranges::nth_element(calls, calls.begin() + 4);
  return calls[4];
}

TEST(ManyRanks, memory_of_a_rank_is_that_of_its_bodies_and_ghosts) {
  struct Kind {
    const char *method, *more;
    double growth;  // of what gravity tells, with the logarithm of the ranks
  };
  for (const auto& [method, more, growth] :
       {Kind{"nonsmooth", "", 1}, Kind{"penalty", "", 1},
        Kind{"penalty", "[gravity]\nmethod = \"tree\"\naccuracy = 1e-2", 2}}) {
    double bytes_a_row[2] = {};
    for (int k = 0; k < 2; ++k)
      on_ranks(k == 0 ? 8 : 64, [&](const Comm& comm) {
        const std::int64_t before = most_held = bytes_held;
        Simulation simulation = gas(comm, method, 1e-4, hardly_solved, more, k == 0 ? 10 : 20);
        simulation.advance(1, false);
        const Bodies& bodies = simulation.world().bodies;
        bytes_a_row[k] = comm.sum(static_cast<double>(most_held - before)) /
                         comm.sum(static_cast<double>(bodies.size()));
      });
    if (testing_world().rank < 8) {
      EXPECT_LT(bytes_a_row[1], 1.1 * growth * bytes_a_row[0]) << method << more;
    }
  }
}

TEST(ManyRanks, a_step_waits_for_all_ranks_four_times_at_most) {
  // A run asks once more after each step: for signals, restart files and lost bodies.
  for (const char* method : {"nonsmooth", "penalty"}) {
    const std::int64_t calls = collectives_of_a_step(method);
    EXPECT_LE(calls + 1, 4) << method;
    // Smooth forces carry a uniform field in their own kicks; rigid bodies sum its energy.
    const std::int64_t more = std::string_view(method) == "nonsmooth" ? 1 : 0;
    EXPECT_EQ(collectives_of_a_step(method, "[gravity]\nuniform = [0, 0, -1]"), calls + more)
        << method;
    // Its check, all bodies or their forces, and what follows from it.
    EXPECT_LE(collectives_of_a_step(method, "[gravity]\nmethod = \"direct\""), calls + 4) << method;
  }
}

TEST(ManyRanks, steps_agree_with_those_of_one_rank) {
  for (const auto& [method, step] : {std::pair{"nonsmooth", 1e-3}, std::pair{"penalty", 1e-4}}) {
    const double alone_energy = energy_after(alone(), method, step);
    const double energy = energy_after(testing_world(), method, step);
    EXPECT_NEAR(energy, alone_energy, 1e-6 * alone_energy) << method;
  }
}

}  // namespace
}  // namespace spall
