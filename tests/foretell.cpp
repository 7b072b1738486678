// The time that a sample of steps foretells is the time that the run takes.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/foretell.hpp"

#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "run/run.hpp"
#include "run/simulation.hpp"
#include "spall/scene.hpp"
#include "testing.hpp"

namespace spall {
namespace {

/// A crystal of 4000 bodies at rest: each step costs the same.
std::string crystal(int steps) {
  return fmt::format(R"(
[materials.rock]
density = 2500
[pair_potential]
law = "morse"
depth = 1
distance = 0.01
steepness = 6
cutoff = 0.018
[[groups]]
name = "crystal"
material = "rock"
volume = {{shape = "box", size = [0.15, 0.15, 0.15]}}
packing = {{kind = "fcc", radius = "5 mm"}}
[[phases]]
name = "rest"
method = "potential"
step = "1 us"
duration = "{} us"
)",
                     steps);
}

double foretold(const std::string& text, double seconds) {
  Simulation simulation(testing_world(), Scene::from_text(text));
  simulation.begin_phase();
  return foretold_seconds(simulation, sample_steps(simulation, seconds));
}

TEST(Foretell, a_sample_tells_the_time_of_uniform_steps_within_a_factor_of_two) {
  const Comm comm = testing_world();
  // So many steps that what a run begins and ends with counts little.
  const double a_step = foretold(crystal(1000), 0.2) / 1000;
  const std::string text = crystal(static_cast<int>(2 / a_step));
  const std::string folder = (std::filesystem::temp_directory_path() /
                              fmt::format("spall_foretell_{}", comm.sum(std::int64_t{getpid()})))
                                 .string();
  // Others share the machine: samples are taken before and after.
  const double before = foretold(text, 0.5);
  const double start = MPI_Wtime();
  run_case(comm, parse_case(text, "x.toml"), folder);
  const double took = comm.max(MPI_Wtime() - start);
  const double after = foretold(text, 0.5);
  EXPECT_GT(took, std::min(before, after) / 2);
  EXPECT_LT(took, std::max(before, after) * 2);
  if (comm.rank == 0) std::filesystem::remove_all(folder);
}

TEST(Foretell, a_phase_shorter_than_the_sample_is_told_as_it_was) {
  Simulation simulation(testing_world(), Scene::from_text(crystal(5)));
  simulation.begin_phase();
  const Sample sample = sample_steps(simulation, 100);
  EXPECT_EQ(sample.steps, 4);  // the first finds the pairs
  EXPECT_EQ(simulation.steps_left(), 0);
  EXPECT_DOUBLE_EQ(foretold_seconds(simulation, sample), 5 * sample.seconds / 4);
  EXPECT_NE(describe_time(simulation, sample).find("for 5 steps"), std::string::npos);
}

}  // namespace
}  // namespace spall
