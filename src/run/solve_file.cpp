// Reads, solves, prints.
// SPDX-License-Identifier: BSD-3-Clause
#include "run/solve_file.hpp"

#include "keys/input_files.hpp"
#include "output/fclib.hpp"
#include "solver/settings.hpp"
#include "spall/error.hpp"

namespace spall {

void solve_file(const Comm& comm, const std::string& file, const SolverSettings& settings,
                bool only_evaluate) {
  InputFiles(comm).require_file(file);
  const LocalProblem problem = read_fclib(file, comm);
  const auto blocks = comm.sum(static_cast<std::int64_t>(problem.matrix.block.size()));
  require(!only_evaluate || !problem.solution.empty(), "{} has no /solution/r to evaluate", file);

  std::vector<Vec3> impulse(problem.q.size(), Vec3::Zero());
  SolverReport report;
  if (only_evaluate) {
    report = evaluate(problem.view(), problem.rows, settings.friction, problem.solution);
    report.converged = report.residual <= settings.tolerance;
  } else {
    report = solve(problem.view(), problem.rows, settings, impulse).report;
  }
  if (comm.rank != 0) return;
  const auto line = [](const char* name, const auto& value) {
    fmt::print("{:<13} {}\n", name, value);
  };
  line("problem", fmt::format("{} ({}): {} contacts, {} blocks", file, problem.title,
                              problem.contacts, blocks));
  line("ranks", comm.size);
  line("iterations", report.iterations);
  line("products", report.products);
  line("E", fmt::format("{:.4e}", report.residual));
  if (settings.prox > 0) line("E_eps", fmt::format("{:.4e}", report.residual_prox));
  line("largest", fmt::format("{:.4e} (velocity, in the file's units)", report.residual_max));
  line("rms", fmt::format("{:.4e}", report.residual_rms));
  line("converged", report.converged ? "yes" : "no");
  line("seconds", fmt::format("{:.4f}", report.seconds));
}

}  // namespace spall
