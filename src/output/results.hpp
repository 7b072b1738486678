// The table of results at the end of a run: printed for people, written as TOML for programs.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "output/provenance.hpp"
#include "spall/comm.hpp"

namespace spall {

/// Sections of keys with values, in the order in which they were added.
class ResultTable {
 public:
  using Value = std::variant<double, std::int64_t, bool, std::string, std::vector<double>>;

  /// Adds a row, or replaces the value of one that is there. `unit` and `note` are for people.
  void add(const std::string& section, const std::string& key, Value value,
           const std::string& unit = "", const std::string& note = "");

  std::string text() const;  ///< aligned, rounded to what people read
  std::string toml() const;  ///< every digit; units and notes as comments

 private:
  struct Row {
    std::string key;
    Value value;
    std::string unit, note;
  };
  struct Section {
    std::string name;
    std::vector<Row> rows;
  };
  std::vector<Section> sections_;
};

/// Writes `folder`/results.toml by rank 0, as a whole; the table [provenance] comes last.
/// Collective.
void write_results(const Comm& comm, const std::string& folder, ResultTable table,
                   const Provenance& provenance);

/// Keeps a copy of `file`, a source's values, as `folder`/reference.toml beside the results; an
/// empty name removes the copy of a former run. Collective.
void keep_reference(const Comm& comm, const std::string& folder, const std::string& file);

/// Keeps the text of the case with all changes as `folder`/resolved_case.toml, which can be run; an
/// empty one removes that of a former run. Collective.
void keep_case(const Comm& comm, const std::string& folder, const std::string& resolved);

}  // namespace spall
