// Snapshots, restarts, series, results: what is written is what is read, whatever happens between.
// SPDX-License-Identifier: BSD-3-Clause
#include <sys/resource.h>
#include <toml++/toml.h>

#include <array>
#include <bit>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <random>

#include "../src/output/files.hpp"
#include "../src/output/h5.hpp"
#include "base/commit.hpp"
#include "base/first_rank.hpp"
#include "output/diagnostics.hpp"
#include "output/restart.hpp"
#include "output/results.hpp"
#include "output/seal.hpp"
#include "output/series.hpp"
#include "output/snapshot.hpp"
#include "output/stored_bodies.hpp"
#include "spall/error.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// A folder of this test and this number of ranks, empty at the start.
std::string fresh_folder(const Comm& comm) {
  const std::string folder = fmt::format(
      "output_{}_{}", ::testing::UnitTest::GetInstance()->current_test_info()->name(), comm.size);
  if (comm.rank == 0) std::filesystem::remove_all(folder);
  make_folder(comm, folder);
  return folder;
}

/// Body `id` with values that depend on it alone and fill all bits of a double.
void add_body(Bodies& bodies, BodyId id) {
  const auto x = static_cast<double>(id + 1);
  const Index row = append_row(bodies);
  bodies.id[row] = id;
  bodies.group[row] = static_cast<std::int32_t>(id % 3);
  bodies.material[row] = static_cast<std::int32_t>(id % 2);
  bodies.radius[row] = 1 / x;
  bodies.mass[row] = id == 0 ? infinity : std::sqrt(x);
  bodies.position[row] = Vec3(std::sin(x), std::cos(x), std::tan(x));
  bodies.velocity[row] = Vec3(std::exp(-x), -0.0, 5e-324 * x);
  bodies.angular_velocity[row] = Vec3(std::cbrt(x), 1e300 / x, -x);
  bodies.acceleration[row] = Vec3(x, -x, 1 / x);
}

/// `count` bodies, dealt over the ranks out of order.
Bodies dealt(const Comm& comm, BodyId count) {
  Bodies bodies;
  for (BodyId k = 0; k < count; ++k) {
    const BodyId id = (k * 7 + 3) % count;
    if ((id * id + id / 5) % comm.size == comm.rank) add_body(bodies, id);
  }
  bodies.owned = bodies.size();
  return bodies;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

void expect_same_bits(const Bodies& a, const Bodies& b) {
  EXPECT_EQ(a.owned, b.owned);
  EXPECT_EQ(a.fields, b.fields);
  std::map<std::string, std::vector<char>> bits;
  const auto for_each = [](const Bodies& bodies, auto&& f) {
    for_each_field(bodies, [&]<class T>(const TypedField<T>& info, const std::vector<T>& field) {
      const auto* first = reinterpret_cast<const char*>(field.data());
      f(info.name, std::vector<char>(first, first + field.size() * sizeof(T)));
    });
  };
  for_each(a, [&](const char* name, std::vector<char> field) { bits[name] = std::move(field); });
  for_each(b, [&](const char* name, const std::vector<char>& field) {
    EXPECT_EQ(bits[name], field) << name;
  });
}

TEST(Snapshot, row_k_is_body_k_with_the_same_bits_on_any_number_of_ranks) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  Case scene;
  scene.text = "title = \"test\"";
  for (const char* name : {"core", "shell", "dust"}) scene.groups.emplace_back().name = name;
  SnapshotWriter writer(comm, folder, scene, provenance_of(comm, scene));
  writer.write(dealt(comm, 71), 10, 0.1);
  writer.write(dealt(comm, 73), 20, 0.3);  // two were added
  Bodies expected;
  for (BodyId id = 0; id < 73; ++id) add_body(expected, id);

  if (comm.rank == 0) {
    auto file = h5::File::open(folder + "/snapshots/000001.h5");
    EXPECT_EQ(file.read<std::int64_t>("/particles/all/velocity/step").at(0), 20);
    EXPECT_EQ(file.read<double>("/particles/all/position/time").at(0), 0.3);
    EXPECT_EQ(file.read_text("/parameters/case"), scene.text);
    const h5::Rows rows{0, 73, 73};
    EXPECT_TRUE(same_bits(file.read<BodyId>("/particles/all/id/value"), expected.id));
    EXPECT_TRUE(same_bits(file.read<std::int32_t>("/particles/all/group", rows), expected.group));
    EXPECT_TRUE(same_bits(file.read<double>("/particles/all/radius", rows), expected.radius));
    EXPECT_TRUE(same_bits(file.read<double>("/particles/all/mass", rows), expected.mass));

    // The trajectory shows the frames as one dataset; what was not there yet is NaN.
    auto all = h5::File::open(folder + "/trajectory.h5");
    EXPECT_EQ(all.read<double>("/particles/all/velocity/time"), (std::vector{0.1, 0.3}));
    EXPECT_TRUE(same_bits(all.read<double>("/particles/all/radius", rows), expected.radius));
    const auto position = all.read<double>("/particles/all/position/value");
    for (int d = 0; d < 3; ++d) {
      for (int id = 0; id < 73; ++id)
        EXPECT_EQ(position[(73 + id) * 3 + d], expected.position[id][d]);
      EXPECT_EQ(position[70 * 3 + d], expected.position[70][d]);
      EXPECT_TRUE(std::isnan(position[71 * 3 + d]) && std::isnan(position[72 * 3 + d]));
    }
    const auto id = all.read<BodyId>("/particles/all/id/value");
    for (int k = 0; k < 73; ++k) {
      EXPECT_EQ(id[k], k < 71 ? k : -1);
      EXPECT_EQ(id[73 + k], k);
    }
    for (const h5::File* one : {&file, &all}) {
      const h5::Handle set(H5Dopen2(one->id(), "/particles/all/group", H5P_DEFAULT), H5Dclose);
      const h5::Handle type(H5Dget_type(set), H5Tclose);
      ASSERT_EQ(H5Tget_class(type), H5T_ENUM);
      char name[8] = {};
      const std::int32_t two = 2;
      H5Tenum_nameof(type, &two, name, sizeof(name));
      EXPECT_STREQ(name, "dust");
    }
    EXPECT_EQ(all.read<std::int32_t>("/particles/all/group"), expected.group);
    EXPECT_EQ(all.read<std::int32_t>("/particles/all/species"), expected.material);
    const std::string xdmf = read_whole(folder + "/trajectory.xdmf");
    EXPECT_NE(xdmf.find("snapshots/000001.h5:/particles/all/position/value"), std::string::npos);
  }
}

