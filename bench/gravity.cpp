// Error against time of the gravity methods, as CSV: bench_gravity ball|plummer|pile BODIES.
// SPDX-License-Identifier: BSD-3-Clause
#include <malloc.h>
#include <time.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <random>
#include <string>

#include "gravity/attract.hpp"
#include "gravity/direct.hpp"
#include "gravity/essential_tree.hpp"
#include "gravity/tree.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

struct Points {
  std::vector<double> mass;
  std::vector<Vec3> position;
  std::size_t size() const { return mass.size(); }
};

/// "ball": homogeneous. "plummer": a core and a halo. "pile": two touching balls, radii 10 : 1 and
/// of one density, in an ejecta cloud a hundred radii wide that holds a tenth of the bodies.
Points make_set(const std::string& name, std::size_t count) {
  require(name == "ball" || name == "plummer" || name == "pile",
          "set '{}': must be ball, plummer or pile", name);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Points points;
  while (points.size() < count) {
    Vec3 x(uniform(random), uniform(random), uniform(random));
    if (x.norm() > 1) continue;
    double mass = 1;
    if (name == "plummer")
      x /= x.norm() * std::sqrt(std::pow((1 + uniform(random)) / 2, -2.0 / 3) - 1);
    const double part = name == "pile" ? uniform(random) : 1;  // -1 … 1
    if (part < -0.8) {
      x = x.normalized() * std::pow(10, 1 + uniform(random));
      mass = 1e-2;
    } else if (part < 0.1) {
      x = 0.1 * x + Vec3(1.1, 0, 0);
      mass = 1e-3;
    }
    points.position.push_back(x);
    points.mass.push_back(mass);
  }
  return points;
}

std::vector<Eight> pack(const Points& points, std::size_t stride) {
  const std::size_t count = (points.size() + stride - 1) / stride;
  std::vector<Eight> eights((count + lane_count - 1) / lane_count);
  for (std::size_t k = 0; k < eights.size() * lane_count; ++k) {
    const std::size_t b = std::min(k, count - 1) * stride;
    Eight& e = eights[k / lane_count];
    e.x[k % lane_count] = points.position[b].x();
    e.y[k % lane_count] = points.position[b].y();
    e.z[k % lane_count] = points.position[b].z();
    e.mass[k % lane_count] = k < count ? points.mass[b] : 0;
  }
  return eights;
}

/// The exact acceleration of every `stride`-th body.
std::vector<Vec3> exact_sample(const Points& points, std::size_t stride) {
  std::vector<Eight> sample = pack(points, stride), all = pack(points, 1);
  const std::span<Eight> sources[] = {all};
  attract<false, false>(sample, sources);
  std::vector<Vec3> result;
  for (std::size_t k = 0; k * stride < points.size(); ++k) {
    const Pull& pull = sample[k / lane_count].pull;
    const std::size_t lane = k % lane_count;
    result.emplace_back(pull.x[lane], pull.y[lane], pull.z[lane]);
  }
  return result;
}

/// The tree as every rank needs it: grown, measured and exchanged.
void complete(const Comm& comm, const TreeSettings& settings, Octree octree) {
  switch (settings.order) {
    case 4:
      EssentialTree<4>(comm, std::move(octree), settings);
      break;
    case 6:
      EssentialTree<6>(comm, std::move(octree), settings);
      break;
    default:
      EssentialTree<8>(comm, std::move(octree), settings);
  }
}

/// Processor time of the slowest rank: on a machine of one's own it is the time that passes, on a
/// shared one it still tells codes apart.
template <class F>
double seconds(const Comm& comm, F&& f) {
  check_mpi(MPI_Barrier(comm.raw), "MPI_Barrier");
  const auto now = [] {
    timespec time;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return time.tv_sec + 1e-9 * time.tv_nsec;
  };
  const double start = now();
  f();
  return comm.max(now() - start);
}

/// Largest memory of a rank since `forget_peak`, bytes; Linux keeps it.
void forget_peak() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}
double peak_memory() {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);)
    if (line.starts_with("VmHWM:")) return 1024 * std::stod(line.substr(6));
  return 0;
}

double median(std::vector<double> values) {
  std::ranges::sort(values);
  return values[values.size() / 2];
}

