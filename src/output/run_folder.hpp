// The folder of a run: one run at a time, and the files of one run.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "spall/comm.hpp"

namespace spall {

/// What is to become of what a former run left in the folder.
enum class Former {
  refuse,     ///< an Error names it
  overwrite,  ///< it goes once the new run begins
  go_on,      ///< the run resumes it
};

/// Makes the folder and locks it by a file `lock`, which names host and process; gone with this. So
/// is a new folder in which nothing was written.
/// A lock whose process has ended on this host is passed over, and said so on standard error.
class RunFolder {
 public:
  /// Throws Error where another run holds the folder, or has left results that would be lost.
  /// Collective.
  RunFolder(const Comm& comm, const std::string& path, Former former);
  ~RunFolder();
  RunFolder(const RunFolder&) = delete;
  RunFolder& operator=(const RunFolder&) = delete;

  const std::string& path() const { return path_; }
  bool goes_on() const { return former_ == Former::go_on; }

  /// Removes what would be told of another run: its results and, where this run is no sequel, all
  /// that runs write. Files of other names stay. Collective.
  void begin(const Comm& comm) const;

 private:
  std::string path_;
  Former former_;
  bool is_new_ = false, holds_ = false;
};

}  // namespace spall