TEST(Provenance, stands_alike_in_snapshots_trajectories_and_results) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  Case scene;
  scene.title = "a \"test\"";
  scene.file = "folder/case.toml";
  scene.text = "title = 'a \"test\"'\n# two lines\n";
  scene.overrides = {"seed=7", "contact.friction=0.5"};
  scene.seed = 7;
  const Provenance provenance = provenance_of(comm, scene);
  SnapshotWriter writer(comm, folder, scene, provenance);
  writer.write(dealt(comm, 5), 0, 0);
  ResultTable table;
  table.add("case", "cohesion", 0.5);
  write_results(comm, folder, table, provenance);
  keep_case(comm, folder, "seed = 7\n");
  if (comm.rank == 0) {
    const toml::table results = toml::parse_file(folder + "/results.toml");
    const toml::table& told = *results["provenance"].as_table();
    EXPECT_EQ(*told["title"].value<std::string>(), scene.title);
    EXPECT_EQ(*told["case"].value<std::string>(), scene.text);
    EXPECT_EQ(*told["case_file"].value<std::string>(), scene.file);
    EXPECT_EQ(*told["overrides"].value<std::string>(), "seed=7\ncontact.friction=0.5\n");
    EXPECT_EQ(*told["seed"].value<int>(), 7);
    EXPECT_EQ(*told["ranks"].value<int>(), comm.size);
    EXPECT_NE(told["command"].value<std::string>()->find("test_output"), std::string::npos);
    EXPECT_EQ(*told["commit"].value<std::string>(), commit_of_build());
    EXPECT_EQ(told["date"].value<std::string>()->size(), std::strlen("2026-11-23T06:28:01Z"));
    for (const char* key : {"version", "host"})
      EXPECT_NE(told[key].value_or(std::string()), "") << key;
    for (const char* name : {"/snapshots/000000.h5", "/trajectory.h5"}) {
      const auto file = h5::File::open(folder + name);
      for (auto&& [key, node] : told) {
        const std::string place = "/parameters/" + std::string(key.str());
        if (node.is_integer())
          EXPECT_EQ(file.read<std::int64_t>(place).at(0), *node.value<std::int64_t>()) << place;
        else
          EXPECT_EQ(file.read_text(place), *node.value<std::string>()) << place;
      }
    }
    EXPECT_EQ(read_whole(folder + "/resolved_case.toml"), "seed = 7\n");
  }
  keep_case(comm, folder, "");
  EXPECT_FALSE(std::filesystem::exists(folder + "/resolved_case.toml"));
}

TEST(Snapshot, a_periodic_box_has_edges_and_a_lower_corner) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  Case scene;
  scene.period = {.low = Vec3(-1, -2, 0), .size = Vec3(2, 5, 0)};
  SnapshotWriter writer(comm, folder, scene, {});
  writer.write(dealt(comm, 5), 0, 0);
  if (comm.rank != 0) return;
  for (const char* name : {"/snapshots/000000.h5", "/trajectory.h5"}) {
    const auto file = h5::File::open(folder + name);
    EXPECT_EQ(file.read<double>("/particles/all/box/edges"), (std::vector<double>{2, 5, 0}));
    EXPECT_EQ(file.read<double>("/particles/all/box/offset"), (std::vector<double>{-1, -2, 0}));
  }
}

