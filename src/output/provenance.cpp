// What only rank 0 knows for sure is told by it.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/provenance.hpp"

#include <fmt/chrono.h>

#include <ctime>

#include "base/commit.hpp"
#include "base/first_rank.hpp"
#include "base/process.hpp"

namespace spall {
Provenance provenance_of(const Comm& comm, const Case& scene) {
  const auto of_first = [&](const std::string& text) { return text_of_first_rank(comm, text); };
  const auto lines = [](const std::vector<std::string>& changes) {
    std::string text;
    for (const std::string& change : changes) text += change + "\n";
    return text;
  };
  return {{"title", scene.title},
          {"command", of_first(command_line())},
          {"version", SPALL_VERSION},
          {"commit", commit_of_build()},
          {"date", of_first(fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(std::time(nullptr))))},
          {"host", of_first(host_name())},
          {"ranks", std::int64_t{comm.size}},
          {"seed", static_cast<std::int64_t>(scene.seed)},
          {"case_file", scene.file},
          {"overrides", lines(scene.overrides)},
          {"constants", lines(scene.constants)},
          {"case", scene.text}};
}

}  // namespace spall
