// The program: reads the command line, calls one function, catches once.
// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <optional>
#include <string_view>

#include "base/commit.hpp"
#include "base/kernels.hpp"
#include "keys/units.hpp"
#include "output/snapshot.hpp"
#include "run/plan.hpp"
#include "run/run.hpp"
#include "run/solve_file.hpp"
#include "scene/case.hpp"
#include "scene/material_library.hpp"
#include "solver/settings.hpp"
#include "spall/comm.hpp"
#include "spall/error.hpp"

namespace {

using namespace spall;

constexpr int exit_interrupted = 3;

struct Options {
  std::string file;
  std::string out;
  std::vector<std::string> overrides, folders;
  bool overwrite = false, stored_case = false;
  SolverSettings solver{
      .tolerance = 1e-4, .max_iterations = 1 << 30, .max_products = 10000, .prox = 0};
  bool evaluate = false;
  bool time = false;
  PlanRequest plan;
  std::string latency, bandwidth;
  std::string material;
};

/// What a user may choose, by name.
template <class Enum, std::size_t n>
CLI::Validator choice_of(const Choice<Enum> (&choices)[n]) {
  std::map<std::string, Enum> map;
  std::string names;
  for (const auto& [name, value] : choices) {
    map.emplace(name, value);
    names += (names.empty() ? "" : " | ") + std::string(name);
  }
  return CLI::CheckedTransformer(map).description(names);
}

/// The folder of a run without --out: out/ and the name of the case's file or folder.
std::string default_folder(const std::string& file) {
  const std::filesystem::path path(file);
  const bool named_case = path.stem() == "case" && path.has_parent_path();
  return "out/" + (named_case ? path.parent_path().filename() : path.stem()).string();
}

void list_cases() {
  require(std::filesystem::is_directory("cases"), "there is no folder 'cases' here");
  for (const std::string& file : find_cases("cases"))
    fmt::print("{:<36} {}\n", file, read_case(file).title);
}

/// Where a script is: in the installation that this program is of, or in its build.
std::string find_script(const std::string& name) {
  const auto program = std::filesystem::read_symlink("/proc/self/exe").parent_path();
  for (const char* place : {"../share/spall/scripts", "share/spall/scripts"})
    if (const auto script = program / place / name; std::filesystem::exists(script))
      return script.string();
  throw Error(fmt::format("{} is missing: it belongs into {}", name,
                          (program / "../share/spall/scripts").lexically_normal().string()));
}

/// What calls a script. Without a shell, which would read signs in the arguments.
class ScriptCall {
 public:
  ScriptCall(const std::string& name, std::vector<std::string> arguments)
      : words_(std::move(arguments)) {
    words_.insert(words_.begin(), {"python3", find_script(name)});
    for (std::string& word : words_) pointers_.push_back(word.data());
    pointers_.push_back(nullptr);
  }
  ScriptCall(const ScriptCall&) = delete;
  char** get() { return pointers_.data(); }