TEST(Snapshot, a_resumed_run_goes_on_and_a_new_one_starts_over) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  const auto times = [&] {
    return h5::File::open(folder + "/trajectory.h5").read<double>("/particles/all/position/time");
  };
  for (int run = 0; run < 2; ++run) {
    SnapshotWriter writer(comm, folder, {}, {});
    writer.begin();
    for (int step : {10, 20, 30}) writer.write(dealt(comm, 5), step, step);
  }
  if (comm.rank == 0) {
    EXPECT_EQ(times(), (std::vector<double>{10, 20, 30}));
    // A run killed while it wrote the next one.
    std::ofstream(folder + "/snapshots/000003.h5.unfinished") << "half a file";
    std::ofstream(folder + "/snapshots/averages.h5") << "of somebody else";
  }
  SnapshotWriter writer(comm, folder, {}, {}, 2);  // the restart was written before the third
  EXPECT_EQ(writer.last_step(), 20);
  writer.begin();
  writer.write(dealt(comm, 5), 25, 25);
  if (comm.rank == 0) {
    EXPECT_EQ(times(), (std::vector<double>{10, 20, 25}));
    EXPECT_FALSE(std::filesystem::exists(folder + "/snapshots/000003.h5.unfinished"));
    EXPECT_FALSE(std::filesystem::exists(folder + "/snapshots/000003.h5"));
    EXPECT_TRUE(std::filesystem::exists(folder + "/snapshots/averages.h5"));
  }
  for (int step = 26; step < 50; ++step) writer.write(dealt(comm, 5), step, step);
  writer.write_index();
  if (comm.rank == 0) {
    EXPECT_EQ(times().size(), 27u);
    EXPECT_EQ(times().back(), 49);
  }
}

TEST(Snapshot, that_is_lost_or_damaged_is_named_and_none_is_removed) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  {
    SnapshotWriter writer(comm, folder, {}, {});
    for (int step : {10, 20, 30, 40}) writer.write(dealt(comm, 5), step, step);
    EXPECT_EQ(writer.count(), 4);
  }
  const std::string second = folder + "/snapshots/000001.h5";
  const auto resumed = [&](std::int64_t kept) {
    return complaint_of([&] { SnapshotWriter(comm, folder, {}, {}, kept); });
  };
  on_first_rank(comm, [&] { write_whole(second, "no snapshot"); });
  EXPECT_NE(resumed(3).find("'" + second + "'"), std::string::npos) << resumed(3);
  on_first_rank(comm, [&] { std::filesystem::remove(second); });
  EXPECT_TRUE(resumed(3).starts_with("'" + second + "' is lost, one of 3 snapshots"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/snapshots/000003.h5"));
  EXPECT_EQ(resumed(1), "");
  EXPECT_TRUE(std::filesystem::exists(folder + "/snapshots/000003.h5"));
  SnapshotWriter(comm, folder, {}, {}, 1).begin();
  EXPECT_FALSE(std::filesystem::exists(folder + "/snapshots/000003.h5"));
}

TEST(Snapshot, a_map_of_gravity_lies_in_it_point_by_point) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  Bodies bodies = dealt(comm, 20);
  for (Index b = 0; b < bodies.owned; ++b) bodies.mass[b] = 1;
  Case scene;
  scene.gravity = {.method = GravityMethod::direct, .constant = 1};
  scene.gravity_map = Grid::in_box({0, 0, 0}, {4, 3, 0}, 0.5);
  SnapshotWriter writer(comm, folder, scene, {});
  writer.write(bodies, 0, 0);
  const GravityMap map = map_gravity(comm, scene.gravity, bodies, *scene.gravity_map);
  const std::vector<double> potential = comm.all_gather(map.potential);
  if (comm.rank == 0) {
    const auto file = h5::File::open(folder + "/snapshots/000000.h5");
    EXPECT_EQ(file.read<std::int64_t>("/fields/gravity/counts"),
              (std::vector<std::int64_t>{9, 7, 1}));
    EXPECT_EQ(file.read<Vec3>("/fields/gravity/low").at(0), Vec3(-2, -1.5, 0));
    EXPECT_EQ(file.read<double>("/fields/gravity/spacing").at(0), 0.5);
    EXPECT_EQ(file.read<double>("/fields/gravity/potential"), potential);
    EXPECT_EQ(file.read<Vec3>("/fields/gravity/acceleration").size(), 63u);
  }
}

