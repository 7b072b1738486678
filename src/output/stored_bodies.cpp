// Reads what a packing needs from a restart file; what moved there comes to rest.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/stored_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numeric>

#include "output/h5.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

std::vector<StoredBody> read_bodies(const std::string& path) {
  const auto file = h5::File::open(path);
  const auto id = file.read<BodyId>("/bodies/id");
  const auto position = file.read<Vec3>("/bodies/position");
  const auto radius = file.read<double>("/bodies/radius"), mass = file.read<double>("/bodies/mass");
  // Rows lie as they were distributed over ranks; ids are the same for any number of them.
  std::vector<std::size_t> order(id.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t row) { return id[row]; });
  double all = 0;
  Vec3 center = Vec3::Zero();
  for (std::size_t row : order) {
    require(std::isfinite(mass[row]), "its body {} is fixed", id[row]);
    all += mass[row];
    center += mass[row] * position[row];
  }
  center /= all;
  std::vector<StoredBody> bodies;
  for (std::size_t row : order) bodies.push_back({position[row] - center, radius[row], mass[row]});
  return bodies;
}

}  // namespace

Case with_stored_bodies(Case scene) {
  for (Group& group : scene.groups) {
    Packing& packing = group.packing;
    if (packing.file.empty() || !packing.stored.empty()) continue;
    require(std::filesystem::is_regular_file(packing.file), "{}: there is no file '{}'",
            group.place, packing.file);
    try {
      packing.stored = read_bodies(packing.file);
    } catch (const std::exception& error) {
      throw Error(fmt::format(
          "{}: '{}' is not a restart file, such as after_<phase>.h5 of an earlier run: {}",
          group.place, packing.file, error.what()));
    }
  }
  return scene;
}

}  // namespace spall
