// Files that appear whole or not at all: written beside their place, then renamed.
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <string>
#include <vector>

#include "spall/comm.hpp"

namespace spall {

/// Where a file is written before it takes its place.
std::string unfinished(const std::string& path);
/// The file that is to be there, of one that may be unfinished.
std::string finished(const std::string& path);

/// What a file that was put in place outlives: the end of the process, or that of the machine too,
/// at the price of waiting for the disk.
enum class Outlives { process, power };

/// Moves the closed file `unfinished(path)` to `path`: whenever the run is killed, `path` is the
/// old file or the new one. This rank alone.
void put_in_place(const std::string& path, Outlives what = Outlives::process);
/// The same by rank 0 for all ranks, which see the file afterwards. Collective.
void put_in_place(const Comm& comm, const std::string& path, Outlives what = Outlives::process);

/// The path below a run's folder of its k-th snapshot, and whether a file of that folder is named
/// like one, whole or unfinished.
std::string snapshot_name(std::size_t k);
bool is_snapshot(const std::filesystem::path& file);

/// A text file that appears whole. This rank alone.
void write_whole(const std::string& path, const std::string& text);
std::string read_whole(const std::string& path);

/// The lines of a text that have an end, without it.
std::vector<std::string> complete_lines(const std::string& text);

/// Makes a folder and those above it by rank 0; an Error names the folder. Collective.
void make_folder(const Comm& comm, const std::string& folder);

}  // namespace spall