 private:
  std::vector<std::string> words_;
  std::vector<char*> pointers_;  // into words_
};

/// Its exit code.
int run_script(const std::string& name, std::vector<std::string> arguments) {
  ScriptCall call(name, std::move(arguments));
  pid_t child = 0;
  const int failed = posix_spawnp(&child, "python3", nullptr, nullptr, call.get(), environ);
  require(failed == 0, "python3 cannot be started: {}", std::strerror(failed));
  int status = 0;
  require(waitpid(child, &status, 0) == child, "waiting for python3: {}", std::strerror(errno));
  return WIFEXITED(status) ? WEXITSTATUS(status) : 1;
}

/// What begins runs of its own or looks at one for hours: it comes before MPI and takes this
/// process, so that signals are the script's.
int become_script(const std::string& name, std::vector<std::string> arguments) {
  try {
    const auto program = std::filesystem::read_symlink("/proc/self/exe");
    setenv("SPALL_PROGRAM", program.c_str(), 1);
    execvp("python3", ScriptCall(name, std::move(arguments)).get());
    throw Error(fmt::format("python3 cannot be started: {}", std::strerror(errno)));
  } catch (const std::exception& error) {
    fmt::print(stderr, "spall: {}\n", error.what());
    return 2;
  }
}

int dispatch(const Comm& comm, int argc, char** argv) {
  CLI::App app{
      "Spall simulates hypervelocity impacts of bodies made of many spheres, on MPI ranks.\n"
      "  spall check cases/hello/case.toml\n"
      "  mpirun -n 2 spall run cases/hello/case.toml --set contact.friction=0.3\n"
      "  spall report out/hello\n"
      "  spall watch out/hello"};
  app.footer(
      "What a case may ask for (pair potentials, bonds, materials, penalty contact, gravity ...):\n"
      "  spall keys, and README.md. `spall SUBCOMMAND --help` tells the options of each.\n"
      "Exit codes: 0: done; 3: stopped by a signal, `spall resume` goes on; others: an error.");
  app.require_subcommand(1);
  app.set_version_flag("--version",
                       fmt::format("spall {}, commit {}, instructions: {}", SPALL_VERSION,
                                   commit_of_build(), instructions_name()));
  Options options;

  auto* run = app.add_subcommand(
      "run", "run a case, on any number of ranks by mpirun; results go to --out");
  run->add_option("case", options.file, "case file (TOML)")->required();
  run->add_option("--out", options.out,
                  "folder for results; default: out/<case>, named after the file, or the folder of "
                  "a case.toml");
  run->add_option("--set", options.overrides, "change keys, as in --set phases.impact.step=50us")
      ->take_all();
  constexpr const char* overwrite = "replace the run that the folder for results holds";
  run->add_flag("--overwrite", options.overwrite, overwrite);
  auto* resume = app.add_subcommand("resume", "go on with a run from its restart file");
  resume->add_option("restart", options.file, "<out>/restart.h5 or <out>/after_<phase>.h5")
      ->required();
  resume->add_option("--out", options.out, "folder for results; default: that of the restart file");
  resume->add_option("--set", options.overrides, "change keys for what lies ahead")->take_all();
  resume->add_flag("--overwrite", options.overwrite, overwrite);
  resume->add_flag("--stored-case", options.stored_case,
                   "go on with the case as it was, though its file has changed");
  auto* check =
      app.add_subcommand("check", "read a case, print bodies, memory, steps; write nothing");
  check->add_option("case", options.file, "case file (TOML), or a restart file: is it whole?")
      ->required();
  check->add_option("--set", options.overrides, "change keys")->take_all();
  check->add_flag("--time", options.time,
                  "foretell the time of the first phase from two seconds of its steps");
  auto* planning = app.add_subcommand(
      "plan", "what more ranks bring: bodies, ghosts, messages, memory, time; write nothing");
  planning
      ->add_option("case", options.file,
                   "case file (TOML), as its first phase begins, or a restart file")
      ->required();
  planning->add_option("--ranks", options.plan.ranks, "how many, such as 64,1024,10000")
      ->required()
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::Range(1, std::numeric_limits<int>::max()));
  planning->add_option("--set", options.overrides, "change keys")->take_all();
  auto* latency =
      planning->add_option("--latency", options.latency, "of a message; default: \"2 us\"");
  auto* bandwidth =
      planning->add_option("--bandwidth", options.bandwidth, "of a rank; default: \"1 GB/s\"");
  planning
      ->add_flag("--calibrate", options.plan.calibrate,
                 "measure both between the first two ranks, under mpirun")
      ->excludes(latency)
      ->excludes(bandwidth);
  auto* page = app.add_subcommand(
      "report", "make report.html in the folder of a run: bodies in 3-D, curves, verdicts");
  page->add_option("folders", options.folders,
                   "folder that a run wrote; several stand side by side in compared.html")
      ->required();
  app.add_subcommand("watch", "show a run under way in a browser on this machine")
      ->prefix_command();  // as sweep
  app.add_subcommand("sweep", "run a case for each combination of values; one table of results")
      ->prefix_command();  // main begins it: its options are the script's
  app.add_subcommand("limit",
                     "find the diameter or speed from which on a wall fails, by runs of a case")
      ->prefix_command();
  auto* solve = app.add_subcommand(
      "solve", "solve a contact problem from an FCLIB file, on any number of ranks");
  solve->add_option("problem", options.file, "local frictional-contact problem (HDF5)")->required();
  solve->add_option("--method", options.solver.method, "default: accelerated")
      ->transform(choice_of(solver_methods));
  solve
      ->add_option("--friction", options.solver.friction,
                   "default: coulomb; apgd and bb need convex")
      ->transform(choice_of(friction_models));
  solve->add_option("--tol", options.solver.tolerance, "on E, the residual relative to no impulses")
      ->capture_default_str();
  solve->add_option("--max-products", options.solver.max_products, "with the Delassus operator")
      ->capture_default_str();
  solve->add_option("--prox", options.solver.prox, "eps of the proximal problem; 0: none")
      ->capture_default_str();
  solve->add_flag("--evaluate", options.evaluate, "solve nothing: E of the file's own /solution/r");
  auto* list = app.add_subcommand("list", "list the cases under ./cases");
  auto* materials = app.add_subcommand(
      "materials", "list the solids that a case may name; one with its constants and sources");
  materials->add_option("name", options.material, "one of the list");
  auto* keys = app.add_subcommand(
      "keys", "print every key of a case file, every field of snapshots, and all units");

