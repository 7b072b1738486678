// A heap of clumps and balls as a case, for each method that knows clumps.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>

#include "output/restart.hpp"
#include "run/simulation.hpp"
#include "scene/case.hpp"
#include "spall/spall.hpp"
#include "testing.hpp"

namespace spall {

/// What differs by method; lines end.
struct HeapKeys {
  std::string material = "";  ///< keys of the material, beside its density
  std::string restitution;
  std::string tables = "";  ///< of the case
  std::string phase = "";   ///< keys of the phase, beside step and duration
  std::string step;
};

inline std::string heap_of_clumps(const HeapKeys& keys) {
  return R"(
seed = 3
[materials.rock]
density = "2000 kg/m^3"
)" + keys.material +
         R"([shapes.boulder]
axes = [2, 1.414, 1]
count = 5
[shapes.dumbbell]
spheres = [{at = [0, 0, 0], radius = 1}, {at = [1.4, 0, 0], radius = 0.8}]
[contact]
friction = 0.5
restitution = )" +
         keys.restitution + "\n" + keys.tables +
         R"([gravity]
uniform = [0, 0, "-9.81 m/s^2"]
[[planes]]
point = [0, 0, 0]
normal = [0, 0, 1]
[[groups]]
name = "boulders"
material = "rock"
volume = {shape = "box", size = [3, 3, 3], center = [0, 0, 1.6]}
packing = {kind = "random", radius = 0.5, count = 12, shape = "boulder"}
[[groups]]
name = "dumbbells"
material = "rock"
volume = {shape = "box", size = [3, 3, 2], center = [0, 0, 4.2]}
packing = {kind = "random", radius = 0.4, count = 8, shape = "dumbbell"}
[[groups]]
name = "balls"
material = "rock"
volume = {shape = "box", size = [3, 3, 1.2], center = [0, 0, 5.9]}
packing = {kind = "random", radius = 0.4, count = 4}
[[phases]]
name = "fall"
)" + keys.phase +
         "step = \"" + keys.step + "\"\nduration = \"3 s\"\n";
}

/// A run that is saved at `stop` (s) and one from its file, both until `end`: same bodies, to the
/// bit. Returns how many contacts the file remembers. `name` is that of a folder.
inline double expect_the_same_bits_after_a_stop(const std::string& text, const std::string& name,
                                                double stop, double end) {
  const Comm comm = testing_world();
  const std::string folder = ::testing::TempDir() + "/" + name + "_" + std::to_string(comm.size);
  const Case scene = parse_case(text, "heap.toml");
  Simulation first(comm, Scene(std::make_shared<Case>(scene)));
  first.run_until(stop);
  RestartState state = first.save();
  const double contacts = comm.sum(static_cast<double>(state.contacts->size()));
  if (comm.rank == 0) std::filesystem::create_directories(folder);
  comm.any(true);
  write_restart(comm, folder + "/restart.h5", state);
  Simulation second(comm, Scene(std::make_shared<Case>(scene)),
                    read_restart(comm, folder + "/restart.h5"));
  first.go_on(state);
  for (Simulation* run : {&first, &second}) run->run_until(end);
  const Bodies &a = first.bodies(), &b = second.bodies();
  EXPECT_EQ(a.id, b.id);
  EXPECT_EQ(a.position, b.position);
  EXPECT_EQ(a.velocity, b.velocity);
  EXPECT_EQ(a.angular_velocity, b.angular_velocity);
  EXPECT_EQ(a.shape, b.shape);
  for (Index k = 0; k < a.owned; ++k)
    EXPECT_EQ(a.orientation[k].coeffs(), b.orientation[k].coeffs());
  return contacts;
}

}  // namespace spall
