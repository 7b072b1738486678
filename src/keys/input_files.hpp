// What a run reads: by one rank, so that all see the same whatever lies on their disks.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

/// How the files are read that a case is made of.
class InputFiles {
 public:
  /// By each rank for itself: all that a program without MPI needs.
  InputFiles() = default;
  /// By rank 0 for all. Every call is collective then, and throws on all ranks alike.
  explicit InputFiles(const Comm& comm) : comm_(comm) {}

  bool exists(const std::string& path) const;
  /// Throws Error where it is a folder, a device, or nothing.
  void require_file(const std::string& path) const;
  /// Throws Error where there is no such file or where it cannot be read.
  std::string text(const std::string& path) const;
  /// What `read` returns, which may throw.
  std::vector<double> numbers(const std::function<std::vector<double>()>& read) const;

 private:
  std::optional<Comm> comm_;
};

}  // namespace spall