  const auto is_called = [&](const CLI::App* command) { return command->check_name(argv[1]); };
  require(argc < 2 || argv[1][0] == '-' || !app.get_subcommands(is_called).empty(),
          "there is no subcommand '{}'; `spall --help` lists them", argv[1]);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return comm.rank == 0 ? app.exit(error) : error.get_exit_code();
  }
  const Former former = options.overwrite ? Former::overwrite : Former::refuse;
  if (*run) {
    const Case scene = read_case(options.file, options.overrides, InputFiles(comm));
    const auto folder = options.out.empty() ? default_folder(options.file) : options.out;
    return run_case(comm, scene, folder, former) ? 0 : exit_interrupted;
  }
  if (*resume) {
    const ResumeOptions how{options.out, former, options.overrides, options.stored_case};
    return resume_case(comm, options.file, how) ? 0 : exit_interrupted;
  }
  if (*solve) {
    const SolverSettings& how = options.solver;
    require(how.tolerance > 0, "--tol = {}: more than 0 is wanted", how.tolerance);
    require(how.max_products > 0, "--max-products = {}: more than 0 is wanted", how.max_products);
    require(how.prox >= 0, "--prox = {}: 0 or more is wanted", how.prox);
    solve_file(comm, options.file, options.solver, options.evaluate);
    return 0;
  }
  if (*check) {
    const bool restart = std::filesystem::path(options.file).extension() == ".h5";
    require(!restart || (options.overrides.empty() && !options.time),
            "'{}' is a restart file: check tells whether it is whole; --set and --time are of case "
            "files",
            options.file);
    const Foretold foretold = options.time ? Foretold::time_too : Foretold::memory;
    const std::string text =
        restart ? check_restart(comm, options.file)
                : check_case(comm, read_case(options.file, options.overrides, InputFiles(comm)),
                             foretold);
    if (comm.rank == 0) fmt::print("{}", text);
  }
  if (*planning) {
    PlanRequest& request = options.plan;
    request.overrides = options.overrides;
    if (!options.latency.empty()) {
      request.latency = parse_quantity(options.latency, dimension::time);
      require(request.latency >= 0, "--latency {}: must be 0 or more", options.latency);
    }
    if (!options.bandwidth.empty()) request.bandwidth = parse_bandwidth(options.bandwidth);
    const std::string text = plan(comm, options.file, request);
    if (comm.rank == 0) fmt::print("{}", text);
  }
  if (comm.rank != 0) return 0;  // what follows needs no second rank
  if (*page) return run_script("report.py", options.folders);
  if (*list) list_cases();
  if (*materials)
    fmt::print("{}", options.material.empty() ? describe_material_library()
                                              : library_material(options.material).text);
  if (*keys) fmt::print("{}{}{}", case_reference(), describe_output_fields(), describe_units());
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  if (const std::string name = argc > 1 ? argv[1] : "";
      name == "sweep" || name == "limit" || name == "watch")
    return become_script(name + ".py", {argv + 2, argv + argc});
  std::optional<spall::Session> session;  // outlives the try, as it says
  try {
    session.emplace();
    return dispatch(session->world(), argc, argv);
  } catch (const std::exception& error) {
    spall::Session::abort_all(error.what());
  }
}
