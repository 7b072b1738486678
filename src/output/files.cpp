// A rename outlives the process; fsync of file and folder around it outlives the machine.
// SPDX-License-Identifier: BSD-3-Clause
#include "output/files.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "base/first_rank.hpp"
#include "spall/error.hpp"

namespace spall {

namespace {

constexpr const char* mark = ".unfinished";

void sync(const std::string& path) {
  const int descriptor = open(path.c_str(), O_RDONLY);
  require(descriptor >= 0, "cannot open '{}': {}", path, std::strerror(errno));
  const int code = fsync(descriptor);
  const int reason = errno;
  close(descriptor);
  // A few network file systems refuse to sync a folder: nothing more can be done there.
  require(code == 0 || reason == EINVAL, "cannot sync '{}': {}", path, std::strerror(reason));
}

}  // namespace

std::string unfinished(const std::string& path) {
  return path + mark;
}

std::string finished(const std::string& path) {
  return path.ends_with(mark) ? path.substr(0, path.size() - std::strlen(mark)) : path;
}

std::string snapshot_name(std::size_t k) {
  return fmt::format("snapshots/{:06}.h5", k);
}

bool is_snapshot(const std::filesystem::path& file) {
  const std::filesystem::path name = finished(file.filename().string());
  const std::string number = name.stem().string();
  return name.extension() == ".h5" &&
         std::ranges::all_of(number, [](unsigned char c) { return std::isdigit(c); });
}

void put_in_place(const std::string& path, Outlives what) {
  if (what == Outlives::power) sync(unfinished(path));
  require(std::rename(unfinished(path).c_str(), path.c_str()) == 0, "cannot write '{}': {}", path,
          std::strerror(errno));
  if (what == Outlives::process) return;
  const auto folder = std::filesystem::path(path).parent_path();
  sync(folder.empty() ? "." : folder.string());
}

void put_in_place(const Comm& comm, const std::string& path, Outlives what) {
  check_mpi(MPI_Barrier(comm.raw), "MPI_Barrier");  // every rank has closed the file
  on_first_rank(comm, [&] { put_in_place(path, what); });
}

void write_whole(const std::string& path, const std::string& text) {
  const std::string name = unfinished(path);
  const int descriptor = open(name.c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0666);
  require(descriptor >= 0, "cannot write '{}': {}", path, std::strerror(errno));
  std::size_t done = 0;
  int reason = 0;
  while (done < text.size() && reason == 0) {
    const auto count = ::write(descriptor, text.data() + done, text.size() - done);
    if (count >= 0)
      done += static_cast<std::size_t>(count);
    else if (errno != EINTR)
      reason = errno;
  }
  if (close(descriptor) != 0 && reason == 0) reason = errno;
  require(reason == 0, "cannot write '{}': {}", path, std::strerror(reason));
  put_in_place(path);
}

std::string read_whole(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  require(file.good(), "cannot read '{}': {}", path, std::strerror(errno));
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> complete_lines(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0, end; (end = text.find('\n', at)) != std::string::npos; at = end + 1)
    lines.push_back(text.substr(at, end - at));
  return lines;
}

void make_folder(const Comm& comm, const std::string& folder) {
  on_first_rank(comm, [&] {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    require(!error, "cannot make the folder '{}': {}", folder, error.message());
    require(access(folder.c_str(), W_OK) == 0, "cannot write into the folder '{}': {}", folder,
            std::strerror(errno));
  });
}

}  // namespace spall
