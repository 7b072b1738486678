// A lock is made by a call that fails where there is one, so that one of two runs gets it.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/run_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/first_rank.hpp"
#include "base/process.hpp"
#include "output/files.hpp"
#include "spall/error.hpp"

namespace spall {
namespace {

namespace fs = std::filesystem;

bool has_ended(int process) {
  if (kill(process, 0) != 0 && errno == ESRCH) return true;
  // Killed, but nobody has asked how it ended: "pid (name) Z ..."
  std::ifstream file(fmt::format("/proc/{}/stat", process));
  std::string text;
  std::getline(file, text);
  const std::size_t at = text.rfind(") ");
  return at != std::string::npos && text[at + 2] == 'Z';
}

/// The longest name that a run adds is after_NAME.h5.unfinished, of a phase's name.
void check_length(const std::string& folder) {
  constexpr std::size_t most_added = 140;
  require(fs::absolute(folder).string().size() + most_added < PATH_MAX,
          "the path of the folder for results has {} signs, more than the system's {} leave room "
          "for: '{}...'",
          folder.size(), PATH_MAX, folder.substr(0, 100));
}

void lock(const std::string& folder) {
  const std::string path = folder + "/lock", own = fmt::format("{} {}\n", host_name(), getpid());
  int descriptor = open(path.c_str(), O_CREAT | O_EXCL | O_WRONLY, 0644);
  if (descriptor < 0 && errno == EEXIST) {
    const std::string holder = read_whole(path);
    char name[256] = "";
    int process = 0;
    const bool named = std::sscanf(holder.c_str(), "%255s %d", name, &process) == 2;
    require(named && name == host_name() && has_ended(process),
            "'{}': a run is under way there, by process {} on {}; if it is not, remove '{}'",
            folder, process, name, path);
    fmt::print(stderr, "spall: process {} on {} has left '{}': it is taken over\n", process, name,
               path);
    descriptor = open(path.c_str(), O_TRUNC | O_WRONLY);
  }
  require(descriptor >= 0, "cannot write '{}': {}", path, std::strerror(errno));
  const auto written = ::write(descriptor, own.data(), own.size());
  const int reason = errno;
  close(descriptor);
  require(written == std::ssize(own), "cannot write '{}': {}", path, std::strerror(reason));
}

/// Files that runs write, by their names alone.
std::vector<fs::path> files_of_runs(const fs::path& folder) {
  std::vector<fs::path> files;
  const auto add = [&](const fs::path& where, auto&& is_ours) {
    std::error_code none;
    for (const auto& entry : fs::directory_iterator(where, none))
      if (entry.is_regular_file() && is_ours(entry.path())) files.push_back(entry.path());
  };
  add(folder, [](const fs::path& file) {
    const std::string name = finished(file.filename().string());
    constexpr const char* names[] = {"results.toml",      "series.csv",        "series.h5",
                                     "restart.h5",        "trajectory.h5",     "trajectory.xdmf",
                                     "restart_before.h5", "reference.toml",    "report.html",
                                     "compared.html",     "resolved_case.toml"};
    return std::ranges::find(names, name) != std::end(names) ||
           (name.starts_with("after_") && name.ends_with(".h5"));
  });
  add(folder / "snapshots", is_snapshot);
  return files;
}

}  // namespace

RunFolder::RunFolder(const Comm& comm, const std::string& path, Former former)
    : path_(path), former_(former), is_new_(false) {
  check_length(path);
  is_new_ = !fs::exists(path);
  make_folder(comm, path);
  on_first_rank(comm, [&] {
    if (former == Former::refuse) {
      const auto files = files_of_runs(path);
      require(files.empty(),
              "'{}' holds a run already ({}): choose another folder with --out, or --overwrite it",
              path, files.empty() ? "" : files.front().filename().string());
    }
    lock(path);
    holds_ = true;
  });
}

RunFolder::~RunFolder() {
  if (!holds_) return;
  std::error_code none;  // files of the run keep the folder
  fs::remove(path_ + "/lock", none);
  if (is_new_) fs::remove(path_, none);
}

void RunFolder::begin(const Comm& comm) const {
  on_first_rank(comm, [&] {
    if (former_ == Former::go_on) {
      for (const char* told : {"/results.toml", "/report.html", "/compared.html"})
        fs::remove(path_ + told);
    } else {
      for (const auto& file : files_of_runs(path_)) fs::remove(file);
    }
  });
}

}  // namespace spall