TEST(Snapshot, missing_ids_are_an_error) {
  const Comm comm = testing_world();
  SnapshotWriter writer(comm, fresh_folder(comm), {}, {});
  Bodies bodies;
  if (comm.rank == 0) add_body(bodies, 4);
  bodies.owned = bodies.size();
  // Rank 0 holds the bad body; the others would wait for it, as in a run until main ends them.
  if (comm.size == 1) {
    EXPECT_THROW(writer.write(bodies, 0, 0), Error);
  }
}

RestartState some_state(const Comm& comm, BodyId bodies) {
  RestartState state;
  state.case_file = "cases/some.toml";
  state.case_text = "title = \"µ\"\n";
  state.constants = {"materials.al.solid={density = 1}"};
  state.overrides = {"step.dt=1e-4", "title=\"\"\"two\nlines\"\"\"", "seed=7"};
  state.clock = {123456789012, 2, 345, 0.1 + 0.2, 1.0 / 3, -1};
  state.scalars = {{"dissipated", 1e-300}, {"work", -0.0}, {"unknown", std::nan("")}};
  state.bodies = dealt(comm, bodies);
  ContactMemory contacts;
  for (BodyId id : state.bodies.id)
    contacts.add(id, id % 4 ? id + 1 : -1, Vec3::Constant(std::sqrt(static_cast<double>(id))),
                 Vec3::Constant(std::cbrt(static_cast<double>(id))));
  state.contacts = std::move(contacts);
  state.bonds.emplace();
  for (BodyId id : state.bodies.id) {
    for (BodyId k = 0; k < id % 3; ++k) state.bonds->other.push_back(100 * id + k);
    state.bonds->start.push_back(static_cast<Index>(std::ssize(state.bonds->other)));
  }
  return state;
}

TEST(Restart, the_same_ranks_get_the_same_rows_with_the_same_bits) {
  const Comm comm = testing_world();
  const std::string path = fresh_folder(comm) + "/restart.h5";
  const RestartState out = some_state(comm, 50);
  write_restart(comm, path, out);
  const RestartState in = read_restart(comm, path);
  expect_same_bits(in.bodies, out.bodies);
  EXPECT_TRUE(same_bits(in.contacts->i, out.contacts->i));
  EXPECT_TRUE(same_bits(in.contacts->j, out.contacts->j));
  EXPECT_TRUE(same_bits(in.contacts->impulse, out.contacts->impulse));
  EXPECT_TRUE(same_bits(in.contacts->rolling, out.contacts->rolling));
  EXPECT_EQ(in.case_text, out.case_text);
  EXPECT_EQ(in.case_file, out.case_file);
  EXPECT_EQ(in.overrides, out.overrides);
  EXPECT_EQ(in.constants, out.constants);
  EXPECT_EQ(in.clock.step, out.clock.step);
  EXPECT_EQ(in.clock.phase, out.clock.phase);
  EXPECT_EQ(in.clock.step_in_phase, out.clock.step_in_phase);
  EXPECT_EQ(in.clock.time, out.clock.time);
  EXPECT_EQ(in.clock.time_in_phase, out.clock.time_in_phase);
  EXPECT_EQ(in.clock.since_impact, out.clock.since_impact);
  ASSERT_EQ(in.scalars.size(), out.scalars.size());
  for (const auto& [name, value] : out.scalars)
    EXPECT_EQ(std::bit_cast<std::int64_t>(in.scalars.at(name)), std::bit_cast<std::int64_t>(value));
}

TEST(Restart, the_generation_before_stays_beside_it) {
  const Comm comm = testing_world();
  const std::string path = fresh_folder(comm) + "/restart.h5";
  RestartState state = some_state(comm, 20);
  for (std::int64_t step : {1, 2, 3}) {
    state.clock.step = step;
    write_restart(comm, path, state);
  }
  EXPECT_EQ(read_restart(comm, path).clock.step, 3);
  EXPECT_EQ(read_restart(comm, former_restart(path)).clock.step, 2);
}

TEST(Restart, a_damaged_file_does_not_take_the_place_of_the_one_before) {
  const Comm comm = testing_world();
  const std::string path = fresh_folder(comm) + "/restart.h5";
  RestartState state = some_state(comm, 20);
  for (std::int64_t step : {1, 2}) {
    state.clock.step = step;
    write_restart(comm, path, state);
  }
  remove_unless_whole(comm, path);
  EXPECT_TRUE(std::filesystem::exists(path));
  on_first_rank(comm, [&] {
    std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
    file.seekp(3000);
    file.put('x');
  });
  remove_unless_whole(comm, path);
  state.clock.step = 3;
  write_restart(comm, path, state);
  EXPECT_EQ(read_restart(comm, path).clock.step, 3);
  EXPECT_EQ(read_restart(comm, former_restart(path)).clock.step, 1);
}

