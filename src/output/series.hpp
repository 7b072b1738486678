// The time series of a run: one row of named numbers a step, as CSV and as HDF5.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <fstream>
#include <span>
#include <string>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

struct Column {
  std::string name, unit;  ///< "m s-1", by H5MD's rules; "": a pure number
};

/// What a file of rows must hold when its run goes on.
struct SeriesRows {
  std::int64_t count = 0;
  /// Of their text, below 2^52, so that a double holds it; on rank 0, elsewhere anything.
  std::int64_t checksum = 0;
};

/// `folder`/series.csv: a heading, then one line a row: step, time and the columns, with every
/// digit that a double has. Rank 0 writes and flushes each row, so a killed run loses none; on
/// other ranks nothing happens. `write_hdf5` puts the same into `folder`/series.h5 as H5MD
/// observables.
class Series {
 public:
  /// `columns` without step and time. On resuming, rows after `resume_step` (and a torn last line)
  /// are dropped; an Error where the columns differ, or other rows than `written` are left: some
  /// are lost or changed. A file that is not there begins anew. Collective.
  Series(const Comm& comm, const std::string& folder, std::vector<Column> columns,
         std::int64_t resume_step = -1, const SeriesRows& written = {});

  void append(std::int64_t step, double time, std::span<const double> values);
  void write_hdf5() const;
  const SeriesRows& rows() const { return rows_; }  ///< that the file has

 private:
  void count(const std::string& line);

  std::string path_;
  std::vector<Column> columns_;
  bool writes_;
  SeriesRows rows_;
  std::ofstream file_;
};

}  // namespace spall
