// A field that is one line of the table, which CMake adds: it migrates, is ghosted, refreshed,
// restarted and written. One rank is enough where nothing travels.
// SPDX-License-Identifier: BSD-3-Clause
#include "domain/halo.hpp"
#include "domain/migration.hpp"
#include "gravity/map.hpp"
#include "output/h5.hpp"
#include "output/restart.hpp"
#include "output/snapshot.hpp"
#include "scene/scene.hpp"
#include "testing.hpp"

namespace spall {

// What snapshots ask of rooms that are not built again for this test.
FieldSet fields_of(const Case&) {
  return FieldSet::all();
}
GravityMap map_gravity(const Comm&, const GravitySettings&, const Bodies&, const Grid&) {
  throw std::logic_error("no map here");
}

namespace {

constexpr double initial = 0.25;

Vec3 added_of(BodyId id) {
  return Vec3::Constant(std::sqrt(static_cast<double>(id + 2)));
}

/// A row of touching spheres, dealt over the ranks.
Bodies row_of_spheres(const Comm& comm, BodyId count) {
  Bodies bodies;
  for (BodyId id = comm.rank; id < count; id += comm.size) {
    const Index b = append_row(bodies);
    EXPECT_EQ(bodies.added[b], Vec3::Constant(initial));
    bodies.id[b] = id;
    bodies.radius[b] = 0.5;
    bodies.mass[b] = 1;
    bodies.position[b].x() = static_cast<double>(id);
    bodies.added[b] = added_of(id);
  }
  bodies.owned = bodies.size();
  return bodies;
}

void expect_own_values(const Bodies& bodies) {
  ASSERT_EQ(bodies.added.size(), bodies.id.size());
  for (Index b = 0; b < bodies.size(); ++b) EXPECT_EQ(bodies.added[b], added_of(bodies.id[b]));
}

TEST(AddedField, goes_with_its_body_to_other_ranks_and_to_ghosts) {
  const Comm comm = testing_world();
  Bodies bodies = row_of_spheres(comm, 40);
  std::vector<int> owner(bodies.owned);
  for (Index b = 0; b < bodies.owned; ++b)
    owner[b] = static_cast<int>(bodies.id[b] * comm.size / 40);
  SharedContacts memory;
  migrate(comm, bodies, memory, owner);
  expect_own_values(bodies);
  std::vector<double> reach(bodies.owned, 0.1);
  const Ghosts ghosts = make_halo(comm, bodies, reach);
  EXPECT_EQ(bodies.ghosts() > 0, comm.size > 1);
  expect_own_values(bodies);
  for (Index b = 0; b < bodies.size(); ++b)
    bodies.added[b] = b < bodies.owned ? Vec3(2 * bodies.added[b]) : Vec3::Zero();
  refresh_ghosts(ghosts, bodies);
  for (Vec3& added : bodies.added) added /= 2;
  expect_own_values(bodies);
}

TEST(AddedField, stands_in_restart_files_and_in_snapshots_with_its_unit) {
  const Comm comm = testing_world();
  RestartState state;
  state.bodies = row_of_spheres(comm, 40);
  const std::string folder = fmt::format("add_field_{}", comm.size);
  SnapshotWriter writer(comm, folder, Case{}, {});
  writer.write(state.bodies, 3, 0.5);
  writer.write_index();
  write_restart(comm, folder + "/restart.h5", state);
  expect_own_values(read_restart(comm, folder + "/restart.h5").bodies);
  EXPECT_NE(describe_output_fields().find("added"), std::string::npos);
  if (comm.rank != 0) return;
  for (const char* name : {"/snapshots/000000.h5", "/trajectory.h5"}) {
    const auto file = h5::File::open(folder + name);
    const auto values = file.read<Vec3>("/particles/all/added/value");
    ASSERT_EQ(values.size(), 40u);
    for (BodyId id = 0; id < 40; ++id) EXPECT_EQ(values[id], added_of(id));
    char unit[8] = {};
    const h5::Handle attribute(
        H5Aopen_by_name(file.id(), "/particles/all/added/value", "unit", H5P_DEFAULT, H5P_DEFAULT),
        H5Aclose);
    const h5::Handle type(H5Aget_type(attribute), H5Tclose);
    H5Aread(attribute, type, unit);
    EXPECT_STREQ(unit, "Pa");
  }
}

TEST(AddedField, comes_and_goes_with_requests) {
  Bodies bodies = row_of_spheres(Comm(MPI_COMM_SELF), 3);
  set_fields(bodies, {});
  EXPECT_TRUE(bodies.added.empty());
  set_fields(bodies, {Field::added});
  EXPECT_EQ(bodies.added, std::vector<Vec3>(3, Vec3::Constant(initial)));
}

}  // namespace
}  // namespace spall