TEST(FirstRank, what_it_throws_all_ranks_throw) {
  const Comm comm = testing_world();
  int calls = 0;
  on_first_rank(comm, [&] { ++calls; });
  EXPECT_EQ(calls, comm.rank == 0 ? 1 : 0);
  try {
    on_first_rank(comm, [] { throw Error("the disk is full"); });
    FAIL() << "nothing is thrown";
  } catch (const Error& error) {
    EXPECT_STREQ(error.what(), "the disk is full");
  }
}

TEST(Diagnostics, a_body_without_a_finite_motion_is_found) {
  const double no_number = std::nan("");
  Bodies bodies;
  for (BodyId id = 0; id < 5; ++id) add_body(bodies, id);
  bodies.owned = 4;  // the fifth is a ghost
  bodies.position[4] = Vec3::Constant(no_number);
  EXPECT_EQ(first_lost(bodies), 4);
  bodies.angular_velocity[3][2] = no_number;
  EXPECT_EQ(first_lost(bodies), 3);
  bodies.velocity[2][1] = infinity;
  EXPECT_EQ(first_lost(bodies), 2);
  bodies.position[1][0] = -infinity;
  EXPECT_EQ(first_lost(bodies), 1);
}

TEST(Restart, fields_that_bodies_do_not_have_are_in_no_file_and_come_back_as_zeros) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  const FieldSet few{Field::heat};
  RestartState out = some_state(comm, 50);
  set_fields(out.bodies, few);
  for (Index b = 0; b < out.bodies.owned; ++b) out.bodies.heat[b] = 1.5 + b;
  write_restart(comm, folder + "/restart.h5", out);
  RestartState in = read_restart(comm, folder + "/restart.h5");
  expect_same_bits(in.bodies, out.bodies);
  set_fields(in.bodies, {Field::kick});
  EXPECT_TRUE(in.bodies.heat.empty());
  EXPECT_EQ(in.bodies.kick, std::vector<Vec3>(in.bodies.owned, Vec3::Zero()));

  SnapshotWriter writer(comm, folder, Case{}, {});
  writer.write(out.bodies, 1, 0.5);
  writer.write_index();
  if (comm.rank != 0) return;
  for (const char* name : {"/snapshots/000000.h5", "/trajectory.h5"}) {
    const auto file = h5::File::open(folder + name);
    EXPECT_TRUE(file.exists("/particles/all/heat/value"));
    EXPECT_FALSE(file.exists("/particles/all/kick"));
    EXPECT_FALSE(file.exists("/particles/all/angular_velocity"));
  }
}

TEST(Restart, another_number_of_ranks_gets_every_body_and_contact_once) {
  const Comm world = testing_world();
  const std::string folder = fresh_folder(world);
  // The first `writers` ranks write, all read; then all write and rank 0 alone reads.
  for (int writers = 1; writers <= world.size; ++writers) {
    const std::string path = fmt::format("{}/restart{}.h5", folder, writers);
    MPI_Comm part = MPI_COMM_NULL;
    MPI_Comm_split(world.raw, world.rank < writers ? 0 : MPI_UNDEFINED, world.rank, &part);
    if (part != MPI_COMM_NULL) {
      write_restart(Comm(part), path, some_state(Comm(part), 41));
      MPI_Comm_free(&part);
    }
    MPI_Barrier(world.raw);
    const RestartState in = read_restart(world, path);
    std::vector<std::int64_t> ids = world.all_gather(in.bodies.id);
    std::sort(ids.begin(), ids.end());
    ASSERT_EQ(ids.size(), 41u);
    for (BodyId id = 0; id < 41; ++id) EXPECT_EQ(ids[id], id);
    EXPECT_EQ(world.sum(static_cast<std::int64_t>(in.contacts->i.size())), 41);
    for (Index b = 0; b < in.bodies.owned; ++b) {
      const BodyId id = in.bodies.id[b];
      ASSERT_EQ(in.bonds->count(b), id % 3);
      for (BodyId k = 0; k < id % 3; ++k) EXPECT_TRUE(in.bonds->has(b, 100 * id + k));
    }
    Bodies expected;
    for (BodyId id : in.bodies.id) add_body(expected, id);
    expected.owned = expected.size();
    expect_same_bits(in.bodies, expected);
  }
}

/// What a writer leaves that is killed: tests/faults/faults.py kills some.
TEST(Restart, half_a_file_beside_the_former_one_is_no_obstacle) {
  const Comm comm = testing_world();
  const std::string path = fresh_folder(comm) + "/restart.h5";
  write_restart(comm, path, some_state(comm, 20));
  if (comm.rank == 0) std::ofstream(unfinished(path)) << "half a file";
  MPI_Barrier(comm.raw);
  EXPECT_EQ(comm.sum(static_cast<std::int64_t>(read_restart(comm, path).bodies.owned)), 20);
  write_restart(comm, path, some_state(comm, 30));  // the half file is no obstacle
  EXPECT_EQ(comm.sum(static_cast<std::int64_t>(read_restart(comm, path).bodies.owned)), 30);
}