void run(const Comm& comm, const std::string& name, std::size_t count) {
  const Points all = make_set(name, count);
  Points mine, few;  // every rank a stretch of the rows; few: for the time of the exact sum
  const std::size_t direct_count = std::min<std::size_t>(count, 8000);
  for (std::size_t b = comm.rank * count / comm.size; b < (comm.rank + 1) * count / comm.size;
       ++b) {
    mine.mass.push_back(all.mass[b]);
    mine.position.push_back(all.position[b]);
    if (mine.size() <= direct_count / comm.size) {
      few.mass.push_back(all.mass[b]);
      few.position.push_back(all.position[b]);
    }
  }
  const std::size_t stride = std::max<std::size_t>(1, count / 4000);
  const std::vector<Vec3> exact = exact_sample(all, stride);
  const double few_count = comm.sum(static_cast<double>(few.size()));
  // The sum that other codes are compared with meets each pair twice.
  std::vector<Eight> plain = pack(few, 1), plain_sources = plain;
  const std::span<Eight> sources[] = {plain_sources};
  const double plain_scale = 1.0 * count * count / few.size() / few.size() / comm.size;

  const bool large = count > 200000;  // fewer accuracies, once: it takes minutes all the same
  const auto accuracies = large ? std::vector{1e-2, 1e-3, 1e-4, 1e-5}
                                : std::vector{1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5};
  for (double accuracy : accuracies) {
    const TreeSettings settings = tree_settings(accuracy);
    GravityField field;
    std::vector<double> tree_times, build_times, exchange_times, direct_times, plain_times;
    field = {};
    forget_peak();
    const double before = comm.sum(peak_memory());
    field = evaluate_gravity_tree(comm, 1, settings, mine.mass, mine.position, {});
    const double memory = comm.sum(peak_memory()) - before;
    for (int repeat = 0; repeat < (large ? 1 : 5); ++repeat) {
      tree_times.push_back(seconds(comm, [&] {
        field = evaluate_gravity_tree(comm, 1, settings, mine.mass, mine.position, {});
      }));
      Octree octree;
      build_times.push_back(seconds(comm, [&] {
        octree =
            grow_octree(comm, mine.mass, mine.position, {}, settings.leaf_size, settings.reach());
      }));
      exchange_times.push_back(seconds(comm, [&] { complete(comm, settings, std::move(octree)); }));
      const double scale = count / few_count * (count / few_count);
      direct_times.push_back(scale * seconds(comm, [&] {
                               evaluate_gravity_direct(comm, 1, few.mass, few.position, {}, false);
                             }));
      plain_times.push_back(plain_scale *
                            seconds(comm, [&] { attract<false, false>(plain, sources); }));
    }
    std::vector<double> found(3 * exact.size());
    Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
    double forces = 0, torques = 0;
    for (std::size_t b = 0; b < mine.size(); ++b) {
      const std::size_t row = comm.rank * count / comm.size + b;
      if (row % stride == 0) Vec3::Map(&found[3 * (row / stride)]) = field.acceleration[b];
      const Vec3 f = mine.mass[b] * field.acceleration[b];
      force += f;
      torque += mine.position[b].cross(f);
      forces += f.norm();
      torques += mine.position[b].norm() * f.norm();
    }
    comm.sum(found);
    force = comm.sum(force);
    torque = comm.sum(torque);
    forces = comm.sum(forces);
    torques = comm.sum(torques);
    std::vector<double> errors;
    double squares = 0;
    for (std::size_t k = 0; k < exact.size(); ++k) {
      errors.push_back((Vec3::Map(&found[3 * k]) - exact[k]).norm() / exact[k].norm());
      squares += errors.back() * errors.back();
    }
    std::ranges::sort(errors);
    if (comm.rank == 0)
      fmt::print(
          "{},{},{},{},{:.0e},{:.3e},{:.3e},{:.3e},{:.5f},{:.5f},{:.5f},{:.5f},{:.5f},{:.0f},{:.1e}"
          ",{:.1e}"
          "\n",
          name, count, comm.size, settings.order, accuracy, std::sqrt(squares / errors.size()),
          errors[errors.size() * 99 / 100], errors.back(), median(tree_times), median(build_times),
          median(exchange_times), median(direct_times), median(plain_times),
          memory / static_cast<double>(count), force.norm() / forces, torque.norm() / torques);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace spall

int main(int argc, char** argv) {
  spall::Session session;
  try {
    spall::require(argc == 3, "usage: bench_gravity ball|plummer|pile BODIES");
    spall::run(session.world(), argv[1], std::stoul(argv[2]));
  } catch (const std::exception& error) {
    spall::Session::abort_all(error.what());
  }
}
