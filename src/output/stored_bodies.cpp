// Reads what a packing needs from a restart file.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/stored_bodies.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "output/h5.hpp"
#include "output/seal.hpp"
#include "scene/consistency.hpp"
#include "scene/shape.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

/// What no file of bodies may hold, whoever wrote it; `id` in any order.
void check_bodies(std::vector<BodyId> id, const std::vector<Vec3>& position,
                  const std::vector<Vec3>& velocity, const std::vector<Vec3>& spin,
                  const std::vector<double>& radius, const std::vector<double>& mass) {
  require(!id.empty(), "it holds no bodies");
  for (std::size_t rows :
       {position.size(), velocity.size(), spin.size(), radius.size(), mass.size()})
    require(rows == id.size(), "it has {} bodies, but one of their fields has {} rows", id.size(),
            rows);
  for (std::size_t row = 0; row < id.size(); ++row) {
    require(position[row].allFinite() && velocity[row].allFinite() && spin[row].allFinite(),
            "body {} has no finite place, velocity or spin", id[row]);
    require(std::isfinite(radius[row]) && radius[row] > 0, "body {} has the radius {} m", id[row],
            radius[row]);
    require(mass[row] > 0, "body {} has the mass {} kg", id[row], mass[row]);
  }
  std::ranges::sort(id);
  const auto twice = std::ranges::adjacent_find(id);
  require(twice == id.end(), "two bodies have the id {}", twice == id.end() ? 0 : *twice);
}

struct StoredRun {
  Vec3 period;  ///< m
  std::vector<StoredBody> bodies;
};

StoredRun read_bodies(const std::string& path) {
  if (!begins_as_hdf5(path)) check_seal(Comm(MPI_COMM_SELF), path);
  const auto file = h5::File::open(path);
  const auto id = file.read<BodyId>("/bodies/id");
  const auto position = file.read<Vec3>("/bodies/position");
  const auto velocity = file.read<Vec3>("/bodies/velocity");
  const auto radius = file.read<double>("/bodies/radius"), mass = file.read<double>("/bodies/mass");
  if (file.exists("/bodies/shape")) {
    const auto shape = file.read<std::int32_t>("/bodies/shape");
    require(std::ranges::all_of(shape, [](std::int32_t s) { return s == 0; }),
            "its bodies have shapes, which packings of a file do not know");
  }
  std::vector<Vec3> spin(id.size(), Vec3::Zero());
  if (file.exists("/bodies/angular_velocity")) spin = file.read<Vec3>("/bodies/angular_velocity");
  std::vector<double> damage(id.size(), 0.0);
  if (file.exists("/bodies/damage")) damage = file.read<double>("/bodies/damage");
  std::vector<std::int32_t> material(id.size(), 0);
  if (file.exists("/bodies/material")) material = file.read<std::int32_t>("/bodies/material");
  // Files before 2026-12-01 do not tell it.
  const Vec3 period =
      file.exists("/periodic/size") ? file.read<Vec3>("/periodic/size").at(0) : Vec3(Vec3::Zero());
  check_bodies(id, position, velocity, spin, radius, mass);
  // Rows lie as they were distributed over ranks; ids are the same for any number of them.
  std::vector<std::size_t> order(id.size());
  std::iota(order.begin(), order.end(), 0);
  std::ranges::sort(order, {}, [&](std::size_t row) { return id[row]; });
  const auto is_fixed = [&](std::size_t row) { return !std::isfinite(mass[row]); };
  // Where nothing moves there is no centre of mass but that of equal densities.
  const bool all_fixed = std::ranges::all_of(order, is_fixed);
  double all = 0;
  Vec3 center = Vec3::Zero();
  for (std::size_t row : order) {
    if (is_fixed(row) && !all_fixed) continue;
    const double weight = all_fixed ? ball_volume(radius[row]) : mass[row];
    all += weight;
    center += weight * position[row];
  }
  center /= all;
  std::vector<StoredBody> bodies;
  for (std::size_t row : order)
    bodies.push_back({.position = position[row] - center,
                      .radius = radius[row],
                      .mass = is_fixed(row) ? 0 : mass[row],
                      .velocity = velocity[row],
                      .spin = spin[row],
                      .fixed = is_fixed(row),
                      .damage = damage[row],
                      .material = material[row]});
  return {period, bodies};
}

std::vector<double> rows_of(const StoredRun& run) {
  std::vector<double> rows(run.period.data(), run.period.data() + 3);
  for (const StoredBody& body : run.bodies) {
    for (const Vec3* vector : {&body.position, &body.velocity, &body.spin})
      rows.insert(rows.end(), vector->data(), vector->data() + 3);
    rows.insert(rows.end(), {body.radius, body.mass, body.fixed ? 1.0 : 0.0, body.damage,
                             static_cast<double>(body.material)});
  }
  return rows;
}

StoredRun run_of(const std::vector<double>& rows) {
  constexpr std::size_t width = 14;
  std::vector<StoredBody> bodies;
  for (std::size_t at = 3; at < rows.size(); at += width) {
    const double* row = &rows[at];
    bodies.push_back({.position = Vec3(row[0], row[1], row[2]),
                      .radius = row[9],
                      .mass = row[10],
                      .velocity = Vec3(row[3], row[4], row[5]),
                      .spin = Vec3(row[6], row[7], row[8]),
                      .fixed = row[11] == 1,
                      .damage = row[12],
                      .material = static_cast<int>(row[13])});
  }
  return {Vec3(rows[0], rows[1], rows[2]), bodies};
}

}  // namespace

Case with_stored_bodies(Case scene, const InputFiles& files) {
  for (Group& group : scene.groups) {
    Packing& packing = group.packing;
    if (packing.file.empty() || !packing.stored.empty()) continue;
    require(files.exists(packing.file), "{}: there is no file '{}'", group.place, packing.file);
    try {
      StoredRun run = run_of(files.numbers([&] { return rows_of(read_bodies(packing.file)); }));
      packing.stored = std::move(run.bodies);
      packing.stored_period = run.period;
    } catch (const std::exception& error) {
      throw Error(fmt::format(
          "{}: '{}' is not a restart file, such as after_<phase>.h5 of an earlier run: {}",
          group.place, packing.file, error.what()));
    }
  }
  check_stored_damage(scene);
  for (const Group& group : scene.groups) {
    const bool has_fixed = std::ranges::any_of(group.packing.stored, &StoredBody::fixed);
    require(!has_fixed || (group.velocity.isZero(0) && group.spin.isZero(0)),
            "{}: velocity and spin would move bodies of '{}' that are fixed", group.place,
            group.packing.file);
    require(!has_fixed || scene.gravity.method == GravityMethod::none,
            "{}: '{}' has fixed bodies, and self-gravity needs finite masses", group.place,
            group.packing.file);
    for (const Phase& phase : scene.phases) {
      require(!has_fixed || !phase.remove_drift,
              "{}: '{}' has fixed bodies: they would stay where they are while {}.remove_drift "
              "moves all others",
              group.place, group.packing.file, phase.place);
      require(!has_fixed || !phase.impactor || !phase.impactor->coupling,
              "{}: '{}' has fixed bodies: they would take a part of the recoil of {}.impactor, "
              "which is the free target's",
              group.place, group.packing.file, phase.place);
    }
  }
  return scene;
}

}  // namespace spall