std::string error_of(const Comm& comm, const std::string& path) {
  return complaint_of([&] { read_restart(comm, path); });
}

TEST(Restart, a_damaged_file_is_one_clear_error) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm);
  const std::string path = folder + "/restart.h5";
  EXPECT_NE(error_of(comm, folder + "/none.h5").find("no restart file"), std::string::npos);
  write_restart(comm, path, some_state(comm, 64));
  EXPECT_EQ(error_of(comm, path), "");
  const std::string whole = read_whole(path);
  // One bit of a position turned.
  Vec3 x = some_state(Comm(MPI_COMM_SELF), 64).bodies.position[9];
  const std::string bytes(reinterpret_cast<const char*>(x.data()), sizeof(Vec3));
  const std::size_t at = whole.find(bytes);
  ASSERT_NE(at, std::string::npos);
  std::string turned = whole;
  turned[at + 3] ^= 16;
  const auto damaged = [&](const std::string& content) {
    MPI_Barrier(comm.raw);
    if (comm.rank == 0) write_whole(path, content);
    MPI_Barrier(comm.raw);
    return error_of(comm, path);
  };
  EXPECT_NE(damaged(turned).find("its bytes are not those that were written"), std::string::npos);
  EXPECT_NE(damaged(whole.substr(0, whole.size() / 2)).find("not a whole restart file"),
            std::string::npos);
  EXPECT_NE(damaged("").find("not a whole restart file"), std::string::npos);
  EXPECT_NE(damaged("title = 1").find("not a whole restart file"), std::string::npos);
}

TEST(Restart, any_bit_that_is_turned_is_refused_also_as_a_packing) {
  const Comm comm = testing_world();
  const std::string path = fresh_folder(comm) + "/restart.h5";
  write_restart(comm, path, some_state(comm, 64));
  const std::string whole = read_whole(path);
  std::mt19937_64 random(5);
  const auto refused = [&](std::size_t bit) {
    MPI_Barrier(comm.raw);
    std::string turned = whole;
    turned[bit / 8] ^= static_cast<char>(1 << bit % 8);
    on_first_rank(comm, [&] { std::ofstream(path, std::ios::binary) << turned; });
    Case packed;
    packed.groups.emplace_back().packing.file = path;
    const std::string told = complaint_of([&] { with_stored_bodies(packed); });
    return told.find("is not a restart file") != std::string::npos &&
           error_of(comm, path).find("is not a whole restart file") != std::string::npos;
  };
  for (std::size_t bit = 0; bit < 8 * seal_size; bit += 97) EXPECT_TRUE(refused(bit)) << bit;
  for (int draw = 0; draw < 500; ++draw) {
    const std::size_t bit = random() % (8 * whole.size());
    EXPECT_TRUE(refused(bit)) << bit;
  }
}

/// A file of two bodies that another program wrote, one field of which is another.
template <class T>
std::string complaint_about(const std::string& name, const std::vector<T>& other) {
  const std::string path = fresh_folder(alone()) + "/others.h5";
  h5::File file = h5::File::create(path);
  const auto write = [&]<class U>(const std::string& field, const std::vector<U>& usual) {
    if (field != name)
      file.write<U>("/bodies/" + field, usual);
    else if (!other.empty())
      file.write<T>("/bodies/" + field, other);
  };
  write("id", std::vector<BodyId>{0, 1});
  for (const char* field : {"position", "velocity", "angular_velocity"})
    write(field, std::vector<Vec3>{Vec3::Zero(), Vec3::UnitX()});
  for (const char* field : {"radius", "mass"}) write(field, std::vector<double>{0.1, 0.2});
  file.close();
  Case packed;
  packed.groups.emplace_back().packing.file = path;
  return complaint_of([&] { with_stored_bodies(packed); });
}

TEST(StoredBodies, of_another_program_are_checked_field_by_field) {
  if (testing_world().rank != 0) return;
  const double no_number = std::nan("");
  const auto expect = [](const std::string& words, const std::string& told) {
    EXPECT_NE(told.find(words), std::string::npos) << told << "\n  instead of\n" << words;
  };
  EXPECT_EQ(complaint_about<double>("", {}), "");
  for (const char* field : {"id", "position", "velocity", "radius", "mass"})
    expect(field, complaint_about<double>(field, {}));
  expect("does not hold whole numbers", complaint_about<double>("id", {0, 1}));
  expect("two bodies have the id 7", complaint_about<BodyId>("id", {7, 7}));
  expect("2 bodies, but one of their fields has 3 rows",
         complaint_about<double>("radius", {1, 1, 1}));
  expect("does not hold rows of 3 values", complaint_about<double>("position", {1, 2, 3, 4}));
  expect("2 bodies, but one of their fields has 1 rows",
         complaint_about<Vec3>("angular_velocity", {Vec3::Zero()}));
  expect("body 1 has the radius -1 m", complaint_about<double>("radius", {1, -1}));
  expect("body 0 has the radius inf m", complaint_about<double>("radius", {infinity, 1}));
  expect("body 1 has the mass nan kg", complaint_about<double>("mass", {1, no_number}));
  expect("body 0 has the mass 0 kg", complaint_about<double>("mass", {0, 1}));
  expect("body 1 has no finite place",
         complaint_about<Vec3>("velocity", {Vec3::Zero(), Vec3::Constant(no_number)}));
}

