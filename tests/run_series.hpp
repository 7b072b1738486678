// What a whole run says, and the series that it writes, as rows of named numbers.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <toml++/toml.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "run/run.hpp"
#include "testing.hpp"

namespace spall {

/// What `f` says, which is kept from the screen: a failure is not lost in it.
template <class F>
std::string said_by(F&& f) {
  ::testing::internal::CaptureStdout();
  try {
    f();
  } catch (...) {
    ::testing::internal::GetCapturedStdout();
    throw;
  }
  return ::testing::internal::GetCapturedStdout();
}

/// Where tests on so many ranks have a run of this name.
inline std::string folder_of_run(const std::string& name) {
  return std::filesystem::absolute(fmt::format("{}_{}", name, testing_world().size)).string();
}
/// Of a run that has just ended, on every rank. Collective.
inline toml::table results_in(const std::string& folder) {
  testing_world().any(false);  // rank 0 has written them
  return toml::parse_file(folder + "/results.toml");
}

/// Runs the case in a folder of this test. Values by the names of their columns. Collective.
inline std::vector<std::map<std::string, double>> series_of(const std::string& text) {
  const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
  const std::string folder =
      folder_of_run(std::string(test->test_suite_name()) + "_" + test->name());
  said_by([&] {
    run_case(testing_world(), parse_case(text, std::string(test->name()) + ".toml"), folder,
             Former::overwrite);
  });
  testing_world().any(false);  // rank 0 has written it
  std::ifstream file(folder + "/series.csv");
  std::vector<std::string> names;
  std::vector<std::map<std::string, double>> rows;
  for (std::string line, cell; std::getline(file, line);) {
    std::istringstream cells(line);
    if (names.empty()) {
      while (std::getline(cells, cell, ',')) names.push_back(cell);
      continue;
    }
    auto& row = rows.emplace_back();
    for (const std::string& column : names)
      if (std::getline(cells, cell, ',')) row[column] = std::stod(cell);
  }
  return rows;
}

}  // namespace spall