TEST(File, a_handle_that_moves_is_closed_once) {
  static int closed = 0;
  const auto close = [](hid_t id) -> herr_t {
    EXPECT_EQ(id, 7);
    return ++closed, 0;
  };
  {
    h5::Handle first(7, close), second = std::move(first), third;
    third = std::move(second);
    EXPECT_EQ(third, 7);
    EXPECT_EQ(closed, 0);
  }
  EXPECT_EQ(closed, 1);
}

/// HDF5 keeps small values back until their data set is closed.
TEST(File, a_data_set_that_cannot_be_closed_is_an_error) {
  if (testing_world().rank != 0) return;
  const std::string path = fresh_folder(alone()) + "/few.h5";
  rlimit usual{}, none{};
  getrlimit(RLIMIT_FSIZE, &usual);
  none.rlim_max = usual.rlim_max;  // files of no byte
  const auto before = std::signal(SIGXFSZ, SIG_IGN);
  const auto complaint = [&](const std::function<void(h5::File&)>& write) {
    h5::File file = h5::File::create(path);
    setrlimit(RLIMIT_FSIZE, &none);
    const std::string told = complaint_of([&] { write(file); });
    setrlimit(RLIMIT_FSIZE, &usual);
    return told;
  };
  const std::string told =
      fmt::format("H5Dclose of '{}:/few' failed: {}", path, std::strerror(EFBIG));
  const std::array few{1.5, 2.5};
  EXPECT_EQ(complaint([&](h5::File& file) { file.write<double>("/few", few); }), told);
  EXPECT_EQ(complaint([&](h5::File& file) { file.write<double>("/few", few, {0, 2, 2}); }), told);
  EXPECT_EQ(complaint([&](h5::File& file) { file.write_text("/few", "words"); }), told);
  std::signal(SIGXFSZ, before);
}

TEST(File, that_claims_more_than_it_holds_is_refused) {
  if (testing_world().rank != 0) return;
  const std::string path = fresh_folder(alone()) + "/claims.h5";
  {
    // No value was written, so none is stored.
    h5::File file = h5::File::create(path);
    const hsize_t many = hsize_t{1} << 50;
    const h5::Handle space(H5Screate_simple(1, &many, nullptr), H5Sclose);
    const h5::Handle set(H5Dcreate2(file.id(), "/many", H5T_NATIVE_DOUBLE, space, H5P_DEFAULT,
                                    H5P_DEFAULT, H5P_DEFAULT),
                         H5Dclose);
    const hsize_t three = 3;
    const h5::Handle row(H5Screate_simple(1, &three, nullptr), H5Sclose);
    const h5::Handle texts(
        H5Dcreate2(file.id(), "/texts", H5T_C_S1, row, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
        H5Dclose);
    file.close();
  }
  const auto file = h5::File::open(path);
  EXPECT_EQ(
      complaint_of([&] { file.read<double>("/many"); }),
      fmt::format("'{}:/many' says that it holds 9007199254740992 bytes, but 0 are there", path));
  EXPECT_EQ(complaint_of([&] { file.read_text("/texts"); }),
            fmt::format("'{}:/texts' is not one text of fixed length", path));
  EXPECT_EQ(complaint_of([&] { file.read_text("/many"); }),
            fmt::format("'{}:/many' is not one text of fixed length", path));
}

TEST(Series, resuming_drops_rows_after_the_restart_and_a_torn_line) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm), path = folder + "/series.csv";
  SeriesRows written;
  {
    Series series(comm, folder, {{"energy", "J"}, {"contacts", ""}});
    for (int step = 1; step <= 5; ++step) {
      series.append(step, 0.1 * step, std::array{1.0 / 3, 2.0});
      if (step == 3) written = series.rows();
    }
  }
  if (comm.rank == 0) std::ofstream(path, std::ios::app) << "6,0.6,0.3";
  MPI_Barrier(comm.raw);
  Series series(comm, folder, {{"energy", "J"}, {"contacts", ""}}, 3, written);
  series.append(4, 0.5, std::array{-1e-300, std::nan("")});
  series.write_hdf5();
  if (comm.rank == 0) {
    EXPECT_EQ(read_whole(path),
              "step,time,energy,contacts\n1,0.1,0.3333333333333333,2\n2,0.2,0.3333333333333333,2\n"
              "3,0.30000000000000004,0.3333333333333333,2\n4,0.5,-1e-300,nan\n");
    const auto file = h5::File::open(folder + "/series.h5");
    EXPECT_EQ(file.read<double>("/observables/energy/value"),
              (std::vector<double>{1.0 / 3, 1.0 / 3, 1.0 / 3, -1e-300}));
    EXPECT_EQ(file.read<std::int64_t>("/observables/contacts/step"),
              (std::vector<std::int64_t>{1, 2, 3, 4}));
    EXPECT_THROW(Series(alone(), folder, {{"energy", "J"}}, 3, written), Error);
  }
}

TEST(Series, that_has_lost_or_changed_rows_is_refused_and_left_as_it_is) {
  const Comm comm = testing_world();
  const std::string folder = fresh_folder(comm), path = folder + "/series.csv";
  std::array<SeriesRows, 6> after;  // each step
  {
    Series series(comm, folder, {{"energy", "J"}});
    for (int step = 1; step <= 5; ++step) {
      series.append(step, 0.1 * step, std::array{2.0 * step});
      after[step] = series.rows();
    }
    EXPECT_EQ(after[5].count, 5);
  }
  const auto told = [&](const std::string& text, int step) {
    MPI_Barrier(comm.raw);
    on_first_rank(comm, [&] { write_whole(path, text); });
    const std::string words = complaint_of([&] {
      Series(comm, folder, {{"energy", "J"}}, step, after[step]);
    });
    EXPECT_TRUE(words.empty() || read_whole(path) == text);
    return words;
  };
  MPI_Barrier(comm.raw);
  const std::string whole = read_whole(path), torn = whole.substr(0, whole.find("\n4,") + 3);
  EXPECT_EQ(told(torn, 4),
            fmt::format("'{}' has 3 rows up to step 4, but 4 were written: move the file away to "
                        "resume",
                        path));
  EXPECT_EQ(told(torn, 3), "");
  const std::size_t digit = whole.find("2,0.2,4");
  for (const auto& [text, other] : {std::pair(0, "1"), {4, "3"}, {6, "5"}}) {
    std::string changed = whole;
    changed.replace(digit + text, 1, other);
    EXPECT_EQ(told(changed, 3),
              fmt::format("'{}': its rows up to step 3 are not those that were written: move the "
                          "file away to resume",
                          path));
    EXPECT_EQ(told(changed, 1), text == 0 ? fmt::format("'{}' has 2 rows up to step 1, but 1 were "
                                                        "written: move the file away to resume",
                                                        path)
                                          : "");  // what is dropped may be anything
  }
  for (const char* line :
       {"1,0.1,x\n", "x,0.1,2\n", "1,0.1\n", "1,0.1,2,3\n", "1,,2\n", "1,0.1,2 3\n"})
    EXPECT_EQ(told(std::string("step,time,energy\n") + line, 3),
              fmt::format("'{}': line 2 is not whole: move the file away to resume", path))
        << line;
}

TEST(Results, toml_keeps_every_digit) {
  ResultTable table;
  table.add("deflection", "dv", 1.0 / 3, "m/s", "of the clump");
  table.add("deflection", "whole", 5.0);
  table.add("deflection", "none", std::nan(""));
  table.add("ejecta", "count", std::int64_t{12345678901});
  table.add("ejecta", "bound", false);
  table.add("ejecta", "text", std::string("a \"b\" \\ \n"));
  table.add("read_out", "times", std::vector<double>{11, 51.5, 1e-20}, "s");
  table.add("deflection", "dv", 2.0 / 3, "m/s", "of the clump");  // again
  const toml::table read = toml::parse(table.toml());
  EXPECT_EQ(*read["deflection"]["dv"].value<double>(), 2.0 / 3);
  EXPECT_TRUE(read["deflection"]["whole"].is_floating_point());
  EXPECT_TRUE(std::isnan(*read["deflection"]["none"].value<double>()));
  EXPECT_EQ(*read["ejecta"]["count"].value<std::int64_t>(), 12345678901);
  EXPECT_EQ(*read["ejecta"]["bound"].value<bool>(), false);
  EXPECT_EQ(*read["ejecta"]["text"].value<std::string>(), "a \"b\" \\ \n");
  EXPECT_EQ(*read["read_out"]["times"][2].value<double>(), 1e-20);
  EXPECT_NE(table.text().find("0.666667  m/s  of the clump"), std::string::npos);
}

TEST(Results, an_unwritable_folder_is_a_clear_error) {
  const Comm self(MPI_COMM_SELF);
  EXPECT_THROW(write_results(self, "/proc/nowhere", {}, {}), Error);
}

}  // namespace
}  // namespace spall
